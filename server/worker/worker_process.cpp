#include "server/worker/worker_process.h"

#include "server/scenes/shader_cache.h"
#include "server/worker/call_wire.h"
#include "server/worker/confinement.h"
#include "server/worker/worker.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

extern char** environ;

namespace clerestory {
namespace {

std::runtime_error failure(const char* what) {
    return std::runtime_error(std::string("the render worker: ") + what + " failed");
}

// The worker's end of the pipe becomes kWorkerSocket; no other descriptor reaches it but the
// standard streams, so that its log joins ours.
pid_t spawned(const WorkerProgram& worker, int socket, bool compileFast) {
    const std::filesystem::path program =
        worker.file.empty() ? std::filesystem::path("/proc/self/exe") : worker.file;
    std::vector<std::string> words = {"clerestory", kWorkerCommand};
    words.insert(words.end(), worker.arguments.begin(), worker.arguments.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);

    std::string fast = kCompileFastVariable;
    std::vector<char*> environment;
    for (char** variable = environ; *variable; ++variable) environment.push_back(*variable);
    if (compileFast) environment.push_back(fast.data());
    environment.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, socket, kWorkerSocket);
    posix_spawn_file_actions_addclosefrom_np(&actions, kWorkerSocket + 1);
    posix_spawnattr_t attributes;
    posix_spawnattr_init(&attributes);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    // Ctrl-C at a terminal is for the front alone, which still needs its workers then.
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
    pid_t id = -1;
    const int status = posix_spawn(&id, program.c_str(), &actions, &attributes, arguments.data(),
                                   environment.data());
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    if (status != 0) throw failure("starting it");
    return id;
}

}  // namespace

WorkerProcess::WorkerProcess(const WorkerProgram& program, std::uint64_t number, bool compileFast)
    : silence_(program.silence), number_(number), compilesFast_(compileFast) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) throw failure("a socket");
    pipe_ = std::make_unique<MessagePipe>(ends[0]);
    // dup2 onto the same number would keep close-on-exec.
    const int far = fcntl(ends[1], F_DUPFD_CLOEXEC, kWorkerSocket + 1);
    close(ends[1]);
    if (far < 0) throw failure("a descriptor");
    try {
        id_ = spawned(program, far, compileFast);
    } catch (...) {
        close(far);
        throw;
    }
    close(far);
    listener_ = std::thread([this] { listen(); });
    watcher_ = std::thread([this] { watch(); });
}

WorkerProcess::~WorkerProcess() {
    pipe_->shut();
    listener_.join();
    watcher_.join();
}

void WorkerProcess::awaitStanding() {
    stands_.get();
}

std::optional<Answer> WorkerProcess::ask(const Call& call) {
    Message message{.kind = MessageKind::call, .bytes = packed(call)};
    std::future<std::optional<Answer>> answer;
    std::uint64_t id = 0;
    {
        const std::lock_guard lock(mutex_);
        if (ended_) return std::nullopt;
        id = nextId_++;
        answer = waiting_[id].get_future();
    }
    message.id = id;
    pipe_->send(message);
    if (call.cancellation) {
        call.cancellation->onCancel([this, id] { pipe_->trySend(MessageKind::cancel, id); });
    }
    auto result = answer.get();
    if (call.cancellation) call.cancellation->onCancel(nullptr);
    if (result) result->headers.emplace_back(kWorkerHeader, std::to_string(number_));
    return result;
}

std::vector<std::string> WorkerProcess::scenes() {
    const std::lock_guard lock(mutex_);
    return scenes_;
}

void WorkerProcess::hold(const std::vector<std::string>& scenes) {
    pipe_->send({.kind = MessageKind::scenes, .bytes = packed(scenes)});
}

// The listener's thread: until the worker ends, which closes its end, or somebody shuts ours.
void WorkerProcess::listen() {
    bool sound = true;
    try {
        while (sound) {
            auto message = pipe_->receive();
            if (!message) break;
            sound = heard(*message);
        }
    } catch (const std::exception&) {  // no answer at all, or no memory for it
        sound = false;
    }
    end(!sound);
}

// False for what no worker of ours says.
bool WorkerProcess::heard(const Message& message) {
    // Before it is taken from those that wait: what cannot be read leaves it with the others.
    std::optional<Answer> answer;
    if (message.kind == MessageKind::answer) answer = unpackedAnswer(message.bytes);
    std::vector<std::string> scenes;
    if (message.kind == MessageKind::scenes) scenes = unpackedIds(message.bytes);
    std::promise<std::optional<Answer>> promise;
    {
        const std::lock_guard lock(mutex_);
        lastHeard_ = Clock::now();
        if (message.kind == MessageKind::scenes) scenes_ = std::move(scenes);
        if (message.kind == MessageKind::failed) lastWords_ = message.bytes;
        if (answer) {
            const auto found = waiting_.find(message.id);
            if (found == waiting_.end()) return false;  // it answers twice
            promise = std::move(found->second);
            waiting_.erase(found);
        }
    }
    if (message.kind == MessageKind::warm) warm_ = true;
    if (message.kind == MessageKind::standing) {
        if (stands_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) return false;
        standing_.set_value();
    }
    if (answer) promise.set_value(std::move(answer));
    return true;
}

void WorkerProcess::end(bool byUs) {
    kill(id_, SIGKILL);
    pipe_->shut();
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    killed_ = !byUs && !silent_ && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
    std::unordered_map<std::uint64_t, std::promise<std::optional<Answer>>> unanswered;
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
        unanswered.swap(waiting_);
    }
    ending_.notify_all();
    for (auto& [id, promise] : unanswered) promise.set_value(std::nullopt);
    if (stands_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        const bool noMemory = WIFEXITED(status) && WEXITSTATUS(status) == kEndedWithoutMemory;
        if (lastWords_.empty()) {
            lastWords_ = noMemory ? "the render worker had too little memory to start"
                                  : "the render worker ended before it stood";
        }
        standing_.set_exception(std::make_exception_ptr(std::runtime_error(lastWords_)));
    }
}

// The watcher's thread: a worker that does not even beat is stopped, or so starved that another one
// is better.
void WorkerProcess::watch() {
    std::unique_lock lock(mutex_);
    while (!ended_) {
        // Not a moment later than that: somebody waits for what it would have answered.
        const auto until = lastHeard_ + silence_;
        if (ending_.wait_until(lock, until, [&] { return ended_.load(); })) return;
        const auto now = Clock::now();
        // When this process slept, the machine did, and the worker has had no time to speak either.
        if (now > until + silence_ / 4) lastHeard_ = now;
        if (lastHeard_ + silence_ > now) continue;
        silent_ = true;
        pipe_->shut();
        ending_.wait(lock, [&] { return ended_.load(); });
    }
}

}  // namespace clerestory
