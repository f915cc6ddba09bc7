// A frame of a sequence -> its files: a picture for each channel, and what was drawn and how long
// it took as JSON. The same for an answer over HTTP and for a folder.
#pragma once

#include "server/api/sequence_request.h"

#include <functional>

namespace clerestory {

struct MadeFrame {
    std::string bytes;
    std::string type;             // media type
    nlohmann::ordered_json plan;  // as of planJson(), with its milliseconds
};
// Draws the body of a POST /v1/frames.
using FrameMaker = std::function<MadeFrame(const nlohmann::json& body)>;

struct SequenceFile {
    std::string name, type, bytes;
};

// "000012"; what the names of frame 12's files begin with.
std::string frameStem(std::size_t index);

// The pictures first; last "<stem>.json": index, time, the camera's matrices, the files' names, and
// for each channel its plan. Throws what `make` throws.
std::vector<SequenceFile> filesOf(const Sequence& sequence, std::size_t index,
                                  const FrameMaker& make);

// "manifest.json", once all is drawn: for every frame what its own JSON says without the plans.
class Manifest {
public:
    void add(const SequenceFile& frameJson);
    // A frame that could not be drawn; the others go on.
    void addFailure(std::size_t index, const nlohmann::json& problem);
    SequenceFile file() const;

private:
    nlohmann::ordered_json frames_ = nlohmann::ordered_json::array();
    std::size_t failures_ = 0;
};

}  // namespace clerestory
