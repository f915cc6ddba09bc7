// One worker process as the server sees it: it answers requests until it ends.
#pragma once

#include "server/base/call.h"
#include "server/worker/messages.h"

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <future>
#include <map>
#include <optional>
#include <set>
#include <thread>
#include <unordered_map>

#include <sys/types.h>

namespace clerestory {

struct WorkerProgram {
    std::filesystem::path file;          // empty: this program
    std::vector<std::string> arguments;  // those of `clerestory serve`
    // A worker that sends nothing for this long, not even MessageKind::alive, is killed.
    std::chrono::milliseconds silence{3000};
    // From its start until it answers requests; then it is killed, even if it sends
    // MessageKind::alive.
    std::chrono::milliseconds start{120000};
};

class WorkerProcess {
public:
    // `number`: workers of a server are numbered from 1. `compileFast`: a software driver compiles
    // shaders without optimisation (server/scenes/shader_cache.h). `leftOut`: names of background
    // work that does not begin. Throws std::runtime_error if no process can be started.
    WorkerProcess(const WorkerProgram& program, std::uint64_t number, bool compileFast = false,
                  const std::vector<std::string>& leftOut = {});
    ~WorkerProcess();  // kills it
    WorkerProcess(const WorkerProcess&) = delete;
    WorkerProcess& operator=(const WorkerProcess&) = delete;

    // Waits until it answers requests. Throws std::runtime_error with its own message if it cannot
    // start.
    void awaitReady();

    // Empty if the process ended before it answered. `fingerprint`: for hungOn(); 0: none.
    std::optional<WorkerReply> ask(const WorkerRequest& request, std::uint64_t fingerprint = 0);

    // Ids of the scenes that it has loaded, the most recently used one last.
    std::vector<std::string> scenes() const;
    // Null until it is warm.
    std::shared_ptr<const LoadedScenes> loadedScenes() const;
    // Requests that it loads these scenes when it is idle.
    void loadScenes(const std::vector<std::string>& scenes);
    // Tells it whether it is a standby, unless it knows. For one thread at a time.
    void setStandby(bool standby);

    bool warm() const { return warm_; }            // the shaders of the default scene are compiled
    bool compiling() const { return compiling_; }  // shaders, now or a moment ago
    bool alive() const { return !ended_; }
    // The request on which its renderer hung, answered or not; 0 if it did not hang.
    std::uint64_t hungOn() const { return hungOn_; }
    // Names of the background work that is in progress, or was when it ended.
    std::vector<std::string> work() const;
    bool wasSilent() const { return silent_; }  // it was killed because it sent nothing
    // It was ended by SIGKILL from outside, such as for lack of memory.
    bool wasKilled() const { return killed_; }
    pid_t id() const { return id_; }
    std::uint64_t number() const { return number_; }
    bool compilesFast() const { return compilesFast_; }  // known when it is ready

private:
    void listen();
    bool handle(const Message& message);
    void watch();
    void end(bool byUs);

    const std::chrono::milliseconds silence_, start_;
    const std::uint64_t number_;
    pid_t id_ = -1;
    std::unique_ptr<MessagePipe> pipe_;
    std::promise<void> readyPromise_;
    std::shared_future<void> ready_{readyPromise_.get_future().share()};
    mutable std::mutex mutex_;
    std::condition_variable ending_;
    std::unordered_map<std::uint64_t, std::promise<std::optional<WorkerReply>>> waiting_;
    std::map<std::uint64_t, std::uint64_t> fingerprints_;  // of the last requests, by id
    std::atomic<std::uint64_t> hungOn_{0};
    std::uint64_t nextId_ = 1;
    std::string failure_;  // why it could not start
    std::shared_ptr<const LoadedScenes> loaded_;
    std::map<std::uint64_t, std::string> work_;  // background work in progress, by number
    bool standby_ = false;
    std::atomic<bool> ended_{false}, warm_{false}, compiling_{false}, silent_{false},
        killed_{false}, compilesFast_{false};
    Clock::time_point lastHeard_ = Clock::now();
    std::thread listener_, watcher_;
};

}  // namespace clerestory
