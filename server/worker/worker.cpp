#include "server/worker/worker.h"

#include "server/api/service_routes.h"
#include "server/base/log.h"
#include "server/base/worker_pool.h"
#include "server/service.h"
#include "server/worker/call_wire.h"
#include "server/worker/confinement.h"
#include "server/worker/message_pipe.h"

#include <csignal>
#include <cstdlib>

namespace clerestory {
namespace {

constexpr std::chrono::milliseconds kBeat{200};

// Says that this process lives, is warm, and which scenes it holds; and ends it when the renderer
// works on one thing for too long, which no thread of a process can end.
class Heartbeat {
public:
    Heartbeat(MessagePipe& pipe, std::chrono::duration<double> longest)
        : thread_([this, &pipe, longest] {
              std::unique_lock lock(mutex_);
              bool warm = false;
              while (!ending_) {
                  if (service_ && service_->queue().workingFor() > longest) {
                      logCritical({"the renderer worked on one thing for ",
                                   fixedPoint(longest.count(), 0), " s"});
                      std::_Exit(3);
                  }
                  warm = warm || (service_ && service_->library().defaultIsWarm());
                  pipe.send({.kind = warm ? MessageKind::warm : MessageKind::beat});
                  if (warm) tellScenes(pipe);
                  wake_.wait_for(lock, kBeat, [&] { return ending_; });
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

    void watch(Service& service) {
        const std::lock_guard lock(mutex_);
        service_ = &service;
    }

private:
    void tellScenes(MessagePipe& pipe) {
        std::string held = packed(service_->library().held());
        if (held == told_) return;
        pipe.send({.kind = MessageKind::scenes, .bytes = held});
        told_ = std::move(held);
    }

    std::mutex mutex_;
    std::condition_variable wake_;
    Service* service_ = nullptr;
    std::string told_;
    bool ending_ = false;
    std::thread thread_;
};

// The cancellation tokens of the calls that are being answered, by the id of the call.
class CancellationTokens {
public:
    std::shared_ptr<CancellationToken> add(std::uint64_t id) {
        const std::lock_guard lock(mutex_);
        return list_[id] = std::make_shared<CancellationToken>();
    }
    void remove(std::uint64_t id) {
        const std::lock_guard lock(mutex_);
        list_.erase(id);
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

private:
    std::mutex mutex_;
    std::unordered_map<std::uint64_t, std::shared_ptr<CancellationToken>> list_;
};

void serve(Service& service, MessagePipe& pipe, std::size_t threads) {
    CancellationTokens tokens;
    WorkerPool pool(threads);
    while (auto message = pipe.receive()) {
        if (message->kind == MessageKind::cancel) tokens.cancel(message->id);
        if (message->kind == MessageKind::scenes)
            service.library().hold(unpackedIds(message->bytes));
        if (message->kind != MessageKind::call) continue;
        Call call = unpackedCall(message->bytes);
        call.cancellation = tokens.add(message->id);
        pool.run([&service, &pipe, &tokens, id = message->id, call = std::move(call)] {
            const Answer answer = answerTo(service, call);
            tokens.remove(id);
            pipe.send({.kind = MessageKind::answer, .id = id, .bytes = packed(answer)});
        });
    }
    // The front has ended, and with it everybody who waits for an answer.
    std::_Exit(0);
}

}  // namespace

int runWorker(const Config& config) {
    endWithParent();
    std::signal(SIGINT, SIG_IGN);  // the front alone is told to stop
    std::signal(SIGTERM, SIG_IGN);
    setLogLevel(config.logLevel);
    MessagePipe pipe(kWorkerSocket);
    Heartbeat beating(pipe, std::chrono::duration<double>(config.hangSeconds));
    try {
        confine(config.workerMemoryBytes);
        endWithoutMemory();
        Config own = config;
        own.renderer.whenReset = [] {
            logCritical({"the GPU was reset: this renderer ends"});
            std::_Exit(4);
        };
        Service service(own);
        beating.watch(service);
        pipe.send({.kind = MessageKind::standing});
        serve(service, pipe, config.queue + config.http.threads);
    } catch (const std::exception& error) {
        pipe.send({.kind = MessageKind::failed, .bytes = error.what()});
    }
    // What a half-made service holds is not worth an orderly end.
    std::_Exit(2);
}

}  // namespace clerestory
