#include "plan/effects/planar_reflection.h"

#include "plan/effects/method_choice.h"
#include "plan/graph/features.h"
#include "plan/visibility/mirror.h"
#include "plan/visibility/visibility.h"
#include "scene/hash.h"

#include <algorithm>
#include <cmath>

namespace clerestory {
namespace {

// Mirrors share a picture if their planes differ by less than this: cosine of a thousandth of a
// degree; difference of the distances to the eye relative to their sum.
constexpr double kSameNormal = 1.0 - 1.5e-10;
constexpr double kSameOffset = 1e-5;

// The two sides of a thin sheet (a slab of glass, a board) share a picture if the reflections in
// the farther one are displaced by at most this many pixels.
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

// Maximum number of mirrored views of one view, and of one mirrored view.
constexpr std::size_t kMaxMirrors = 8;
constexpr std::size_t kMaxMirrorsMirrored = 3;

// The picture of a rough mirror extends beyond its edge by the tail of the lobe, 5 alpha radians
// (erratum P9), and at most by this fraction of the picture.
constexpr double kMaxGuard = 0.25;

// Borders of pictures are multiples of this number of pixels: pictures of a camera that moves
// have few sizes, whose memory is there already. Of rough mirrors, so that their blur does not
// depend on the exact borders.
constexpr double kSharpSquare = 16.0;
constexpr double kRoughSquare = 32.0;

// Width of the lobe in pixels, for objects far behind the mirror (erratum R4), above which a
// picture of half the size looks the same except for objects that touch the mirror.
constexpr double kCoarseBlur = 24.0;

double pixelsPerSlope(const View& view, std::uint32_t height) {
    return 0.5 * height * view.clipFromView[1][1];
}

// Flat mirrors that lie in one plane and face the view share one picture.
struct MirrorGroup {
    Plane plane;                       // world; its front faces the eye
    double height = 0.0;               // of the eye above the plane, metres
    double roughness = 0.0;            // of the roughest surface, 0..1
    double smoothest = 1.0;            // roughness of the smoothest surface's smoothest part
    double slope = 0.0;                // of the bumps of the most uneven surface
    double share = 0.0, weight = 0.0;  // in the view, 0..1; see kMinWeight
    Subject subject;
    Index instance = 0;    // of its first surface
    bool flipped = false;  // only backs of two-sided surfaces are visible
    bool sheet = false;    // contains both sides of a thin sheet
    ScreenBox covered;
    std::vector<std::size_t> seen;  // into SeenView::surfaces
};

// The plane of a flat mirror with its front towards the eye; or none, with the reason, if the view
// shows no reflection in it.
struct FacingPlane {
    std::optional<Plane> plane;  // world
    double height = 0.0;         // of the eye above it, metres
    bool flipped = false;        // seen from the back of its surface
    const char* omitted = "";
};
FacingPlane facingPlane(const Stage& stage, const ViewTask& task, const SeenSurface& s) {
    const FlatPart& part = stage.scene.flatParts[s.surface->flatPart];
    const Instance& instance = stage.scene.instances[s.surface->instance];
    FacingPlane facing{.plane = transformed(part.plane(), stage.pose.worldFromNode[instance.node])};
    if (!facing.plane) return {.omitted = "degenerate transform"};
    facing.height = eyeHeight(*facing.plane, task.view);
    facing.flipped = facing.height < 0.0;
    if (facing.flipped && stage.material(*s.surface).doubleSided) {
        facing.plane = Plane{-facing.plane->normal, -facing.plane->offset};
        facing.height = -facing.height;
    }
    if (!(facing.height > 0.0)) return {.omitted = "seen from its back"};
    if (screenBox(task.view, s.box).share() * task.width * task.height < 1.0) {
        return {.omitted = "smaller than a pixel"};
    }
    return facing;
}

// Returns the group that shares a picture with the surface; a new one if there is none.
MirrorGroup& groupFor(std::vector<MirrorGroup>& groups, const Stage& stage, const ViewTask& task,
                      const SeenSurface& s, const FacingPlane& facing) {
    const double slope = pixelsPerSlope(task.view, task.height);
    const double tolerance = sheetPixels(stage.settings.accuracy.preset);
    const double nearest = std::max(distanceTo(s.box), 1e-30);
    const double pixelsPerMetre = task.view.orthographic ? slope : slope / nearest;
    const auto sameDirection = [&](const MirrorGroup& g) {
        return glm::dot(g.plane.normal, facing.plane->normal) > kSameNormal;
    };
    const auto isCatcher = [&](Index instance) { return isShadowCatcher(stage.scene, instance); };
    const auto samePlane = [&](const MirrorGroup& g) {
        return sameDirection(g) && isCatcher(g.instance) == isCatcher(s.surface->instance) &&
               std::abs(g.height - facing.height) <= kSameOffset * (g.height + facing.height);
    };
    const auto otherSide = [&](const MirrorGroup& g) {
        return g.instance == s.surface->instance && g.flipped != facing.flipped &&
               sameDirection(g) &&
               2.0 * std::abs(g.height - facing.height) * pixelsPerMetre <= tolerance;
    };
    auto group = std::find_if(groups.begin(), groups.end(), samePlane);
    if (group != groups.end()) return *group;
    group = std::find_if(groups.begin(), groups.end(), otherSide);
    if (group != groups.end()) {
        group->sheet = true;
        return *group;
    }
    groups.push_back({.instance = s.surface->instance, .flipped = true});
    return groups.back();
}

std::vector<MirrorGroup> visibleMirrors(ViewContext& context, const ViewTask& task,
                                        const SeenView& seen) {
    const Stage& stage = context.stage;
    std::vector<MirrorGroup> groups;
    for (std::size_t i = 0; i < seen.surfaces.size(); ++i) {
        const SeenSurface& s = seen.surfaces[i];
        if (s.surface->reflector != Reflector::flat) continue;
        const bool byCoat = s.surface->reason == ReflectorReason::clearcoat;
        if (byCoat && !stage.settings.effects.materialLayers) continue;
        const Subject subject{Subject::Kind::mirror, nameOf(stage.scene, *s.surface)};
        const FacingPlane facing = facingPlane(stage, task, s);
        if (!facing.plane) {
            skip(context, task, subject, Effect::planarReflection, facing.omitted);
            continue;
        }
        if (skipIfOccluded(context, task, subject, Effect::planarReflection, s.box)) continue;
        if (edgeOn(facing.height, task.view, task.height)) {
            skip(context, task, subject, Effect::planarReflection, "edge-on");
            continue;
        }
        MirrorGroup& group = groupFor(groups, stage, task, s, facing);
        // The side that faces the eye has the stronger reflection.
        if (group.seen.empty() || (group.flipped && !facing.flipped)) {
            group.plane = *facing.plane;
            group.height = facing.height;
            group.subject = subject;
            group.flipped = facing.flipped;
        }
        const ScreenBox covered = screenBox(task.view, s.box);
        group.covered.low = glm::min(group.covered.low, covered.low);
        group.covered.high = glm::max(group.covered.high, covered.high);
        const double distance = glm::length(glm::dvec3(s.box.center()));
        const double cosine =
            task.view.orthographic ? 1.0 : facing.height / std::max(distance, facing.height);
        group.share = std::min(1.0, group.share + s.share);
        group.weight += reflectanceSeen(s.surface->reflectance, cosine) * s.share;
        group.roughness = std::max(group.roughness, double(s.surface->roughness));
        group.smoothest = std::min(group.smoothest, double(s.surface->smoothest));
        group.slope = std::max(group.slope, double(s.surface->slope));
        group.seen.push_back(i);
    }
    return groups;
}

// The part of the view's picture that a group needs, and the mirrored view that draws it.
struct MirrorPicture {
    PixelRect rect;  // of the view
    View view;
    std::uint32_t width = 0, height = 0;  // texels
    double scale = 1.0;                   // texels per pixel of the view along an edge
    double pixelsPerSlope = 0.0;          // of the view
    bool rough = false;                   // surfaces read it blurred
    bool coarse = false;                  // half size, because the blur is wide
};

// Without what is right of the view's picture or above it.
PixelRect within(const PixelRect& rect, const ViewTask& task) {
    return {rect.x, rect.y, std::clamp(task.width - rect.x, 1.0, rect.width),
            std::clamp(task.height - rect.y, 1.0, rect.height)};
}

MirrorPicture pictureOf(const MirrorGroup& group, const ViewTask& task, const Accuracy& a) {
    MirrorPicture picture{.pixelsPerSlope = pixelsPerSlope(task.view, task.height),
                          .rough = group.roughness > kSharpRoughness};
    // Whole pixels of the view, so that at scale 1 the pixel centres of both pictures coincide.
    const double alpha = group.roughness * group.roughness;
    const double slope = picture.pixelsPerSlope;
    const double guard =
        picture.rough ? std::min(5.0 * alpha * slope, kMaxGuard * std::max(task.width, task.height))
                      : 0.0;
    const PixelRect touched = pixelRect(group.covered, task.width, task.height, guard);
    picture.rect = picture.rough ? alignedToGrid(touched, kRoughSquare)
                                 : within(alignedToGrid(touched, kSharpSquare), task);
    picture.view =
        mirroredView(cropped(task.view, picture.rect, task.width, task.height), group.plane);
    const double narrowest = group.smoothest * group.smoothest;
    picture.coarse = a.preset != Preset::fine && 4.898979486 * narrowest * slope > kCoarseBlur;
    picture.scale = picture.coarse ? 0.5 * a.planarScale : a.planarScale;
    picture.width = static_cast<std::uint32_t>(std::ceil(picture.rect.width * picture.scale));
    picture.height = static_cast<std::uint32_t>(std::ceil(picture.rect.height * picture.scale));
    return picture;
}

// The fraction of the pixels of a mirrored view that show surfaces, which are shaded; the sky costs
// little. A closed room has half a predicted layer.
double shadedShare(const SeenView& behind) {
    constexpr double kLeast = 0.2;
    return std::clamp(2.0 * behind.overdraw, kLeast, 1.0);
}

// mirrors: in the view, this one included.
std::vector<Candidate> candidatesFor(ViewContext& context, const ViewTask& task,
                                     const SeenView& seen, const MirrorGroup& group,
                                     const MirrorPicture& picture,
                                     std::span<const std::size_t> hidden, double mirrors) {
    const DeviceLimits& limits = context.frame.limits;
    const SeenView behind = seenFrom(context.stage, picture.view, hidden);
    const double enclosed = enclosureAt(context, task, seen.surfaces[group.seen.front()].box);
    std::vector<Candidate> candidates{
        {Method::environment, 0.0, environmentError(group.roughness, enclosed)},
        {Method::mirror,
         milliseconds({.draws = double(behind.surfaces.size()),
                       .triangles = double(behind.triangles),
                       .pixels = shadedShare(behind) * picture.width * picture.height,
                       .views = 1.0,
                       .shading = context.shading,
                       .software = limits.software}),
         mirrorError(group.roughness, group.slope)}};
    if (limits.rays != Rays::none) {
        const Accuracy& a = context.stage.settings.accuracy;
        const bool processorRays = limits.rays == Rays::processor;
        const double paths = pathsOfRay(a.raySamples, group.roughness, processorRays);
        candidates.push_back({Method::traced,
                              milliseconds({.rayPixels = group.share * task.width * task.height,
                                            .rays = flatRays(processorRays),
                                            .paths = paths,
                                            .density = rayDensity(a.preset, processorRays),
                                            .hits = enclosed,
                                            .sharing = mirrors,
                                            .shading = context.shading,
                                            .software = limits.software,
                                            .processorRays = processorRays}),
                              tracedError(group.roughness, paths)});
    }
    return candidates;
}

// Identifies the mirrored view among those of the requested view.
std::uint64_t keyOf(const MirrorPicture& picture, const MirrorGroup& group) {
    PlanHash hash;
    hash.add(std::string_view("mirrored view"));
    hash.add(std::string_view(nameOf(group.subject)));
    hash.add(picture.view.viewFromWorld);
    hash.add(picture.view.clipFromView);
    hash.add(picture.width);
    hash.add(picture.height);
    return hash.value();
}

// Adds the passes of the mirrored view. Returns its target.
TargetId drawPicture(ViewContext& context, const ViewTask& task, const MirrorGroup& group,
                     const MirrorPicture& picture, std::vector<std::size_t> hidden) {
    // A transparent background draws the requested view twice, with the same mirrored views.
    const std::uint64_t key = keyOf(picture, group);
    if (task.background.radiance) {
        if (const auto drawn = context.builder.shared(key)) return *drawn;
    }
    // A shadow catcher reflects the scene alone.
    OwnBackground background;
    if (isShadowCatcher(context.stage.scene, group.instance)) background.radiance = glm::vec3(0.0f);
    const TargetId target = context.builder.addTarget(
        {.name = nameOf(group.subject),
         .format = Format::rgba16f,
         .width = picture.width,
         .height = picture.height,
         .levels = picture.rough ? pictureLevels(picture.width, picture.height) : 1,
         .depth = true});
    planView(context, {.purpose = DrawScene::Purpose::mirror,
                       .subject = group.subject,
                       .effect = Effect::planarReflection,
                       .reason = "visible and facing the view, " + percentOfFrame(group.share) +
                                 (group.sheet ? "; for both sides of a sheet" : "") +
                                 (picture.coarse ? "; half size because of its blur" : ""),
                       .view = picture.view,
                       .width = picture.width,
                       .height = picture.height,
                       .target = target,
                       .generation = task.generation + 1,
                       // Mean reflectance times the part of the view that it covers.
                       .weight = task.weight * group.covered.share() *
                                 std::min(1.0, group.weight / std::max(group.share, 1e-9)),
                       .captured = task.captured,
                       .mirrorsLeft = task.mirrorsLeft - 1,
                       .probeGeneration = task.probeGeneration,
                       .background = background,
                       .hidden = std::move(hidden)});
    if (picture.rough) {
        context.builder.addPass({.name = nameOf(group.subject) + ":levels",
                                 .subject = group.subject,
                                 .effect = Effect::planarReflection,
                                 .generation = task.generation + 1,
                                 .target = target,
                                 .reason = "a rough mirror reads blurred levels",
                                 .work = BuildLevels{}});
    }
    if (task.background.radiance) context.builder.share(key, target);
    return target;
}

// Chooses the method for one group, and marks its surfaces.
void planGroup(ViewContext& context, const ViewTask& task, SeenView& seen, DrawScene& drawn,
               const MirrorGroup& group, double mirrors) {
    const Accuracy& a = context.stage.settings.accuracy;
    if (task.mirrorsLeft == 0) {
        skip(context, task, group.subject, Effect::planarReflection,
             "maximum number of generations reached");
        return;
    }
    if (task.weight * group.weight < kMinWeight) {
        skip(context, task, group.subject, Effect::planarReflection,
             "weight below the visible minimum");
        return;
    }
    std::vector<std::size_t> hidden;
    for (const std::size_t s : group.seen) {
        hidden.push_back(
            static_cast<std::size_t>(seen.surfaces[s].surface - context.stage.surfaces.data()));
    }
    std::sort(hidden.begin(), hidden.end());
    const MirrorPicture picture = pictureOf(group, task, a);
    const bool catcher = isShadowCatcher(context.stage.scene, group.instance);
    // Rays and the environment map do not show the scene alone.
    const auto forced = catcher && a.planar != PlanarMethod::environment
                            ? std::optional(Method::mirror)
                            : requestedMethod(a.planar, Method::mirror);
    const double noticed =
        group.weight * noticedShare(group.share, a.preset) / std::max(group.share, 1e-12);
    const Method method = chooseMethod(
        context, task, {group.subject, Effect::planarReflection, group.share, noticed, forced},
        candidatesFor(context, task, seen, group, picture, hidden, mirrors));
    if (method == Method::environment) return;
    for (const std::size_t s : group.seen) {
        const bool byCoat = seen.surfaces[s].surface->reason == ReflectorReason::clearcoat;
        if (byCoat) seen.surfaces[s].features |= ofLayers(LAYER_CLEARCOAT_MIRRORS);
    }
    if (method == Method::traced) {
        for (const std::size_t s : group.seen) {
            seen.surfaces[s].features |= FEATURE_TRACED_REFLECTION;
        }
        return;
    }
    const TargetId target = drawPicture(context, task, group, picture, std::move(hidden));
    drawn.reflections.push_back({.target = target,
                                 .origin = {picture.rect.x, picture.rect.y},
                                 .scale = picture.scale,
                                 .pixelsPerSlope = picture.pixelsPerSlope * picture.scale,
                                 .normal = group.plane.normal,
                                 .samples = a.planarSamples});
    for (const std::size_t s : group.seen) {
        seen.surfaces[s].features |= FEATURE_MIRROR;
        if (picture.rough && a.planarSamples > 1 && !catcher) {
            seen.surfaces[s].features |= FEATURE_MIRROR_SAMPLES;
        }
        seen.surfaces[s].reflection = static_cast<std::uint32_t>(drawn.reflections.size() - 1);
    }
}

}  // namespace

void planPlanarReflections(ViewContext& context, const ViewTask& task, SeenView& seen,
                           DrawScene& drawn) {
    if (!context.stage.settings.effects.planarReflection) return;
    const std::vector<MirrorGroup> groups = visibleMirrors(context, task, seen);
    std::vector<const MirrorGroup*> strongest;
    for (const MirrorGroup& group : groups) strongest.push_back(&group);
    std::stable_sort(strongest.begin(), strongest.end(),
                     [](const auto* a, const auto* b) { return a->weight > b->weight; });
    const std::size_t limit = task.generation == 0 ? kMaxMirrors : kMaxMirrorsMirrored;
    for (std::size_t i = limit; i < strongest.size(); ++i) {
        skip(context, task, strongest[i]->subject, Effect::planarReflection,
             "weaker than the " + std::to_string(limit) + " mirrors with a mirrored view");
    }
    strongest.resize(std::min(limit, strongest.size()));
    for (const MirrorGroup& group : groups) {
        const bool drawsIt =
            std::find(strongest.begin(), strongest.end(), &group) != strongest.end();
        if (drawsIt) planGroup(context, task, seen, drawn, group, double(strongest.size()));
    }
}

}  // namespace clerestory
