#include "server/queue/canary.h"

#include "server/base/log.h"

#include <algorithm>

namespace clerestory {
namespace {

// Cannot be the id of a scene of the library.
const char* const kCanaryScene = "(canary)";
// How long a drawn frame, or a compiled shader, counts as a check.
constexpr std::chrono::seconds kCanaryLifetime{3};
constexpr std::chrono::seconds kCanaryPatience{2};

std::int64_t nowMilliseconds() {
    return std::chrono::ceil<std::chrono::milliseconds>(Clock::now().time_since_epoch()).count();
}

// No surfaces under an environment of radiance 1: every pixel must be white.
Scene canaryScene() {
    Scene scene;
    scene.id = kCanaryScene;
    scene.environment = "white";
    scene.defaultView = DefaultView{};
    updateContentHash(scene);
    return scene;
}

FrameRequest canaryRequest() {
    FrameRequest request;
    request.scene = kCanaryScene;
    request.width = request.height = 4;
    request.toneMap = ToneMap::linear;
    request.accuracy = accuracyOf(Preset::draft);
    return request;
}

}  // namespace

Canary::Canary(RenderQueue& queue) : queue_(queue) {
    queue_.post([](Renderer& renderer) { renderer.addScene(canaryScene()); });
}

void Canary::frameWasDrawn() {
    lastDrawn_ = nowMilliseconds();
}

void Canary::check() {
    // The driver compiles on the renderer's thread, so that a compiled shader shows that both work.
    const auto start = Clock::now();
    if (queue_.compiledSince(start - kCanaryLifetime)) return;
    const std::int64_t age = nowMilliseconds() - lastDrawn_;
    if (age < std::chrono::milliseconds(kCanaryLifetime).count()) return;
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
