// The files of a frame of a sequence: a picture for each channel, and a JSON file with the plan and
// its times. The same for an answer over HTTP and for a folder.
#pragma once

#include "server/api/backend.h"
#include "server/api/sequence_request.h"

#include <functional>
#include <optional>

namespace clerestory {

// Draws a frame, with its plan.
using FrameMaker = std::function<EncodedFrame(const FrameRequest& request)>;

struct SequenceFile {
    std::string name, type, bytes;
};

// The beginning of the names of a frame's files: "000012" for frame 12.
std::string frameStem(std::size_t index);

// What the manifest lists of a frame.
struct FrameRecord {
    struct ChannelFile {
        std::string channel, file;
        std::optional<double> milliseconds;
    };
    std::size_t index = 0;
    double time = 0.0;  // seconds
    std::optional<FrameCamera> camera;
    std::vector<ChannelFile> channels;
};

struct FrameFiles {
    std::vector<SequenceFile> files;
    FrameRecord record;
};

// The pictures first; last "<stem>.json": the record, and with Sequence::plans for each channel its
// plan. Throws what `make` throws.
FrameFiles filesOf(const Sequence& sequence, std::size_t index, const FrameMaker& make);

// "manifest.json", the last file: for every frame its own JSON file without the plans.
class Manifest {
public:
    void add(const FrameRecord& record);
    // A frame of an earlier run: `text` is the content of its JSON file.
    void addFromFile(const std::string& text);
    // A frame that could not be drawn.
    void addFailure(std::size_t index, const nlohmann::json& problem);
    SequenceFile file() const;

private:
    nlohmann::ordered_json frames_ = nlohmann::ordered_json::array();
    std::size_t failures_ = 0;
};

}  // namespace clerestory
