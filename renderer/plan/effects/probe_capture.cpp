#include "plan/effects/probe_capture.h"

#include "plan/effects/environment_map.h"
#include "plan/effects/method_choice.h"
#include "plan/graph/plan_hash.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <bit>

namespace clerestory {
namespace {

// Near plane of a capture, relative to the radius of its owner (erratum C3).
constexpr double kNearShare = 1e-3;

// Texels along the edge of a face for a given roughness: kTexelsPerLobe across the width of the
// lobe, which is sqrt(6) alpha of an edge (erratum R1).
constexpr double kTexelsPerLobe = 8.0;
constexpr std::uint32_t kMinTexels = 32;
std::uint32_t texelsFor(double roughness) {
    const double alpha = std::max(roughness * roughness, 1e-4);
    const double texels = kTexelsPerLobe / (2.449489742783178 * alpha);
    return std::bit_ceil(std::max(kMinTexels, static_cast<std::uint32_t>(texels)));
}

// Hash of everything that the planning of a cube reads: if it is equal, so is the cube's key.
std::uint64_t hashOfInputs(const ViewContext& context, const CapturePoint& point,
                           std::uint32_t generation) {
    const Stage& stage = context.stage;
    PlanHash hash;
    hash.add(stage.scene.contentHash);
    hash.add(stage.materialsHash);
    hash.add(stage.surfaceLight);
    hash.add(context.frame.environment.contentHash);
    for (const glm::dmat4& m : stage.pose.worldFromNode) hash.add(m);
    for (const auto& deformed : stage.pose.deformed) hash.add(deformed->hash);
    for (const Light& light : stage.pose.lights) {
        hash.add(light.intensity);
        for (const float v : {light.range, light.innerConeAngle, light.outerConeAngle}) hash.add(v);
    }
    hash.add(hashOf(captureSettings(stage.settings)));
    hash.add(context.frame.limits.software);
    hash.add(context.frame.limits.rays);
    hash.add(point.placed);
    hash.add(point.id);
    hash.add(point.resolution);
    addBlur(hash, point.blur);
    hash.add(generation);
    return hash.value();
}

// Adds the passes that draw the cube. Returns its target; if a cube of the same content is
// resident, adds nothing and returns none. Sets spec.residentKey.
std::optional<TargetId> drawCube(ViewContext& context, const CapturePoint& point,
                                 std::uint32_t generation, TargetSpec& spec) {
    PlanBuilder& builder = context.builder;
    PlanBuilder::Transaction capture(builder);
    TargetSpec capturedSpec = spec;
    capturedSpec.inputsHash = 0;
    capturedSpec.name += ":capture";
    capturedSpec.levels = static_cast<std::uint32_t>(std::bit_width(point.resolution));
    capturedSpec.depth = true;
    const TargetId captured = builder.addTarget(capturedSpec);

    std::array<View, 6> faces = cubeFaceViews(point.center, point.znear,
                                              glm::transpose(context.stage.settings.mapFromWorld));
    for (std::uint32_t face = 0; face < 6; ++face) {
        faces[face].lasting = true;
        if (point.zfar) faces[face] = withFar(faces[face], *point.zfar);
        planView(context, {.purpose = DrawScene::Purpose::capture,
                           .subject = point.subject,
                           .effect = Effect::environmentReflection,
                           .reason = "no valid cube is resident",
                           .view = faces[face],
                           .width = point.resolution,
                           .height = point.resolution,
                           .target = captured,
                           .face = face,
                           .generation = generation,
                           .weight = kCaptureWeight,
                           .captured = true,
                           .mirrorsLeft = 1,
                           .probeGeneration = generation - 1,
                           .hidden = point.hidden});
    }
    TargetId filtered = captured;
    if (point.blur.changes()) {
        filtered =
            addBlur(context, point.subject, point.blur, point.resolution, generation, captured);
    } else {
        builder.addPass({.name = nameOf(point.subject) + ":levels",
                         .subject = point.subject,
                         .effect = Effect::environmentReflection,
                         .generation = generation,
                         .target = captured,
                         .reason = "prefiltering reads blurred levels",
                         .work = BuildLevels{}});
    }
    const TargetId target = builder.addTarget(spec);
    builder.addPass(
        {.name = nameOf(point.subject) + ":prefilter",
         .subject = point.subject,
         .effect = Effect::environmentReflection,
         .generation = generation,
         .target = target,
         .reason = "one level per roughness",
         .work = PrefilterCube{filtered, context.stage.settings.accuracy.probeSamples}});
    spec.residentKey =
        hashOfPasses(builder.plan(), capture.ownPasses(), context.stage, context.frame.environment);
    if (context.frame.resident.keys.contains(spec.residentKey)) return std::nullopt;
    capture.commit(target, spec.residentKey);
    return target;
}

}  // namespace

CapturePoint capturePointOf(const Stage& stage, const Surface& surface) {
    const Scene& scene = stage.scene;
    const Accuracy& a = stage.settings.accuracy;
    const std::string& named = stage.material(surface).probe;
    const auto placed = std::find_if(scene.probes.begin(), scene.probes.end(),
                                     [&](const Probe& p) { return p.name == named; });
    const MapBlur& requested = stage.material(surface).mapBlur;
    CapturePoint point;
    if (!named.empty() && placed != scene.probes.end()) {
        const glm::dvec4 middle(placed->position, 1.0);
        point.subject = {Subject::Kind::probe, placed->name};
        point.center = placed->node == kNone
                           ? placed->position
                           : glm::dvec3(stage.pose.worldFromNode[placed->node] * middle);
        point.id = static_cast<Index>(placed - scene.probes.begin());
        point.placed = true;
        point.znear = point.radius = 0.5 * placed->size;
        if (placed->zfar > point.znear) point.zfar = placed->zfar;
        point.resolution = placed->resolution > 0 ? placed->resolution : a.probeSize;
        point.blur = placed->blur;
        if (requested.changes()) point.blur = requested;
        return point;
    }
    const Instance& instance = scene.instances[surface.instance];
    // Relative to the owner's node, so that distance from the origin costs no precision.
    glm::dmat4 nodeFromMesh = stage.pose.worldFromNode[instance.node];
    const glm::dvec3 node(nodeFromMesh[3]);
    nodeFromMesh[3] = {0.0, 0.0, 0.0, 1.0};
    const Bounds box = transformed(boundsOf(stage.pose, scene.meshes[instance.mesh]), nodeFromMesh);
    point.subject = {Subject::Kind::probe, nameOf(scene, surface)};
    point.center = node + glm::dvec3(box.center());
    point.id = surface.instance;
    point.blur = requested;
    point.radius = 0.5 * double(box.diagonal());
    point.znear = kNearShare * point.radius;
    double roughness = surface.roughness;  // of the smoothest surface that reads the cube
    for (std::size_t i = 0; i < stage.surfaces.size(); ++i) {
        const Surface& part = stage.surfaces[i];
        if (part.instance != surface.instance) continue;
        point.hidden.push_back(i);
        if (part.reflector == Reflector::curved) {
            roughness = std::min(roughness, double(part.roughness));
        }
    }
    point.resolution = std::min(a.probeSize, texelsFor(roughness));
    return point;
}

// For a compact body, its radius relative to that of the scene, squared. An object with a small
// area for its box consists of many bodies, which are all away from the centre.
double apartFromCenter(const ViewContext& context, const Surface& surface,
                       const CapturePoint& point) {
    const Stage& stage = context.stage;
    constexpr double kOneBody = 0.05;  // of the area of its box; a ball has half of it
    const Instance& instance = stage.scene.instances[surface.instance];
    const glm::dvec3 e(boundsOf(stage.pose, stage.scene.meshes[instance.mesh]).extent());
    const double boxArea = 2.0 * (e.x * e.y + e.y * e.z + e.z * e.x);
    const double scattered =
        1.0 - std::min(1.0, surface.area / std::max(kOneBody * boxArea, 1e-30));
    const double reach =
        2.0 * point.radius / std::max(1e-30, double(context.sceneBounds.diagonal()));
    return std::clamp(std::max(reach * reach, scattered), 0.0, 1.0);
}

TargetId capturedCube(ViewContext& context, const CapturePoint& point, std::uint32_t generation) {
    PlanBuilder& builder = context.builder;
    PlanHash identity;
    identity.add(std::string_view("captured cube"));
    identity.add(point.placed);
    identity.add(point.id);
    identity.add(generation);
    addBlur(identity, point.blur);
    if (const auto target = builder.shared(identity.value())) return *target;

    TargetSpec spec{.name = nameOf(point.subject),
                    .kind = TargetKind::cube,
                    .format = Format::rgba16f,
                    .width = point.resolution,
                    .height = point.resolution,
                    .levels = roughnessLevels(point.resolution),
                    .inputsHash = hashOfInputs(context, point, generation)};
    const ResidentMaps& resident = context.frame.resident;
    std::optional<TargetId> target;
    const auto known = resident.keyOfInputs.find(spec.inputsHash);
    if (known != resident.keyOfInputs.end() && resident.keys.contains(known->second)) {
        spec.residentKey = known->second;
    } else {
        target = drawCube(context, point, generation, spec);
    }
    if (!target) {
        builder.skip(point.subject, Effect::environmentReflection, "resident and unchanged");
        target = builder.addTarget(spec);
    }
    builder.share(identity.value(), *target);
    return *target;
}

}  // namespace clerestory
