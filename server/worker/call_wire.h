// What the server and a worker process send each other <-> bytes. Both are the same program on one
// machine: numbers are sent as they lie in memory, and times are of one clock.
#pragma once

#include "server/api/backend.h"
#include "server/base/call.h"

#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace clerestory {

struct SceneQuery {  // see RenderBackend::sceneReport()
    std::string id;
};

using WorkerRequest = std::variant<Call, FrameOrder, SceneQuery>;
using WorkerReply = std::variant<Answer, EncodedFrame, SceneReport, Problem>;

// Of a call only those headers that some route of the worker reads.
std::string packed(const Call& call);
std::string packed(const FrameOrder& order);
// Of an answer everything but a stream.
std::string packed(const Answer& answer);
std::string packed(const EncodedFrame& frame);
std::string packed(const SceneReport& report);
std::string packed(const Problem& problem);
std::string packed(const std::vector<std::string>& ids);

// All throw std::runtime_error for bytes that packed() did not make.
Call unpackedCall(std::string_view bytes);
FrameOrder unpackedFrameOrder(std::string_view bytes);
Answer unpackedAnswer(std::string_view bytes);
EncodedFrame unpackedFrame(std::string_view bytes);
SceneReport unpackedSceneReport(std::string_view bytes);
Problem unpackedProblem(std::string_view bytes);
std::vector<std::string> unpackedIds(std::string_view bytes);

}  // namespace clerestory
