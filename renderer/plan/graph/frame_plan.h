// The plan of a frame: targets, passes and draws in order, with a reason for each pass and for
// everything that was left out. Plain values that can be compared and printed; no OpenGL.
#pragma once

#include "plan/graph/decision.h"
#include "plan/graph/light_progress.h"
#include "plan/graph/pass.h"
#include "plan/graph/ray_scene.h"
#include "scene/environment.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

// Something that the plan leaves out, with the reason.
struct Skipped {
    std::string name;
    Effect effect = Effect::base;
    std::string reason;
    Subject subject = {};
    bool operator==(const Skipped&) const = default;
};

struct PlanTotals {
    std::uint64_t passes = 0, views = 0, draws = 0, triangles = 0;
    bool operator==(const PlanTotals&) const = default;
};

// The requested view of a frame that is assembled from tiles.
struct FrameLens {
    Lens lens;
    View view;  // its projection only has the near and far plane
    bool operator==(const FrameLens&) const = default;
};

struct FramePlan {
    std::vector<TargetSpec> targets;
    std::vector<Pass> passes;
    std::vector<Skipped> skipped;
    std::vector<Decision> decisions;
    std::vector<std::string> composition;  // what the request changes in the scene
    std::vector<PlacedLight> lights;
    std::vector<Material> materials;  // overridden ones; indices follow those of Scene::materials
    TargetId output = kNoTarget;

    // Values that the passes send to the GPU.
    std::uint32_t width = 0, height = 0;
    Channel channel = Channel::color;
    OutputLayer layer = OutputLayer::direct;
    std::uint32_t anisotropy = 1;
    std::string environment;  // name of the map
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    std::uint32_t curvedSamples = 0;
    std::optional<FrameLens> lens;       // none: one matrix projects the frame
    std::optional<RayScene> rays;        // see planRays()
    std::uint64_t surfaceLight = 0;      // identifies the light at vertices; 0: the environment's
    bool emitters = false;               // that light has what emissive surfaces add to highlights
    std::optional<LightProgress> light;  // Effects::indirectLight
    TargetId shadowMap = kNoTarget;      // that every pass with lit surfaces reads; see LightShadow
    TargetRect wholeShadows;             // of it, without nearer pictures
    TargetId shadowTints = kNoTarget;    // half as large as that, if something lets light through
    std::uint32_t shadowSamples = 0;  // of the disc of a light that has a radius; 0: none has one
    bool transparent = false;         // the output has an alpha channel
    bool fewPrograms = false;         // DeviceLimits::fewPrograms
    double inverseDiagonal = 1.0;  // 1 / diagonal of the scene; pictures store distances times this

    bool operator==(const FramePlan&) const = default;
};

// The requested view: that of the lens, or of the last pass that draws the scene into the output.
// Null if the plan has none.
const View* frameView(const FramePlan& plan);

PlanTotals totals(const Pass& pass);
PlanTotals totals(const FramePlan& plan);

// One line per pass, per omission and per decision; for logs and test messages.
std::string toText(const FramePlan& plan);

}  // namespace clerestory
