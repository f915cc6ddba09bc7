#include "server/worker/worker_process.h"

#include "server/scenes/shader_cache.h"
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

constexpr std::size_t kMaxFingerprints = 256;
// More pieces of background work at once than any sound worker has.
constexpr std::size_t kMaxWork = 64;

std::runtime_error failure(const char* what) {
    return std::runtime_error(std::string("the render worker: ") + what + " failed");
}

// The worker inherits its end of the pipe as kWorkerSocket, and the standard streams, so that its
// log goes to ours; no other descriptor.
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
    // Ctrl-C at a terminal must reach only the server, which still needs its workers.
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

Message messageOf(const WorkerRequest& request) {
    if (const auto* call = std::get_if<Call>(&request)) {
        return {.kind = MessageKind::call, .bytes = packed(*call)};
    }
    if (const auto* order = std::get_if<FrameOrder>(&request)) {
        return {.kind = MessageKind::frame, .bytes = packed(*order)};
    }
    return {.kind = MessageKind::sceneQuery, .bytes = std::get<SceneQuery>(request).id};
}

// Empty for a message that is no reply. Throws std::runtime_error for a malformed one.
std::optional<WorkerReply> replyIn(const Message& message) {
    switch (message.kind) {
        case MessageKind::answer:
            return unpackedAnswer(message.bytes);
        case MessageKind::frameAnswer:
            return unpackedFrame(message.bytes);
        case MessageKind::sceneAnswer:
            return unpackedSceneReport(message.bytes);
        case MessageKind::refusal:
            return unpackedProblem(message.bytes);
        default:
            return std::nullopt;
    }
}

}  // namespace

WorkerProcess::WorkerProcess(const WorkerProgram& program, std::uint64_t number, bool compileFast,
                             const std::vector<std::string>& leftOut)
    : silence_(program.silence), start_(program.start), number_(number) {
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
    pipe_->send({.kind = MessageKind::leaveOut, .bytes = packed(leftOut)});
    listener_ = std::thread([this] { listen(); });
    watcher_ = std::thread([this] { watch(); });
}

WorkerProcess::~WorkerProcess() {
    pipe_->shut();
    listener_.join();
    watcher_.join();
}

void WorkerProcess::awaitReady() {
    if (ready_.wait_for(start_) != std::future_status::ready) {
        throw std::runtime_error("the render worker was not ready " +
                                 std::to_string(start_.count() / 1000) +
                                 " seconds after its start");
    }
    ready_.get();
}

std::optional<WorkerReply> WorkerProcess::ask(const WorkerRequest& request,
                                              std::uint64_t fingerprint) {
    Message message = messageOf(request);
    std::future<std::optional<WorkerReply>> reply;
    {
        const std::lock_guard lock(mutex_);
        if (ended_) return std::nullopt;
        message.id = nextId_++;
        reply = waiting_[message.id].get_future();
        if (fingerprint != 0) fingerprints_[message.id] = fingerprint;
        if (fingerprints_.size() > kMaxFingerprints) fingerprints_.erase(fingerprints_.begin());
    }
    pipe_->send(message);
    const auto token = cancellationOf(request);
    if (token) {
        token->onCancel([this, id = message.id] { pipe_->trySend(MessageKind::cancel, id); });
    }
    auto result = reply.get();
    if (token) token->onCancel(nullptr);
    if (!result) return result;
    if (auto* answer = std::get_if<Answer>(&*result)) answer->worker = number_;
    if (auto* report = std::get_if<SceneReport>(&*result)) report->worker = number_;
    return result;
}

std::vector<std::string> WorkerProcess::scenes() const {
    std::vector<std::string> ids;
    if (const auto loaded = loadedScenes()) {
        for (const auto& [id, hash] : loaded->scenes) ids.push_back(id);
    }
    return ids;
}

std::shared_ptr<const LoadedScenes> WorkerProcess::loadedScenes() const {
    const std::lock_guard lock(mutex_);
    return loaded_;
}

std::vector<std::string> WorkerProcess::work() const {
    std::vector<std::string> names;
    const std::lock_guard lock(mutex_);
    for (const auto& [number, name] : work_) names.push_back(name);
    return names;
}

