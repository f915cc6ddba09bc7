// Messages between the server and a worker process, over a stream socket, and their content as
// bytes. Both are the same program on one machine: numbers are sent as they lie in memory, and
// times are of one clock.
#pragma once

#include "server/api/backend.h"
#include "server/base/call.h"

#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace clerestory {

struct SceneQuery {  // see RenderBackend::sceneReport()
    std::string id;
};

using WorkerRequest = std::variant<Call, FrameOrder, SceneQuery>;
// Null if the request cannot be cancelled.
std::shared_ptr<CancellationToken> cancellationOf(const WorkerRequest& request);
using WorkerReply = std::variant<Answer, EncodedFrame, SceneReport, Problem>;

// Of a call only those headers that some route of the worker reads.
std::string packed(const Call& call);
std::string packed(const FrameOrder& order);
// Of an answer everything but a stream.
std::string packed(const Answer& answer);
std::string packed(const EncodedFrame& frame);
std::string packed(const SceneReport& report);
std::string packed(const Problem& problem);
std::string packed(const std::vector<std::string>& texts);
std::string packed(const LoadedScenes& scenes);

// All throw std::runtime_error for bytes that packed() did not make.
Call unpackedCall(std::string_view bytes);
FrameOrder unpackedFrameOrder(std::string_view bytes);
Answer unpackedAnswer(std::string_view bytes);
EncodedFrame unpackedFrame(std::string_view bytes);
SceneReport unpackedSceneReport(std::string_view bytes);
Problem unpackedProblem(std::string_view bytes);
std::vector<std::string> unpackedTexts(std::string_view bytes);
LoadedScenes unpackedScenes(std::string_view bytes);

enum class MessageKind : std::uint32_t {
    // Server to worker: a request, answered by a message with the same id.
    call,        // Call
    frame,       // FrameOrder
    sceneQuery,  // id of a scene
    cancel,      // the answer of this id is no longer needed
    // Worker to server: the answer to a request.
    answer,       // Answer
    frameAnswer,  // EncodedFrame
    sceneAnswer,  // SceneReport
    refusal,      // Problem
    // Worker to server, about itself.
    alive,   // at a regular interval; id kCompiling if shaders were compiled since the last one
    ready,   // requests are answered from now on; id kCompilesFast if shaders are not optimised
    warm,    // as alive; the shaders of the default scene are compiled
    failed,  // it cannot start and ends; with a message for users
    loaded,  // LoadedScenes, after a change, before any answer that depends on the change
    // Worker to server: background work begins, with its name, or ends; of the same id.
    workBegins,
    workEnds,
    // Server to worker, before all others: names of background work that is left out.
    leaveOut,
    // Server to worker: ids of scenes to load.
    scenes,
    // Server to worker: whether it is a standby (id kIsStandby), which draws nothing for now. At
    // the
    // start it is none.
    role,
    // Worker to server: it ends because its renderer hangs; the id of the request that it draws, 0
    // if unknown.
    hangs
};

inline constexpr std::uint64_t kCompiling = 1;
inline constexpr std::uint64_t kCompilesFast = 1;
inline constexpr std::uint64_t kIsStandby = 1;

struct Message {
    MessageKind kind = MessageKind::alive;
    std::uint64_t id = 0;
    std::string bytes;
};

class MessagePipe {
public:
    explicit MessagePipe(int socket) : socket_(socket) {}
    ~MessagePipe();
    MessagePipe(const MessagePipe&) = delete;
    MessagePipe& operator=(const MessagePipe&) = delete;

    // Returns false if the other side has ended. Thread-safe; waits while the other side does not
    // read.
    bool send(const Message& message);
    // Sends a message without bytes, unless this would block. Thread-safe.
    void trySend(MessageKind kind, std::uint64_t id);
    // Empty if the other side has ended or sent a malformed message. For one thread.
    std::optional<Message> receive();
    // Ends all present and future calls of send() and receive(), on both sides.
    void shut();

private:
    bool writeAll(const char* bytes, std::size_t size);
    bool readAll(char* bytes, std::size_t size);

    const int socket_;
    std::mutex sending_;
};

}  // namespace clerestory
