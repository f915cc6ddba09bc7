// Flat mirrors of a view: which of them are worth a picture, and the views that draw those.
#include "plan/cost/cost.h"
#include "plan/features.h"
#include "plan/view_tree.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/visibility.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>

namespace clerestory {
namespace {

// Two mirrors share a picture when their planes differ by less than this: the cosine of a
// thousandth of a degree, and a share of the distance to the eye.
constexpr double kSameNormal = 1.0 - 1.5e-10;
constexpr double kSameOffset = 1e-5;

// The two sides of one sheet (a slab of glass, a board) share a picture when what the farther one
// mirrors would stand at most this many pixels beside it.
double sheetPixels(Preset preset) {
    switch (preset) {
        case Preset::draft:
            return 16.0;
        case Preset::standard:
            return 8.0;
        case Preset::fine:
            return 1.0;
    }
    return 1.0;
}

// Pictures that one view has drawn, the strongest first; a mirrored view, which shows less, has
// fewer.
constexpr std::size_t kMaxMirrors = 8;
constexpr std::size_t kMaxMirrorsMirrored = 3;

// Pixels beyond a rough mirror's edge that its blur may ask for: a lobe's tail of 5 alpha radians
// (erratum P9), at most this share of the picture.
constexpr double kMaxGuard = 0.25;

// Pictures of rough mirrors are whole squares of so many pixels: their blur does not depend on
// where their borders lie.
constexpr double kRoughSquare = 32.0;

// Pixels that a lobe spreads over what stands far behind the mirror (erratum R4), above which half
// as many pixels along an edge show the same but for what touches the mirror.
constexpr double kCoarseBlur = 24.0;

std::string percent(double share) {
    char text[64];
    std::snprintf(text, sizeof text, "%.1f %% of the frame", 100.0 * share);
    return text;
}

double pixelsPerSlope(const View& view, std::uint32_t height) {
    return 0.5 * height * view.clipFromView[1][1];
}

}  // namespace

struct ViewTree::MirrorGroup {
    Plane plane;                       // world, its front towards the eye
    double height = 0.0;               // of the eye above it, metres
    double roughness = 0.0;            // of the roughest, 0..1
    double share = 0.0, weight = 0.0;  // of the view; see kMinWeight
    std::string name;
    Index instance = 0;    // of its first surface
    bool flipped = false;  // all of it is seen from the back of two-sided parts
    bool sheet = false;    // holds both sides of something thin
    ScreenBox covered;
    std::vector<std::size_t> seen;  // into SeenView::surfaces
};

void ViewTree::serveFlat(const ViewJob& job, SeenView& seen, DrawScene& drawn) {
    if (!stage_.request.effects.planarReflection) return;
    std::vector<MirrorGroup> groups;
    const double slope = pixelsPerSlope(job.view, job.height);
    const double tolerance = sheetPixels(stage_.request.accuracy.preset);
    for (std::size_t i = 0; i < seen.surfaces.size(); ++i) {
        const SeenSurface& s = seen.surfaces[i];
        if (s.surface->reflector != Reflector::flat) continue;
        const std::string name = "mirror:" + nameOf(stage_.scene, *s.surface);
        const auto leaveOut = [&](const char* why) {
            skip(job, name, Effect::planarReflection, why);
        };
        const FlatPart& part = stage_.scene.flatParts[s.surface->flatPart];
        const Instance& instance = stage_.scene.instances[s.surface->instance];
        std::optional<Plane> plane =
            transformed(part.plane(), stage_.pose.worldFromNode[instance.node]);
        if (!plane) {
            leaveOut("its transform leaves no plane");
            continue;
        }
        double height = eyeHeight(*plane, job.view);
        const bool flipped = height < 0.0;
        if (flipped && stage_.material(*s.surface).doubleSided) {
            plane = Plane{-plane->normal, -plane->offset};
            height = -height;
        }
        if (!(height > 0.0)) {
            leaveOut("seen from its back");
            continue;
        }
        const ScreenBox covered = screenBox(job.view, s.box);
        if (covered.share() * job.width * job.height < 1.0) {
            leaveOut("smaller than a pixel");
            continue;
        }
        if (hidden(job, name, Effect::planarReflection, s.box)) continue;
        if (edgeOn(height, job.view, job.height)) {
            leaveOut("edge-on");
            continue;
        }
        const double nearest = std::max(distanceTo(s.box), 1e-30);
        const double perMetre = job.view.orthographic ? slope : slope / nearest;
        const auto same = [&](const MirrorGroup& g) {
            return glm::dot(g.plane.normal, plane->normal) > kSameNormal &&
                   std::abs(g.height - height) <= kSameOffset * (g.height + height);
        };
        const auto otherSide = [&](const MirrorGroup& g) {
            return g.instance == s.surface->instance && g.flipped != flipped &&
                   glm::dot(g.plane.normal, plane->normal) > kSameNormal &&
                   2.0 * std::abs(g.height - height) * perMetre <= tolerance;
        };
        auto group = std::find_if(groups.begin(), groups.end(), same);
        if (group == groups.end()) {
            group = std::find_if(groups.begin(), groups.end(), otherSide);
            if (group != groups.end()) group->sheet = true;
        }
        if (group == groups.end()) {
            groups.push_back({.instance = s.surface->instance, .flipped = true});
            group = groups.end() - 1;
        }
        // The side that faces the eye is the one whose reflection is strong.
        if (group->seen.empty() || (group->flipped && !flipped)) {
            group->plane = *plane;
            group->height = height;
            group->name = name;
            group->flipped = flipped;
        }
        group->covered.low = glm::min(group->covered.low, covered.low);
        group->covered.high = glm::max(group->covered.high, covered.high);
        const double distance = glm::length(glm::dvec3(s.box.center()));
        const double cosine = job.view.orthographic ? 1.0 : height / std::max(distance, height);
        group->share = std::min(1.0, group->share + s.share);
        group->weight += reflectanceSeen(s.surface->reflectance, cosine) * s.share;
        group->roughness = std::max(group->roughness, double(s.surface->roughness));
        group->seen.push_back(i);
    }
    std::vector<const MirrorGroup*> strongest;
    for (const MirrorGroup& group : groups) strongest.push_back(&group);
    std::stable_sort(strongest.begin(), strongest.end(),
                     [](const auto* a, const auto* b) { return a->weight > b->weight; });
    const std::size_t most = job.generation == 0 ? kMaxMirrors : kMaxMirrorsMirrored;
    for (std::size_t i = most; i < strongest.size(); ++i) {
        skip(job, strongest[i]->name, Effect::planarReflection,
             "weaker than the " + std::to_string(most) + " mirrors that have a picture");
    }
    strongest.resize(std::min(most, strongest.size()));
    for (const MirrorGroup& group : groups) {
        const bool kept = std::find(strongest.begin(), strongest.end(), &group) != strongest.end();
        if (kept) serveGroup(job, seen, drawn, group);
    }
}

void ViewTree::serveGroup(const ViewJob& job, SeenView& seen, DrawScene& drawn,
                          const MirrorGroup& group) {
    const Accuracy& a = stage_.request.accuracy;
    if (job.mirrorsLeft == 0) {
        skip(job, group.name, Effect::planarReflection, "no generation is left for it");
        return;
    }
    if (job.weight * group.weight < kMinWeight) {
        skip(job, group.name, Effect::planarReflection, "too weak or too small to be seen");
        return;
    }
    std::vector<std::size_t> hidden;
    for (const std::size_t s : group.seen) {
        hidden.push_back(
            static_cast<std::size_t>(seen.surfaces[s].surface - stage_.surfaces.data()));
    }
    std::sort(hidden.begin(), hidden.end());

    // Whole pixels of the view, so that at scale 1 both pictures have their centres in common.
    const double alpha = group.roughness * group.roughness;
    const bool rough = group.roughness > kSharpRoughness;
    const double slope = pixelsPerSlope(job.view, job.height);
    const double guard =
        rough ? std::min(5.0 * alpha * slope, kMaxGuard * std::max(job.width, job.height)) : 0.0;
    const PixelRect touched = pixelRect(group.covered, job.width, job.height, guard);
    const PixelRect rect = rough ? ofWholeSquares(touched, kRoughSquare) : touched;
    const View child = mirroredView(cropped(job.view, rect, job.width, job.height), group.plane);

    const bool coarse = a.preset != Preset::fine && 4.898979486 * alpha * slope > kCoarseBlur;
    const double scale = coarse ? 0.5 * a.planarScale : a.planarScale;
    const auto width = static_cast<std::uint32_t>(std::ceil(rect.width * scale));
    const auto height = static_cast<std::uint32_t>(std::ceil(rect.height * scale));
    const SeenView behind = seenFrom(stage_, child, hidden);
    const double enclosed = enclosedAt(job, seen.surfaces[group.seen.front()].box);
    std::vector<Candidate> candidates{
        {Method::environment, 0.0, environmentError(group.roughness, enclosed)},
        {Method::mirror,
         milliseconds({.triangles = double(behind.triangles),
                       .pixels = double(width) * height,
                       .views = 1.0,
                       .software = limits_.software}),
         mirrorError(group.roughness)}};
    if (limits_.traces) {
        candidates.push_back({Method::traced,
                              milliseconds({.rayPixels = group.share * job.width * job.height,
                                            .rays = 1.0,
                                            .software = limits_.software}),
                              tracedError(group.roughness)});
    }
    const std::optional<Method> forced = methodAsked(a.planar, Method::mirror);
    const Method method = decide(
        job, {group.name, Effect::planarReflection, group.share, group.weight, forced}, candidates);
    if (method == Method::environment) return;
    if (method == Method::traced) {
        for (const std::size_t s : group.seen) {
            seen.surfaces[s].features |= FEATURE_TRACED_REFLECTION;
        }
        return;
    }

    const TargetId target = addTarget({.name = group.name,
                                       .format = Format::rgba16f,
                                       .width = width,
                                       .height = height,
                                       .levels = rough ? pictureLevels(width, height) : 1,
                                       .depth = true});
    ViewJob mirror{.purpose = DrawScene::Purpose::mirror,
                   .name = group.name,
                   .effect = Effect::planarReflection,
                   .reason = "visible, facing, " + percent(group.share) +
                             (group.sheet ? "; for both sides of a sheet" : "") +
                             (coarse ? "; at half size, as it is blurred" : ""),
                   .view = child,
                   .width = width,
                   .height = height,
                   .target = target,
                   .generation = job.generation + 1,
                   // What it reflects, in the part of the view where it stands.
                   .weight = job.weight * group.covered.share() *
                             std::min(1.0, group.weight / std::max(group.share, 1e-9)),
                   .captured = job.captured,
                   .mirrorsLeft = job.mirrorsLeft - 1,
                   .probeGeneration = job.probeGeneration,
                   .hidden = std::move(hidden)};
    add(mirror);
    if (rough) {
        plan_.passes.push_back({.name = group.name + ":levels",
                                .effect = Effect::planarReflection,
                                .generation = mirror.generation,
                                .target = target,
                                .reason = "a rough mirror reads its picture blurred",
                                .work = BuildLevels{}});
    }
    drawn.reflections.push_back({.target = target,
                                 .origin = {rect.x, rect.y},
                                 .scale = scale,
                                 .pixelsPerSlope = slope * scale,
                                 .normal = group.plane.normal,
                                 .samples = a.planarSamples});
    for (const std::size_t s : group.seen) {
        seen.surfaces[s].features |= FEATURE_MIRROR;
        if (rough && a.planarSamples > 1) seen.surfaces[s].features |= FEATURE_MIRROR_SAMPLES;
        seen.surfaces[s].reflection = static_cast<std::uint32_t>(drawn.reflections.size() - 1);
    }
}

}  // namespace clerestory
