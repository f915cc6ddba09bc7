#include "server/service.h"

#include "server/base/log.h"

#include <algorithm>

namespace clerestory {
namespace {

// An id that no scene of the library can have.
const char* const kCanary = "(canary)";
// That may wait or run; each can take minutes.
constexpr std::size_t kLongJobs = 8;
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

}  // namespace

Service::Service(const Config& config)
    : config_(config),
      queue_(config_.renderer, {config_.queue, config_.queueSeconds}),
      library_(config_.scenes, queue_, config_.renderer),
      jobs_(kLongJobs) {
    queue_.identity();  // throws when there is no driver
    queue_.post([](Renderer& renderer) { renderer.addScene(canaryScene()); });
}

void Service::frameWasDrawn() {
    lastDrawn_ = nowMilliseconds();
}

void Service::checkCanary() {
    // The driver compiles on the renderer's thread: both live.
    const auto start = Clock::now();
    if (queue_.compiledSince(start - kCanaryLasts)) return;
    const std::int64_t age = nowMilliseconds() - lastDrawn_;
    if (age < std::chrono::milliseconds(kCanaryLasts).count()) return;
    Image image;
    try {
        image = queue_.run(
            Turn{.patience = kCanaryPatience, .compilePatience = std::chrono::seconds(0)},
            [](Renderer& r) { return r.render(canaryRequest()).image; });
    } catch (const std::exception& error) {
        if (queue_.compiledSince(start)) return;
        logError({"the canary frame failed: ", error.what()});
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
