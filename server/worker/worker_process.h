// One render worker as the front sees it: a process that answers calls until it ends.
#pragma once

#include "server/base/call.h"
#include "server/worker/message_pipe.h"

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <future>
#include <optional>
#include <set>
#include <thread>
#include <unordered_map>

#include <sys/types.h>

namespace clerestory {

struct WorkerProgram {
    std::filesystem::path file;          // empty: this program
    std::vector<std::string> arguments;  // those of `clerestory serve`
    // A worker that says nothing for so long, not even that it lives, is killed.
    std::chrono::milliseconds silence{3000};
};

// Of every answer of a worker: its number.
inline constexpr const char* kWorkerHeader = "Clerestory-Worker";

class WorkerProcess {
public:
    // `number`: which of its front's workers it is, from 1. Throws std::runtime_error when no
    // process can be made.
    // `compileFast`: its driver compiles shaders without optimising (server/scenes/shader_cache.h).
    WorkerProcess(const WorkerProgram& program, std::uint64_t number, bool compileFast = false);
    ~WorkerProcess();  // kills it
    WorkerProcess(const WorkerProcess&) = delete;
    WorkerProcess& operator=(const WorkerProcess&) = delete;

    // Waits until it answers calls. Throws std::runtime_error with its own words when it cannot.
    void awaitStanding();

    // Nothing: it ended before it answered.
    std::optional<Answer> ask(const Call& call);

    // The scenes it holds, the one that was used last at the end.
    std::vector<std::string> scenes();
    // Has it load these, too, in time.
    void hold(const std::vector<std::string>& scenes);

    bool warm() const { return warm_; }  // its first scene can be drawn at once
    bool alive() const { return !ended_; }
    bool wasSilent() const { return silent_; }  // killed for that
    // Ended by a signal that nobody can send to himself by mistake, and that we did not send.
    bool wasKilled() const { return killed_; }
    pid_t id() const { return id_; }
    std::uint64_t number() const { return number_; }
    bool compilesFast() const { return compilesFast_; }

private:
    void listen();
    bool heard(const Message& message);
    void watch();
    void end(bool byUs);

    const std::chrono::milliseconds silence_;
    const std::uint64_t number_;
    const bool compilesFast_;
    pid_t id_ = -1;
    std::unique_ptr<MessagePipe> pipe_;
    std::promise<void> standing_;
    std::shared_future<void> stands_{standing_.get_future().share()};
    std::mutex mutex_;
    std::condition_variable ending_;
    std::unordered_map<std::uint64_t, std::promise<std::optional<Answer>>> waiting_;
    std::uint64_t nextId_ = 1;
    std::string lastWords_;
    std::vector<std::string> scenes_;
    std::atomic<bool> ended_{false}, warm_{false}, silent_{false}, killed_{false};
    Clock::time_point lastHeard_ = Clock::now();
    std::thread listener_, watcher_;
};

}  // namespace clerestory
