// Curved mirrors of a view, and the cubes captured for them. A cube is drawn from the middle of its
// owner, without the owner; in generation k it shows the cubes of generation k - 1. A cube's
// content is known by the passes that would draw it, so what is resident and still true is not
// drawn.
#include "plan/cost/cost.h"
#include "plan/features.h"
#include "plan/graph/plan_hash.h"
#include "plan/view_tree.h"
#include "plan/visibility/enclosure.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/view.h"

#include <algorithm>
#include <bit>

namespace clerestory {
namespace {

// Frames that a capture is taken to last for where nothing moves. A constant: a choice that
// depended on what happens to be resident would give one request two pictures.
constexpr double kFramesOfACapture = 16.0;

// A captured face in its frame: what its surfaces weigh must not depend on who looks at the owner.
constexpr double kCaptureWeight = 0.03;

// A capture's near plane, as a share of its owner's radius (erratum C3).
constexpr double kNearShare = 1e-3;

// Smoother than this a map's own blur is right; see reflection.glsl.
constexpr float kRoughLobe = 0.2f;

// Texels along a face for a lobe of this roughness: a texel as wide as the lobe is 1 / (sqrt(6)
// alpha) of a face's edge (erratum R1); this many make up one.
constexpr double kTexelsPerLobe = 8.0;
constexpr std::uint32_t kMinTexels = 32;
std::uint32_t texelsFor(double roughness) {
    const double alpha = std::max(roughness * roughness, 1e-4);
    const double texels = kTexelsPerLobe / (2.449489742783178 * alpha);
    return std::bit_ceil(std::max(kMinTexels, static_cast<std::uint32_t>(texels)));
}

}  // namespace

void ViewTree::serveCurved(const ViewJob& job, SeenView& seen, DrawScene& drawn) {
    if (!stage_.request.effects.environmentReflection) return;
    const Accuracy& a = stage_.request.accuracy;
    // Where things move the next frame is another moment, and most cubes see that.
    const double frames = moves_.empty() ? kFramesOfACapture : 1.0;
    for (SeenSurface& s : seen.surfaces) {
        if (s.surface->reflector != Reflector::curved) continue;
        const Material& material = stage_.material(*s.surface);
        if (!material.environmentMap.empty() && serveFromMap(job, s, drawn)) continue;
        const CapturePoint point = capturePointOf(*s.surface);
        const std::string& name = point.name;
        const double share = s.share;
        const double pixels = share * job.width * job.height;
        if (pixels < 1.0) {
            skip(job, name, Effect::environmentReflection, "smaller than a pixel");
            continue;
        }
        if (hidden(job, name, Effect::environmentReflection, s.box)) continue;
        const double weight = reflectanceSeen(s.surface->reflectance, 0.5) * share;
        if (job.weight * weight < kMinWeight) {
            skip(job, name, Effect::environmentReflection, "too weak or too small to be seen");
            continue;
        }
        if (job.probeGeneration == 0) continue;  // a first generation shows the fallback
        const double roughness = s.surface->roughness;
        const double apart = point.placed ? 0.0 : apartFromMiddle(*s.surface, point);
        const double faceTexels = double(point.resolution) * point.resolution;
        std::vector<Candidate> candidates{
            {Method::environment, 0.0, environmentError(roughness, enclosedAt(job, s.box))},
            {Method::probe,
             milliseconds({.triangles = 2.0 * double(sceneTriangles_),
                           .pixels = 6.0 * faceTexels,
                           .views = 6.0,
                           .frames = frames,
                           .software = limits_.software}),
             probeError(roughness, apart)}};
        if (limits_.traces && !job.captured) {  // a captured face shows the generation before
            candidates.push_back(
                {Method::traced,
                 milliseconds({.rayPixels = pixels, .rays = 1.0, .software = limits_.software}),
                 tracedError(roughness)});
        }
        std::optional<Method> forced = methodAsked(a.curved, Method::probe);
        // Asked for by name, or by what only a cube can be: blurred.
        if (point.placed || point.blur.changes()) forced = Method::probe;
        const Method method =
            decide(job, {name, Effect::environmentReflection, share, weight, forced}, candidates);
        if (method == Method::traced) s.features |= FEATURE_TRACED_REFLECTION;
        if (method != Method::probe) continue;

        ReflectedPicture picture{.target = probe(point, job.probeGeneration),
                                 .center = point.center};
        // The box that the cube is taken to see: the scene's, and room for the owner itself.
        picture.proxyMin =
            glm::min(glm::dvec3(sceneBounds_.min) - point.center, glm::dvec3(-point.radius));
        picture.proxyMax =
            glm::max(glm::dvec3(sceneBounds_.max) - point.center, glm::dvec3(point.radius));
        drawn.reflections.push_back(picture);
        s.features |= FEATURE_PROBE;
        if (a.parallax == Parallax::box) s.features |= FEATURE_PARALLAX;
        if (a.parallax == Parallax::depth) s.features |= FEATURE_PARALLAX_DEPTH;
        s.reflection = static_cast<std::uint32_t>(drawn.reflections.size() - 1);
    }
}

// Rough metals that mirror a map, whichever it is. Captured faces are blurred themselves.
void ViewTree::serveRough(const ViewJob& job, SeenView& seen) const {
    const bool asked =
        stage_.request.accuracy.curvedSamples > 0 && stage_.request.effects.environmentReflection;
    if (!asked || job.captured) return;
    for (SeenSurface& s : seen.surfaces) {
        const bool served = s.features & (FEATURE_MIRROR | FEATURE_TRACED_REFLECTION);
        const bool mirrors =
            s.surface->reflector != Reflector::none || s.surface->why == ReflectorReason::rough;
        // Of what a texture varies the factor is the most.
        const bool rough = stage_.material(*s.surface).roughness > kRoughLobe;
        if (mirrors && rough && !served) s.features |= FEATURE_MAP_SAMPLES;
    }
}

// Of the root view alone: child views would ask for it in every one of their many frames' faces.
double ViewTree::enclosedAt(const ViewJob& job, const Bounds& box) {
    if (job.generation > 0) return 0.0;
    if (opaqueBoxes_.empty()) {
        for (const Surface& surface : stage_.surfaces) {
            if (surface.glass != Glass::none) continue;
            const Instance& instance = stage_.scene.instances[surface.instance];
            const glm::dmat4 eyeFromMesh =
                eyeFromLocal(job.view, stage_.pose.worldFromNode[instance.node]);
            const Mesh& mesh = stage_.scene.meshes[instance.mesh];
            const std::uint32_t first = surface.firstCluster - mesh.firstCluster;
            for (std::uint32_t c = 0; c < surface.clusterCount; ++c) {
                const Bounds& cluster = boundsOf(stage_.scene, stage_.pose, mesh, first + c);
                opaqueBoxes_.push_back(transformed(cluster, eyeFromMesh));
            }
        }
    }
    return enclosure(opaqueBoxes_, glm::dvec3(box.center()));
}

// A stored map instead of the surroundings, turned as its material says.
bool ViewTree::serveFromMap(const ViewJob& job, SeenSurface& s, DrawScene& drawn) {
    const Material& material = stage_.material(*s.surface);
    const auto found = maps_.find(material.environmentMap);
    const std::string name = "map:" + material.environmentMap;
    if (found == maps_.end()) {
        skip(job, name, Effect::environmentReflection, "no environment map of that name is loaded");
        return false;
    }
    const glm::dmat3 worldFromOwn = glm::mat3_cast(glm::normalize(material.environmentRotation));
    drawn.reflections.push_back(
        {.target = mapTarget(*found->second, material.mapBlur),
         .ownFromMap = glm::transpose(worldFromOwn) * glm::transpose(plan_.mapFromWorld)});
    s.features |= FEATURE_MAP;
    s.reflection = static_cast<std::uint32_t>(drawn.reflections.size() - 1);
    return true;
}

CapturePoint ViewTree::capturePointOf(const Surface& surface) const {
    const Scene& scene = stage_.scene;
    const Accuracy& a = stage_.request.accuracy;
    const std::string& named = stage_.material(surface).probe;
    const auto placed = std::find_if(scene.probes.begin(), scene.probes.end(),
                                     [&](const Probe& p) { return p.name == named; });
    const MapBlur& asked = stage_.material(surface).mapBlur;
    CapturePoint point;
    if (!named.empty() && placed != scene.probes.end()) {
        const glm::dvec4 middle(placed->position, 1.0);
        point.name = "probe:" + placed->name;
        point.center = placed->node == kNone
                           ? placed->position
                           : glm::dvec3(stage_.pose.worldFromNode[placed->node] * middle);
        point.id = static_cast<Index>(placed - scene.probes.begin());
        point.placed = true;
        point.znear = point.radius = 0.5 * placed->size;
        if (placed->zfar > point.znear) point.zfar = placed->zfar;
        point.resolution = placed->resolution > 0 ? placed->resolution : a.probeSize;
        point.blur = placed->blur;
        if (asked.changes()) point.blur = asked;
        return point;
    }
    const Instance& instance = scene.instances[surface.instance];
    // About the owner's own node, so that distance from the origin costs nothing.
    glm::dmat4 nodeFromMesh = stage_.pose.worldFromNode[instance.node];
    const glm::dvec3 node(nodeFromMesh[3]);
    nodeFromMesh[3] = {0.0, 0.0, 0.0, 1.0};
    const Bounds box =
        transformed(boundsOf(stage_.pose, scene.meshes[instance.mesh]), nodeFromMesh);
    point.name = "probe:" + nameOf(scene, surface);
    point.center = node + glm::dvec3(box.center());
    point.id = surface.instance;
    point.blur = asked;
    point.radius = 0.5 * double(box.diagonal());
    point.znear = kNearShare * point.radius;
    double roughness = surface.roughness;  // of the smoothest that reads the cube
    for (std::size_t i = 0; i < stage_.surfaces.size(); ++i) {
        const Surface& part = stage_.surfaces[i];
        if (part.instance != surface.instance) continue;
        point.hidden.push_back(i);
        if (part.reflector == Reflector::curved) {
            roughness = std::min(roughness, double(part.roughness));
        }
    }
    point.resolution = std::min(a.probeSize, texelsFor(roughness));
    return point;
}

// How far from the cube's centre the mirror stands, about, 0..1: of one body its radius, against
// the scene's; what has little area for its box is many bodies, and the middle is beside all of
// them.
double ViewTree::apartFromMiddle(const Surface& surface, const CapturePoint& point) const {
    constexpr double kOneBody = 0.05;  // of its box's area; a ball has half of it
    const Instance& instance = stage_.scene.instances[surface.instance];
    const glm::dvec3 e(boundsOf(stage_.pose, stage_.scene.meshes[instance.mesh]).extent());
    const double boxArea = 2.0 * (e.x * e.y + e.y * e.z + e.z * e.x);
    const double scattered =
        1.0 - std::min(1.0, surface.area / std::max(kOneBody * boxArea, 1e-30));
    const double reach = 2.0 * point.radius / std::max(1e-30, double(sceneBounds_.diagonal()));
    return std::clamp(std::max(reach * reach, scattered), 0.0, 1.0);
}

struct ViewTree::Snapshot {
    std::size_t passes, targets, skipped, decisions, keyedPasses;
    TargetId environment;
    std::map<MapKey, TargetId> maps;
    std::map<ProbeKey, TargetId> probes;
};

TargetId ViewTree::probe(const CapturePoint& point, std::uint32_t generation) {
    const ProbeKey memo{point.placed, point.id, generation, point.blur.size, point.blur.stdev};
    if (const auto it = probes_.find(memo); it != probes_.end()) return it->second;

    TargetSpec spec{.name = point.name,
                    .kind = TargetKind::cube,
                    .format = Format::rgba16f,
                    .width = point.resolution,
                    .height = point.resolution,
                    .levels = roughnessLevels(point.resolution),
                    .circumstances = circumstancesOf(point, generation)};
    const auto useResident = [&](std::uint64_t key) {
        spec.residentKey = key;
        plan_.skipped.push_back(
            {point.name, Effect::environmentReflection, "resident and unchanged"});
        return probes_[memo] = addTarget(spec);
    };
    const auto known = resident_.keyUnder.find(spec.circumstances);
    if (known != resident_.keyUnder.end() && resident_.keys.contains(known->second)) {
        return useResident(known->second);
    }

    const Snapshot before{
        plan_.passes.size(), plan_.targets.size(), plan_.skipped.size(), plan_.decisions.size(),
        keyedPasses_.size(), environmentTarget_,   mapTargets_,          probes_};
    TargetSpec capturedSpec = spec;
    capturedSpec.circumstances = 0;
    capturedSpec.name += ":capture";
    capturedSpec.levels = static_cast<std::uint32_t>(std::bit_width(point.resolution));
    capturedSpec.depth = true;
    const TargetId captured = addTarget(capturedSpec);

    std::array<View, 6> faces =
        cubeFaceViews(point.center, point.znear, glm::transpose(plan_.mapFromWorld));
    for (std::uint32_t face = 0; face < 6; ++face) {
        if (point.zfar) faces[face] = withFar(faces[face], *point.zfar);
        add({.purpose = DrawScene::Purpose::capture,
             .name = point.name,
             .effect = Effect::environmentReflection,
             .reason = "no cube that is still true is resident",
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
        filtered = addBlur(point.name, point.blur, point.resolution, generation, captured);
    } else {
        plan_.passes.push_back({.name = point.name + ":levels",
                                .effect = Effect::environmentReflection,
                                .generation = generation,
                                .target = captured,
                                .reason = "filtered samples read it blurred",
                                .work = BuildLevels{}});
    }
    const TargetId target = addTarget(spec);
    plan_.passes.push_back({.name = point.name + ":prefilter",
                            .effect = Effect::environmentReflection,
                            .generation = generation,
                            .target = target,
                            .reason = "a lobe for each roughness",
                            .work = PrefilterCube{filtered, stage_.request.accuracy.probeSamples}});
    // Of its own passes alone: whether a map that they read was drawn for them, for another or in
    // an earlier frame must not count.
    std::vector<std::size_t> own;
    auto keyed = keyedPasses_.begin() + static_cast<std::ptrdiff_t>(before.keyedPasses);
    for (std::size_t i = before.passes; i < plan_.passes.size(); ++i) {
        while (keyed != keyedPasses_.end() && keyed->second <= i) ++keyed;
        if (keyed == keyedPasses_.end() || i < keyed->first) own.push_back(i);
    }
    const std::uint64_t key = hashOfPasses(plan_, own, stage_, environment_);

    if (resident_.keys.contains(key)) {
        plan_.passes.resize(before.passes);
        plan_.targets.resize(before.targets);
        plan_.skipped.resize(before.skipped);
        plan_.decisions.resize(before.decisions);
        keyedPasses_.resize(before.keyedPasses);
        environmentTarget_ = before.environment;
        mapTargets_ = before.maps;
        probes_ = before.probes;
        return useResident(key);
    }
    plan_.targets[target].residentKey = key;
    keyedPasses_.resize(before.keyedPasses);
    keyedPasses_.emplace_back(before.passes, plan_.passes.size());
    return probes_[memo] = target;
}

// What probe() and everything below it reads.
std::uint64_t ViewTree::circumstancesOf(const CapturePoint& point, std::uint32_t generation) const {
    const Accuracy& a = stage_.request.accuracy;
    const Effects& on = stage_.request.effects;
    PlanHash hash;
    hash.add(stage_.scene.contentHash);
    hash.add(stage_.materialsHash);
    hash.add(environment_.contentHash);
    for (const glm::dmat4& m : stage_.pose.worldFromNode) hash.add(m);
    for (const auto& deformed : stage_.pose.deformed) hash.add(deformed->hash);
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
    hash.add(a.backFaces);
    hash.add(limits_.software);
    hash.add(point.placed);
    hash.add(point.id);
    hash.add(point.resolution);
    hash.add(point.blur.size);
    hash.add(point.blur.stdev);
    hash.add(generation);
    return hash.value();
}

}  // namespace clerestory