void WorkerProcess::loadScenes(const std::vector<std::string>& scenes) {
    pipe_->send({.kind = MessageKind::scenes, .bytes = packed(scenes)});
}

void WorkerProcess::setStandby(bool standby) {
    if (std::exchange(standby_, standby) == standby) return;
    pipe_->send({.kind = MessageKind::role, .id = standby ? kIsStandby : 0});
}

// The listener's thread: until the worker ends, which closes its end, or the pipe is shut down.
void WorkerProcess::listen() {
    bool sound = true;
    try {
        while (sound) {
            auto message = pipe_->receive();
            if (!message) break;
            sound = handle(*message);
        }
    } catch (const std::exception&) {  // a malformed message, or no memory for it
        sound = false;
    }
    end(!sound);
}

// Returns false for a message that no sound worker sends.
bool WorkerProcess::handle(const Message& message) {
    // First, since it can throw: then the request stays among those that wait.
    std::optional<WorkerReply> reply = replyIn(message);
    std::shared_ptr<const LoadedScenes> loaded;
    if (message.kind == MessageKind::loaded) {
        loaded = std::make_shared<const LoadedScenes>(unpackedScenes(message.bytes));
    }
    std::promise<std::optional<WorkerReply>> promise;
    {
        const std::lock_guard lock(mutex_);
        lastHeard_ = Clock::now();
        if (loaded) loaded_ = std::move(loaded);
        const auto hung = fingerprints_.find(message.id);
        if (message.kind == MessageKind::hangs && hung != fingerprints_.end()) {
            hungOn_ = hung->second;
        }
        if (message.kind == MessageKind::failed) failure_ = message.bytes;
        if (message.kind == MessageKind::workBegins) work_[message.id] = message.bytes;
        if (message.kind == MessageKind::workEnds) work_.erase(message.id);
        if (work_.size() > kMaxWork) return false;
        if (reply) {
            const auto found = waiting_.find(message.id);
            if (found == waiting_.end()) return false;  // a second answer
            promise = std::move(found->second);
            waiting_.erase(found);
        }
    }
    if (message.kind == MessageKind::warm) warm_ = true;
    if (message.kind == MessageKind::warm || message.kind == MessageKind::alive) {
        compiling_ = message.id == kCompiling;
    }
    if (message.kind == MessageKind::ready) {
        if (ready_.wait_for(std::chrono::seconds(0)) == std::future_status::ready) return false;
        compilesFast_ = message.id == kCompilesFast;
        readyPromise_.set_value();
    }
    if (reply) promise.set_value(std::move(reply));
    return true;
}

void WorkerProcess::end(bool byUs) {
    kill(id_, SIGKILL);
    pipe_->shut();
    int status = 0;
    while (waitpid(id_, &status, 0) < 0 && errno == EINTR) {
    }
    killed_ = !byUs && !silent_ && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL;
    std::unordered_map<std::uint64_t, std::promise<std::optional<WorkerReply>>> unanswered;
    {
        const std::lock_guard lock(mutex_);
        ended_ = true;
        unanswered.swap(waiting_);
    }
    ending_.notify_all();
    for (auto& [id, promise] : unanswered) promise.set_value(std::nullopt);
    if (ready_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
        const bool noMemory = WIFEXITED(status) && WEXITSTATUS(status) == kEndedWithoutMemory;
        if (failure_.empty()) {
            failure_ = noMemory ? "the render worker had too little memory to start"
                                : "the render worker ended before it was ready";
        }
        readyPromise_.set_exception(std::make_exception_ptr(std::runtime_error(failure_)));
    }
}

// The watcher's thread: kills a worker that sends nothing; it hangs, or gets too little time.
void WorkerProcess::watch() {
    std::unique_lock lock(mutex_);
    while (!ended_) {
        const auto until = lastHeard_ + silence_;
        if (ending_.wait_until(lock, until, [&] { return ended_.load(); })) return;
        const auto now = Clock::now();
        // If this thread slept much longer, the whole machine was suspended, and the worker had no
        // time either.
        if (now > until + silence_ / 4) lastHeard_ = now;
        if (lastHeard_ + silence_ > now) continue;
        silent_ = true;
        pipe_->shut();
        ending_.wait(lock, [&] { return ended_.load(); });
    }
}

}  // namespace clerestory
