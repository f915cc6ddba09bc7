// What will be done for one frame, before doing it: targets, passes, draws, and a reason for
// everything done and everything left out. Plain values; comparable, printable, no OpenGL.
#pragma once

#include "plan/graph/decision.h"
#include "plan/graph/pass.h"
#include "plan/graph/ray_scene.h"
#include "scene/environment.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

// The fields of a request that the size of a frame comes from; see Pass::knobs.
inline constexpr std::string_view kKnobsOfTheFrame = "/width, /height, /accuracy/samples";

struct Skipped {
    std::string name;
    Effect effect = Effect::base;
    std::string reason;
    bool operator==(const Skipped&) const = default;
};

struct PlanTotals {
    std::uint64_t passes = 0, views = 0, draws = 0, triangles = 0;
    bool operator==(const PlanTotals&) const = default;
};

struct FramePlan {
    std::vector<TargetSpec> targets;
    std::vector<Pass> passes;
    std::vector<Skipped> skipped;
    std::vector<Decision> decisions;
    std::vector<PlacedLight> lights;
    std::vector<Material> materials;  // the frame's own; their indices follow those of the scene's
    TargetId output = kNoTarget;

    // Read by the passes: everything of the request that reaches the GPU as a number.
    std::uint32_t width = 0, height = 0;
    Channel channel = Channel::color;
    std::uint32_t anisotropy = 1;
    std::string environment;  // name of the map
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    std::uint32_t curvedSamples = 0;
    std::optional<RayScene> rays;  // where some draw follows rays
    double perMetre = 1.0;  // 1 / diagonal of the scene: pictures keep distances as shares of it

    bool operator==(const FramePlan&) const = default;
};

// The frame's own view, as requested: of the last pass that draws the scene for the output. Null
// for a plan without one.
const View* frameView(const FramePlan& plan);

PlanTotals totals(const Pass& pass);
PlanTotals totals(const FramePlan& plan);

// One line a pass and one a thing left out; for people and for test messages.
std::string toText(const FramePlan& plan);

}  // namespace clerestory
