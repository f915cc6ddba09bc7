#include "server/service.h"

#include "server/routes.h"

#include <spdlog/spdlog.h>

#include <algorithm>

namespace clerestory {
namespace {

// An id that no scene of the library can have.
const char* const kCanary = "(canary)";
// That may wait or run; each can take minutes.
constexpr std::size_t kLongJobs = 8;
constexpr std::size_t kMostStreams = 16;
constexpr std::chrono::seconds kCanaryLasts{3};
constexpr std::chrono::seconds kCanaryPatience{2};

std::int64_t nowMilliseconds() {
    return std::chrono::ceil<std::chrono::milliseconds>(Clock::now().time_since_epoch()).count();
}

// Nothing under a sky of radiance 1: every pixel must be white.
Scene canaryScene() {
    Scene scene;
    scene.id = kCanary;
    scene.environment = "white";
    scene.defaultView = DefaultView{};
    updateContentHash(scene);
    return scene;
}

FrameRequest canaryRequest() {
    FrameRequest request;
    request.scene = kCanary;
    request.width = request.height = 4;
    request.toneMap = ToneMap::linear;
    request.accuracy = accuracyOf(Preset::draft);
    return request;
}

// Every frame that waits and every stream holds a thread; the others must not wait for it.
FrontOptions frontOptions(const Config& config) {
    FrontOptions options = config.http;
    options.threads += config.queue + kMostStreams;
    return options;
}

}  // namespace

Service::Service(const Config& config)
    : config_(config),
      http_(frontOptions(config_),
            {.quick = [this](const Call& call) { return quickAnswerTo(*this, call); },
             .respond = [this](const Call& call) { return answerTo(*this, call); },
             .refuse = [this](const Call& call,
                              const Problem& problem) { return answerWith(*this, call, problem); },
             .paths = {.open = isOpenPath, .linked = isLinkedPath}}),
      queue_(config_.renderer, {config_.queue, config_.queueSeconds}),
      library_(config_.scenes, queue_),
      streams_(kMostStreams),
      jobs_(kLongJobs) {
    queue_.identity();  // throws when there is no driver
    queue_.post([](Renderer& renderer) { renderer.addScene(canaryScene()); });
}

Service::~Service() {
    stop();
}

void Service::start() {
    listener_ = std::thread([this] { http_.serve(); });
}

void Service::stop() {
    if (!listener_.joinable()) return;
    stopping_ = true;
    queue_.refuseNew();
    http_.stop();
    listener_.join();
}

void Service::frameWasDrawn() {
    lastDrawn_ = nowMilliseconds();
}

void Service::checkCanary() {
    const std::int64_t age = nowMilliseconds() - lastDrawn_;
    if (age < std::chrono::milliseconds(kCanaryLasts).count()) return;
    Image image;
    try {
        image = queue_.run(kCanaryPatience,
                           [](Renderer& r) { return r.render(canaryRequest()).image; });
    } catch (const std::exception& error) {
        spdlog::error("the canary frame failed: {}", error.what());
        throw RequestError(notReady("A canary frame could not be drawn."));
    }
    const bool white = std::all_of(image.data.begin(), image.data.end(),
                                   [](std::byte b) { return b == std::byte{255}; });
    if (!white || image.data.empty()) {
        throw RequestError(notReady("A canary frame came out wrong."));
    }
    frameWasDrawn();
}

}  // namespace clerestory
