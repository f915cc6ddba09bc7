// Draws and plans frames: finds the scene, replaces a budget by settings, waits in the render
// queue, encodes, counts. Knows no HTTP. Thread-safe.
#pragma once

#include "image/image.h"
#include "plan/effects/surface_light.h"
#include "renderer.h"
#include "server/api/metrics.h"
#include "server/jobs/budgets.h"
#include "server/queue/render_queue.h"
#include "server/scenes/scene_library.h"

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clerestory {

// Everything that can change a byte of the request's frame, as text: the request, and the contents
// of what it names. parts: those of FrameRequest::parts.
std::string contentText(const RenderQueue& queue, const SceneLibrary& library, const Scene& scene,
                        std::span<const std::shared_ptr<const Scene>> parts,
                        const FrameRequest& request);

// The part of it that does not depend on the request: the program and the driver.
std::string rendererText(const RenderQueue& queue);

// Frames of one kind take about the same time: they differ in the camera, the time or the output.
std::uint64_t kindOf(FrameRequest request);

// The turn of a call that arrived then: the rest of the deadline, or of `limit` if it is less.
Turn turnFor(Clock::time_point arrived, double deadlineSeconds,
             std::optional<std::chrono::milliseconds> limit = {});
inline constexpr std::uint64_t kPlanKind = 1;  // Turn::kind of a plan

class FrameService {
public:
    // What it uses; all of it must outlive the service.
    struct Components {
        RenderQueue& queue;
        SceneLibrary& library;
        Budgets& budgets;
        Metrics& metrics;
        Canary& canary;
    };
    struct Limits {
        double deadlineSeconds = 10.0;  // from the arrival of a request to its answer
        std::uint64_t mostSamples = 0;  // that a frame may shade; 0: any number
    };
    // A request that can be drawn.
    struct Resolved {
        FrameRequest request;                // with the id of its scene, and without a budget
        std::shared_ptr<const Scene> scene;  // stays loaded as long as this exists
        std::vector<std::shared_ptr<const Scene>> parts;  // those of FrameRequest::parts, likewise
        EnvironmentLibrary::Leases maps;                  // uploaded ones that it names, likewise
        std::optional<Budgets::Pick> pick;                // of the request's budget
    };
    struct Drawn {
        Frame frame;
        Bytes bytes;  // in the request's output format
        double queueMs = 0.0, drawMs = 0.0, encodeMs = 0.0;
    };

    FrameService(const Components& components, const Limits& limits)
        : components_(components), limits_(limits) {}

    // The scene with this id; the default scene if it is empty. Stays loaded as long as the result
    // exists. Throws RequestError: no such scene (404), loading (409), failed (422).
    std::shared_ptr<const Scene> requireScene(const std::string& id);
    // Those of FrameRequest::parts. Throws as requireScene(), but 422 if some are unknown.
    std::vector<std::shared_ptr<const Scene>> requireParts(const FrameRequest& request);
    // patience: as EnvironmentLibrary::requireUploads(). Throws as requireScene(); 409 also while
    // an uploaded map loads or the curve of a budget is measured; 422 if scenes of a list are
    // unknown.
    Resolved resolve(FrameRequest request, const Budgets::Requester& requester,
                     MapPatience patience);
    // Throws InvalidRequest if the frame needs more samples than the limit.
    void requireAffordable(const FrameRequest& request) const;
    // A strong entity tag of the frame. Of a frame with light of surfaces: with the revision that
    // it shows.
    std::string etagOf(const Resolved& resolved, std::uint32_t lightRevision = 0) const;
    // Whether the bytes of the frame depend on a revision of light.
    static bool showsLight(const FrameRequest& request) { return showsSurfaceLight(request); }
    // The light that the frame would show now; the computation begins if it has not.
    LightProgress lightOf(const FrameRequest& request, Turn turn);
    // Waits until the light that the request shows is complete, for that time at most. Returns the
    // time waited. Other clients' frames are drawn in the meantime.
    std::chrono::milliseconds waitForLight(const FrameRequest& request, Turn turn,
                                           std::chrono::milliseconds limit);

    // With the deadline of the limits.
    Turn turnFor(Clock::time_point arrived,
                 std::optional<std::chrono::milliseconds> limit = {}) const {
        return clerestory::turnFor(arrived, limits_.deadlineSeconds, limit);
    }

    // Both throw RequestError, InvalidRequest and RenderFailed. `requestId` is for the log. A frame
    // in progress whose turn is cancelled ends before its next pass; see Turn::endsInProgress.
    Drawn draw(const Resolved& resolved, Turn turn, Readback readback,
               const std::string& requestId);
    FramePlan plan(const FrameRequest& request, Turn turn);

    // A frame was found unchanged by its entity tag, and not drawn.
    void countNotModified() { components_.metrics.notModified(); }

private:
    const Components components_;
    const Limits limits_;
};

}  // namespace clerestory
