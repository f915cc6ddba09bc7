// The files of a frame of a sequence: a picture for each channel, and a JSON file with the plan and
// its times. The same for an answer over HTTP and for a folder.
#pragma once

#include "server/api/sequence_request.h"

#include <functional>

namespace clerestory {

struct MadeFrame {
    std::string bytes;
    std::string type;             // media type
    nlohmann::ordered_json plan;  // as of planJson(), with its milliseconds
};
using FrameMaker = std::function<MadeFrame(const FrameRequest& request)>;

struct SequenceFile {
    std::string name, type, bytes;
};

// The beginning of the names of a frame's files: "000012" for frame 12.
std::string frameStem(std::size_t index);

// The pictures first; last "<stem>.json": index, time, the camera's matrices, the files' names, and
// for each channel its plan. Throws what `make` throws.
std::vector<SequenceFile> filesOf(const Sequence& sequence, std::size_t index,
                                  const FrameMaker& make);

// "manifest.json", the last file: for every frame its own JSON file without the plans.
class Manifest {
public:
    void add(const SequenceFile& frameJson);
    // A frame that could not be drawn.
    void addFailure(std::size_t index, const nlohmann::json& problem);
    SequenceFile file() const;

private:
    nlohmann::ordered_json frames_ = nlohmann::ordered_json::array();
    std::size_t failures_ = 0;
};

}  // namespace clerestory
