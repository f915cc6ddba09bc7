#include "server/worker/worker.h"

#include "server/base/log.h"
#include "server/base/process.h"
#include "server/base/worker_pool.h"
#include "server/scenes/shader_cache.h"
#include "server/worker/confinement.h"
#include "server/worker/messages.h"

#include "image/bands.h"

#include <sched.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <deque>
#include <unordered_map>

namespace clerestory {
namespace {

constexpr std::chrono::milliseconds kHeartbeatInterval{200};

// Reports to the server which scenes are loaded, from the time when the default scene is warm.
// Thread-safe.
class SceneReporter {
public:
    explicit SceneReporter(MessagePipe& pipe) : pipe_(pipe) {}

    // Sends nothing if nothing has changed. Called before each answer, too, so that the server
    // learns of a change before it receives an answer that depends on it.
    void report(const LocalBackend& backend) {
        const std::lock_guard lock(mutex_);
        if (!warm_) return;
        std::string scenes = packed(*backend.loadedScenes());
        if (scenes == sent_) return;
        pipe_.send({.kind = MessageKind::loaded, .bytes = scenes});
        sent_ = std::move(scenes);
    }
    void setWarm() {
        const std::lock_guard lock(mutex_);
        warm_ = true;
    }

private:
    MessagePipe& pipe_;
    std::mutex mutex_;
    bool warm_ = false;
    std::string sent_;
};

// The cancellation tokens of the calls that are being answered, by the id of the call. Thread-safe.
class CancellationTokens {
public:
    std::shared_ptr<CancellationToken> add(std::uint64_t id) {
        const std::lock_guard lock(mutex_);
        return list_[id] = std::make_shared<CancellationToken>();
    }
    // Remembers the last ones: a frame may be drawn beyond its answer.
    void remove(std::uint64_t id) {
        const std::lock_guard lock(mutex_);
        const auto found = list_.find(id);
        if (found == list_.end()) return;
        answered_.emplace_back(id, std::move(found->second));
        list_.erase(found);
        if (answered_.size() > kAnswered) answered_.pop_front();
    }
    void cancel(std::uint64_t id) {
        std::shared_ptr<CancellationToken> found;
        {
            const std::lock_guard lock(mutex_);
            const auto place = list_.find(id);
            if (place != list_.end()) found = place->second;
        }
        if (found) found->cancel();
    }
    // 0 if it is none of these.
    std::uint64_t idOf(const std::shared_ptr<CancellationToken>& token) const {
        const std::lock_guard lock(mutex_);
        for (const auto& [id, own] : list_) {
            if (own == token) return id;
        }
        for (const auto& [id, own] : answered_) {
            if (own == token) return id;
        }
        return 0;
    }

private:
    static constexpr std::size_t kAnswered = 64;
    mutable std::mutex mutex_;
    std::unordered_map<std::uint64_t, std::shared_ptr<CancellationToken>> list_;
    std::deque<std::pair<std::uint64_t, std::shared_ptr<CancellationToken>>> answered_;
};

// Tells the server that this process lives, whether it is warm, and which scenes it has loaded.
// Ends the process when the renderer hangs, since a thread cannot be ended.
class Heartbeat {
public:
    Heartbeat(MessagePipe& pipe, SceneReporter& reporter, const CancellationTokens& tokens,
              std::chrono::duration<double> hangTime)
        : thread_([this, &pipe, &reporter, &tokens, hangTime] {
              std::unique_lock lock(mutex_);
              bool warm = false;
              Clock::time_point last{};
              while (!ending_) {
                  if (backend_ && backend_->queue().workingFor() > hangTime) {
                      logCritical({"the renderer worked on one thing for ",
                                   fixedPoint(hangTime.count(), 0), " s"});
                      const auto token = backend_->queue().runningToken();
                      pipe.send({.kind = MessageKind::hangs, .id = token ? tokens.idOf(token) : 0});
                      std::_Exit(3);
                  }
                  if (!warm && backend_ && backend_->library().defaultIsWarm()) {
                      warm = true;
                      reporter.setWarm();
                  }
                  const bool compiles = backend_ && backend_->queue().compiledSince(last);
                  last = Clock::now();
                  pipe.send({.kind = warm ? MessageKind::warm : MessageKind::alive,
                             .id = compiles ? kCompiling : 0});
                  if (warm) reporter.report(*backend_);
                  wake_.wait_for(lock, kHeartbeatInterval, [&] { return ending_; });
              }
          }) {}
    ~Heartbeat() {
        {
            const std::lock_guard lock(mutex_);
            ending_ = true;
        }
        wake_.notify_all();
        thread_.join();
    }
    Heartbeat(const Heartbeat&) = delete;
    Heartbeat& operator=(const Heartbeat&) = delete;

