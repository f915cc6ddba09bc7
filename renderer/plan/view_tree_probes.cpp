// Curved mirrors of a view, and the cubes captured for them. A cube is drawn from the middle of its
// owner, without the owner; in generation k it shows the cubes of generation k - 1. A cube's
// content is known by the passes that would draw it, so what is resident and still true is not
// drawn.
#include "plan/cost.h"
#include "plan/features.h"
#include "plan/mirror.h"
#include "plan/plan_hash.h"
#include "plan/view_tree.h"

#include <algorithm>
#include <bit>

namespace clerestory {
namespace {

// Frames that a capture is taken to last for. A constant: a choice that depended on what happens to
// be resident would give one request two pictures.
constexpr double kFramesOfACapture = 16.0;

// A captured face in its frame: what its surfaces weigh must not depend on who looks at the owner.
constexpr double kCaptureWeight = 0.1;

// A capture's near plane, as a share of its owner's radius (erratum C3).
constexpr double kNearShare = 1e-3;

}  // namespace

void ViewTree::serveCurved(const ViewJob& job, SeenView& seen, Pass& pass) {
    if (!stage_.request.effects.environmentReflection) return;
    const Accuracy& a = stage_.request.accuracy;
    for (SeenSurface& s : seen.surfaces) {
        if (s.surface->reflector != Reflector::curved) continue;
        const std::string name = "probe:" + nameOf(stage_.scene, *s.surface);
        const double share = std::min(1.0, kBoxFill * s.share);
        const double pixels = share * job.width * job.height;
        if (pixels < 1.0) {
            skip(job, name, Effect::environmentReflection, "smaller than a pixel");
            continue;
        }
        const double weight = reflectanceSeen(s.surface->reflectance, 0.5) * share;
        if (job.weight * weight < kLeastWeight) {
            skip(job, name, Effect::environmentReflection, "too weak or too small to be seen");
            continue;
        }
        if (job.probeGeneration == 0) continue;  // a first generation shows the fallback
        const double roughness = s.surface->roughness;
        const double faceTexels = double(a.probeSize) * a.probeSize;
        std::vector<Candidate> candidates{{Method::environment, 0.0, environmentError(roughness)},
                                          {Method::probe,
                                           milliseconds({.triangles = 2.0 * double(sceneTriangles_),
                                                         .pixels = 6.0 * faceTexels,
                                                         .views = 6.0,
                                                         .frames = kFramesOfACapture,
                                                         .software = limits_.software}),
                                           probeError(roughness)}};
        if (limits_.traces) {
            candidates.push_back(
                {Method::traced,
                 milliseconds({.rayPixels = pixels, .rays = 1.0, .software = limits_.software}),
                 tracedError(roughness)});
        }
        std::optional<Method> forced;
        switch (a.curved) {
            case CurvedMethod::automatic:
                break;
            case CurvedMethod::environment:
                forced = Method::environment;
                break;
            case CurvedMethod::probe:
                forced = Method::probe;
                break;
            case CurvedMethod::traced:
                forced = Method::traced;
                break;
        }
        if (job.captured) forced = Method::probe;  // of the generation before
        const Method method =
            decide(job, {name, Effect::environmentReflection, share, weight, forced}, candidates);
        if (method == Method::traced) s.features |= FEATURE_TRACED_REFLECTION;
        if (method != Method::probe) continue;

        const Probe probed = probe(s, job.probeGeneration);
        pass.reads.push_back(probed.target);
        pass.reflections.push_back({.target = probed.target,
                                    .center = probed.center,
                                    .proxyMin = probed.proxyMin,
                                    .proxyMax = probed.proxyMax});
        s.features |= FEATURE_PROBE;
        if (a.parallax != Parallax::none) s.features |= FEATURE_PARALLAX;
        s.reflection = static_cast<std::uint32_t>(pass.reflections.size() - 1);
    }
}

struct ViewTree::Snapshot {
    std::size_t passes, targets, skipped, decisions;
    TargetId environment;
    std::map<ProbeKey, TargetId> probes;
};

ViewTree::Probe ViewTree::probe(const SeenSurface& seen, std::uint32_t generation) {
    const Index owner = seen.surface->instance;
    const Instance& instance = stage_.scene.instances[owner];
    const Mesh& mesh = stage_.scene.meshes[instance.mesh];
    const Accuracy& a = stage_.request.accuracy;

    // About the owner's own node, so that distance from the origin costs nothing.
    const glm::dmat4& worldFromMesh = stage_.pose.worldFromNode[instance.node];
    glm::dmat4 nodeFromMesh = worldFromMesh;
    nodeFromMesh[3] = {0.0, 0.0, 0.0, 1.0};
    const Bounds box = transformed(mesh.bounds, nodeFromMesh);
    Probe result;
    result.center = glm::dvec3(worldFromMesh[3]) + glm::dvec3(box.center());
    const double radius = 0.5 * double(box.diagonal());
    result.proxyMin = glm::min(glm::dvec3(sceneBounds_.min) - result.center, -glm::dvec3(radius));
    result.proxyMax = glm::max(glm::dvec3(sceneBounds_.max) - result.center, glm::dvec3(radius));

    const auto [memo, isNew] = probes_.try_emplace({owner, generation}, kNoTarget);
    if (!isNew) {
        result.target = memo->second;
        return result;
    }

    const std::string name = "probe:" + nameOf(stage_.scene, *seen.surface);
    TargetSpec spec{.name = name,
                    .kind = TargetKind::cube,
                    .format = Format::rgba16f,
                    .width = a.probeSize,
                    .height = a.probeSize,
                    .levels = roughnessLevels(a.probeSize),
                    .circumstances = circumstancesOf(owner, generation)};
    const auto useResident = [&](std::uint64_t key) {
        spec.residentKey = key;
        result.target = addTarget(spec);
        plan_.skipped.push_back({name, Effect::environmentReflection, "resident and unchanged"});
        probes_[{owner, generation}] = result.target;
        return result;
    };
    const auto known = resident_.keyUnder.find(spec.circumstances);
    if (known != resident_.keyUnder.end() && resident_.keys.contains(known->second)) {
        return useResident(known->second);
    }

    const Snapshot before{plan_.passes.size(),    plan_.targets.size(), plan_.skipped.size(),
                          plan_.decisions.size(), environmentTarget_,   probes_};
    TargetSpec capturedSpec = spec;
    capturedSpec.circumstances = 0;
    capturedSpec.name += ":capture";
    capturedSpec.levels = static_cast<std::uint32_t>(std::bit_width(a.probeSize));
    capturedSpec.depth = true;
    const TargetId captured = addTarget(capturedSpec);

    std::vector<std::size_t> hidden;
    for (std::size_t i = 0; i < stage_.surfaces.size(); ++i) {
        if (stage_.surfaces[i].instance == owner) hidden.push_back(i);
    }
    const std::array<View, 6> faces =
        cubeFaceViews(result.center, kNearShare * radius, glm::transpose(plan_.mapFromWorld));
    for (std::uint32_t face = 0; face < 6; ++face) {
        add({.kind = PassKind::capture,
             .name = name,
             .effect = Effect::environmentReflection,
             .reason = "no cube that is still true is resident",
             .view = faces[face],
             .width = a.probeSize,
             .height = a.probeSize,
             .target = captured,
             .face = face,
             .generation = generation,
             .weight = kCaptureWeight,
             .captured = true,
             .mirrorsLeft = 1,
             .probeGeneration = generation - 1,
             .hidden = hidden});
    }
    plan_.passes.push_back({.kind = PassKind::levels,
                            .name = name + ":levels",
                            .effect = Effect::environmentReflection,
                            .generation = generation,
                            .target = captured,
                            .reason = "filtered samples read it blurred"});
    result.target = addTarget(spec);
    plan_.passes.push_back({.kind = PassKind::prefilter,
                            .name = name + ":prefilter",
                            .effect = Effect::environmentReflection,
                            .generation = generation,
                            .target = result.target,
                            .reads = {captured},
                            .reason = "a lobe for each roughness"});
    const std::uint64_t key = hashOfPasses(plan_, before.passes, stage_, environment_);

    if (resident_.keys.contains(key)) {
        plan_.passes.resize(before.passes);
        plan_.targets.resize(before.targets);
        plan_.skipped.resize(before.skipped);
        plan_.decisions.resize(before.decisions);
        environmentTarget_ = before.environment;
        probes_ = before.probes;
        return useResident(key);
    }
    plan_.targets[result.target].residentKey = key;
    probes_[{owner, generation}] = result.target;
    return result;
}

// What probe() and everything below it reads.
std::uint64_t ViewTree::circumstancesOf(Index owner, std::uint32_t generation) const {
    const Accuracy& a = stage_.request.accuracy;
    const Effects& on = stage_.request.effects;
    PlanHash hash;
    hash.add(stage_.scene.contentHash);
    hash.add(stage_.dressingHash);
    hash.add(environment_.contentHash);
    for (const glm::dmat4& m : stage_.pose.worldFromNode) hash.add(m);
    hash.add(plan_.mapFromWorld);
    hash.add(plan_.environmentIntensity);
    hash.add(plan_.anisotropy);
    hash.add(stage_.request.environment.visible);
    for (const bool switched : {on.emission, on.refraction, on.planarReflection}) {
        hash.add(switched);
    }
    hash.add(a.preset);
    hash.add(a.planar);
    hash.add(a.curved);
    hash.add(a.glass);
    hash.add(a.planarScale);
    hash.add(a.planarSamples);
    hash.add(a.probeSize);
    hash.add(a.probeSamples);
    hash.add(a.parallax);
    hash.add(a.environmentSize);
    hash.add(a.environmentSamples);
    hash.add(a.bounces);
    hash.add(limits_.software);
    hash.add(owner);
    hash.add(generation);
    return hash.value();
}

}  // namespace clerestory
