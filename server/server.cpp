#include "server/server.h"

#include "server/api/server_routes.h"
#include "server/api/service_routes.h"

namespace clerestory {
namespace {

constexpr std::size_t kMaxStreams = 16;

// Every frame that waits and every stream holds a thread; the others must not wait for it.
HttpServerOptions httpServerOptions(const Config& config) {
    HttpServerOptions options = config.http;
    options.threads += config.queue + kMaxStreams;
    options.limits.large.push_back({"POST", "/v1/sequences", config.sequenceBytes});
    const UploadOptions& uploads = config.scenes.uploads;
    if (!uploads.folder.empty()) {
        options.limits.large.push_back({"POST", "/v1/scenes", uploads.limits.fileBytes});
        options.limits.largeBytes = std::max(options.limits.largeBytes, uploads.limits.fileBytes);
    }
    return options;
}

}  // namespace

Server::Server(const Config& config)
    : streams_(kMaxStreams),
      uploadLimits_(config.scenes.uploads.import),
      http_(httpServerOptions(config),
            {.quick = [this](const Call& call) { return quickAnswerTo(*this, call); },
             .respond = [this](const Call& call) { return answerTo(*this, call); },
             .refuse = [this](const Call& call,
                              const Problem& problem) { return answerWith(*this, call, problem); },
             .paths = {.open = isOpenPath, .linked = isLinkedPath}}) {
    const UploadOptions& uploads = config.scenes.uploads;
    if (!uploads.folder.empty()) uploads_.emplace(uploads.folder, uploads.limits);
    if (config.singleProcess) {
        service_ = std::make_unique<Service>(config);
    } else {
        supervisor_ = std::make_unique<Supervisor>(config.workers);
    }
}

Server::~Server() {
    stop();
}

void Server::start() {
    listener_ = std::thread([this] { http_.serve(); });
}

void Server::stop() {
    if (!listener_.joinable()) return;
    stopping_ = true;
    if (service_) service_->refuseNew();
    http_.stop();
    listener_.join();
}

Answer Server::ask(const Call& call) {
    if (service_) return answerTo(*service_, call);
    if (stopping_) throw RequestError(shuttingDown());
    const auto ofWorker = [this](const Call& asked) { return supervisor_->ask(asked); };
    if (!takesTurn(call)) return jobs_.ask(call, ofWorker);
    const OverloadCache::Moment begun = overloadCache_.begin();
    Answer answer = ofWorker(call);
    overloadCache_.end(begun, call.client, answer, Clock::now());
    return answer;
}

std::optional<Problem> Server::refusalFor(const Call& call) const {
    if (service_) return service_->queue().refusalFor(call.client);
    return overloadCache_.refusalFor(call.client, Clock::now());
}

bool takesTurn(const Call& call) {
    return call.path == "/v1/frames" || call.path == "/v1/plans";
}

}  // namespace clerestory