    void watch(LocalBackend& backend) {
        const std::lock_guard lock(mutex_);
        backend_ = &backend;
    }

private:
    std::mutex mutex_;
    std::condition_variable wake_;
    LocalBackend* backend_ = nullptr;  // null until it is created
    bool ending_ = false;
    std::thread thread_;
};

Message messageOf(MessageKind kind, std::uint64_t id, std::string bytes) {
    return {.kind = kind, .id = id, .bytes = std::move(bytes)};
}

Message refusalOf(std::uint64_t id, const Problem& problem) {
    return messageOf(MessageKind::refusal, id, packed(problem));
}

// The reply to a frame order or a scene query. Does not throw.
Message replyTo(LocalBackend& backend, const Message& request,
                std::shared_ptr<CancellationToken> cancellation) {
    try {
        if (request.kind == MessageKind::frame) {
            FrameOrder order = unpackedFrameOrder(request.bytes);
            order.cancellation = std::move(cancellation);
            const EncodedFrame frame = backend.draw(order);
            return messageOf(MessageKind::frameAnswer, request.id, packed(frame));
        }
        return messageOf(MessageKind::sceneAnswer, request.id,
                         packed(backend.sceneReport(request.bytes)));
    } catch (const RequestError& error) {
        return refusalOf(request.id, error.problem());
    } catch (const std::exception& error) {
        logError({"a request of the server failed: ", error.what()});
        return refusalOf(request.id, internalError());
    }
}

void serve(LocalBackend& backend, MessagePipe& pipe, SceneReporter& reporter,
           CancellationTokens& tokens, std::size_t threads) {
    WorkerPool pool(threads);
    while (auto message = pipe.receive()) {
        switch (message->kind) {
            case MessageKind::cancel:
                tokens.cancel(message->id);
                break;
            case MessageKind::scenes:
                backend.library().load(unpackedTexts(message->bytes));
                break;
            case MessageKind::role:
                // Without a cache to load them from, programs would be compiled again.
                backend.queue().setStandby(message->id == kIsStandby && keepsShaders());
                break;
            case MessageKind::call: {
                Call call = unpackedCall(message->bytes);
                call.cancellation = tokens.add(message->id);
                pool.run([&, id = message->id, call = std::move(call)] {
                    const Answer answer = backend.answer(call);
                    tokens.remove(id);
                    reporter.report(backend);
                    pipe.send(messageOf(MessageKind::answer, id, packed(answer)));
                });
                break;
            }
            case MessageKind::frame:
            case MessageKind::sceneQuery:
                pool.run(
                    [&, cancellation = tokens.add(message->id), request = *std::move(message)] {
                        const Message reply = replyTo(backend, request, cancellation);
                        tokens.remove(request.id);
                        reporter.report(backend);
                        pipe.send(reply);
                    });
                break;
            default:
                break;
        }
    }
    // The server has ended: nothing waits for an answer any more.
    std::_Exit(0);
}

// Each of several renderers uses its share of the processors: a software driver with one processor
// draws on the thread that calls it.
void shareProcessors(std::size_t renderers) {
    if (renderers < 2) return;
    cpu_set_t allowed;
    const bool known = sched_getaffinity(0, sizeof allowed, &allowed) == 0;
    const auto processors = static_cast<std::size_t>(known ? CPU_COUNT(&allowed) : 1);
    const std::size_t share = std::max<std::size_t>(1, processors / renderers);
    setenv("LP_NUM_THREADS", std::to_string(share > 1 ? share : 0).c_str(), 0);
    limitBandThreads(static_cast<std::uint32_t>(share));
}

}  // namespace

int runWorker(const WorkerOptions& options, const LocalBackendOptions& given) {
    endWithParent();
    shareProcessors(options.renderers);  // before there are other threads
    std::signal(SIGINT, SIG_IGN);        // only the server reacts to them
    std::signal(SIGTERM, SIG_IGN);
    setLogLevel(options.logLevel);
    keepHeapsSmall();
    MessagePipe pipe(kWorkerSocket);
    try {
        confine(options.memoryBytes);  // before there are other threads
    } catch (const std::exception& error) {
        pipe.send({.kind = MessageKind::failed, .bytes = error.what()});
        std::_Exit(2);
    }
    const auto first = pipe.receive();
    if (!first || first->kind != MessageKind::leaveOut) std::_Exit(0);  // the server has ended
    SceneReporter reporter(pipe);
    CancellationTokens tokens;
    Heartbeat heartbeat(pipe, reporter, tokens, std::chrono::duration<double>(options.hangSeconds));
    try {
        endWithoutMemory();
        LocalBackendOptions own = given;
        own.renderer.fewPrograms = compilesFast();
        own.renderer.onReset = [] {
            logCritical({"the GPU was reset: this renderer ends"});
            std::_Exit(4);
        };
        own.work = std::make_shared<BackgroundWork>(
            unpackedTexts(first->bytes),
            [&pipe](std::uint64_t number, const std::string& name, bool begins) {
                const auto kind = begins ? MessageKind::workBegins : MessageKind::workEnds;
                pipe.send(messageOf(kind, number, begins ? name : std::string()));
            });
        LocalBackend backend(own);
        heartbeat.watch(backend);
        const bool fast = compilesFast() && backend.queue().identity().software;
        pipe.send({.kind = MessageKind::ready, .id = fast ? kCompilesFast : 0});
        serve(backend, pipe, reporter, tokens, options.threads);
    } catch (const std::exception& error) {
        pipe.send({.kind = MessageKind::failed, .bytes = error.what()});
    }
    // A half-made backend is not destroyed: that could block.
    std::_Exit(2);
}

}  // namespace clerestory
