#include "plan/graph/scene_passes.h"

#include "plan/graph/features.h"
#include "plan/graph/stage.h"

#include <algorithm>
#include <initializer_list>

namespace clerestory {
namespace {

// ---- hashes: each function binds all members, so that none can be forgotten ------------------

void addView(PlanHash& hash, const View& view) {
    const auto& [viewFromWorld, clipFromView, eye, orthographic, mirrored, lasting, znear,
                 clipPlane] = view;
    hash.add(viewFromWorld);
    hash.add(clipFromView);
    hash.add(eye);
    hash.add(orthographic);
    hash.add(mirrored);
    hash.add(lasting);
    hash.add(znear);
    hash.add(clipPlane.value_or(glm::dvec4(0.0)));
}

void addLight(PlanHash& hash, const PlacedLight& light) {
    // shadow: hashOfPasses() adds the key of the shadow map
    const auto& [kind, position, toLight, intensity, range, cosInner, cosOuter, radius, shadow] =
        light;
    hash.add(kind);
    hash.add(position);
    hash.add(toLight);
    hash.add(intensity);
    hash.add(range);
    hash.add(cosInner);
    hash.add(cosOuter);
    hash.add(radius);
}

void addDraws(PlanHash& hash, std::span<const Draw> draws, const Stage& stage) {
    hash.add(draws.size());
    for (const Draw& draw : draws) {
        const auto& [instance, material, firstIndex, indexCount, features, reflection, label,
                     middle, lights, primitive, faces, pointSize] = draw;
        hash.add(instance);
        stage.addMaterial(hash, material);
        hash.add(firstIndex);
        hash.add(indexCount);
        hash.add(features);
        hash.add(reflection);
        hash.add(label.value_or(0));
        hash.add(middle.value_or(0.0f));
        hash.add(primitive);
        hash.add(faces);
        hash.add(pointSize);
        const Instance& placed = stage.scene.instances[instance];
        hash.add(stage.pose.worldFromNode[placed.node]);
        if (const auto* mesh = deformedMesh(stage.pose, stage.scene.meshes[placed.mesh])) {
            hash.add(mesh->hash);
        }
        hash.add(lights.count);
        for (std::uint32_t i = 0; i < lights.count; ++i) {
            addLight(hash, stage.lights[lights.indices[i]]);
        }
    }
}

void addReflections(PlanHash& hash, const std::vector<ReflectedPicture>& reflections) {
    for (const ReflectedPicture& picture : reflections) {
        const auto& [target, origin, scale, pixelsPerSlope, normal, samples, center, proxyMin,
                     proxyMax, ownFromMap] = picture;  // reads(): target
        hash.add(origin);
        hash.add(scale);
        hash.add(pixelsPerSlope);
        hash.add(normal);
        hash.add(samples);
        hash.add(center);
        hash.add(proxyMin);
        hash.add(proxyMax);
        hash.add(ownFromMap);
    }
}

// Rays may hit any surface of the scene.
void addRayScene(PlanHash& hash, const Stage& stage) {
    for (const glm::dmat4& m : stage.pose.worldFromNode) hash.add(m);
    for (const auto& deformed : stage.pose.deformed) hash.add(deformed->hash);
    for (const PlacedLight& light : stage.lights) addLight(hash, light);
    hash.add(stage.materialsHash);
    hash.add(stage.settings.accuracy.bounces);
    hash.add(stage.settings.accuracy.raySamples);
    hash.add(stage.settings.accuracy.glassRaySamples);
    hash.add(stage.settings.accuracy.preset);  // the density of rays
    hash.add(stage.settings.effects.emission);
    hash.add(stage.settings.effects.refraction);
    hash.add(stage.settings.effects.materialLayers);
}

void addBackground(PlanHash& hash, const OwnBackground& background) {
    const auto& [radiance, coverage] = background;
    hash.add(radiance.has_value());
    hash.add(radiance.value_or(glm::vec3(0.0f)));
    hash.add(coverage);
}

template <class Lists>
bool anyDraw(const Lists& lists, auto&& is) {
    return std::any_of(lists.begin(), lists.end(), [&](std::span<const Draw> draws) {
        return std::any_of(draws.begin(), draws.end(), is);
    });
}

void addDrawnView(PlanHash& hash, const View& view,
                  std::initializer_list<std::span<const Draw>> lists, const Stage& stage) {
    if (anyDraw(lists, [](const Draw& d) { return followsRays(d); })) addRayScene(hash, stage);
    addView(hash, view);
    for (const std::span<const Draw> draws : lists) addDraws(hash, draws, stage);
}

// ---- cost ------------------------------------------------------------------------------------

std::uint64_t samplesOf(const TargetSpec& target) {
    return texelsOf(target, Faces::one, Levels::first);
}

// If a draw traces rays or averages directions, every pixel counts as if it did.
template <class Work>
std::uint64_t litSamples(const Work& work, const TargetSpec& target, const SampleFactors& factors) {
    std::uint64_t directions = 1;
    for (const ReflectedPicture& picture : work.reflections) {
        directions = std::max<std::uint64_t>(directions, picture.samples);
    }
    const auto lists = work.drawLists();
    if (anyDraw(lists, [](const Draw& d) { return (d.features & FEATURE_MAP_SAMPLES) != 0; })) {
        directions += factors.curvedSamples / 8;  // a look-up is a small part of a sample
    }
    const bool rays =
        work.recorded.draws.empty() && anyDraw(lists, [](const Draw& d) { return followsRays(d); });
    if (rays) directions += factors.rayBounces;
    return samplesOf(target) * directions;
}

void appendTargets(std::vector<TargetId>& reads, const std::vector<ReflectedPicture>& reflections) {
    for (const ReflectedPicture& picture : reflections) reads.push_back(picture.target);
}

}  // namespace

bool followsRays(const Draw& draw) {
    return (draw.features & (FEATURE_TRACED_REFLECTION | FEATURE_TRACED_GLASS)) != 0;
}

std::string_view DrawScene::kind() const {
    switch (purpose) {
        case Purpose::surface:
            return "surface";
        case Purpose::mirror:
            return "mirror";
        case Purpose::capture:
            return "capture";
    }
    return "";
}
std::vector<TargetId> DrawScene::reads() const {
    std::vector<TargetId> reads;
    if (environment != kNoTarget) reads.push_back(environment);
    appendTargets(reads, reflections);
    return reads;
}
std::string_view DrawScene::knobs() const {
    switch (purpose) {
        case Purpose::surface:
            break;
        case Purpose::mirror:
            return "/accuracy/planarScale, /accuracy/generations";
        case Purpose::capture:
            return "/accuracy/probeSize, /accuracy/probeSamples, /accuracy/generations";
    }
    return kKnobsOfTheFrame;
}
std::uint64_t DrawScene::shadedSamples(const TargetSpec& target,
                                       const SampleFactors& factors) const {
    return litSamples(*this, target, factors);
}
void addTo(PlanHash& hash, const DrawScene& work, const Stage& stage) {
    const auto& [purpose, face, view, map, environment, sky, background, reflections, depthDraws,
                 opaqueDraws, recorded, blendedDraws] =
        work;  // reads(): environment; hashOfPasses(): map
    hash.add(purpose);
    hash.add(face);
    hash.add(sky);
    addBackground(hash, background);
    addDrawnView(hash, view, {depthDraws, opaqueDraws, recorded.draws, blendedDraws}, stage);
    addReflections(hash, reflections);
}

std::vector<TargetId> DrawGlass::reads() const {
    std::vector<TargetId> reads;
    if (environment != kNoTarget) reads.push_back(environment);
    appendTargets(reads, reflections);
    reads.push_back(backdrop);
    if (backFaces != kNoTarget) reads.push_back(backFaces);
    return reads;
}
std::string_view DrawGlass::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t DrawGlass::shadedSamples(const TargetSpec& target,
                                       const SampleFactors& factors) const {
    return litSamples(*this, target, factors);
}
void addTo(PlanHash& hash, const DrawGlass& work, const Stage& stage) {
    const auto& [face, view, map, environment, backdrop, backFaces, background, reflections,
                 glassDraws, recorded, blendedDraws] =
        work;  // others: reads(), and map in hashOfPasses()
    hash.add(face);
    addBackground(hash, background);
    addDrawnView(hash, view, {glassDraws, recorded.draws, blendedDraws}, stage);
    addReflections(hash, reflections);
}

std::vector<TargetId> DrawBlended::reads() const {
    std::vector<TargetId> reads;
    if (environment != kNoTarget) reads.push_back(environment);
    appendTargets(reads, reflections);
    return reads;
}
std::string_view DrawBlended::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t DrawBlended::shadedSamples(const TargetSpec& target,
                                         const SampleFactors& factors) const {
    return litSamples(*this, target, factors);
}
void addTo(PlanHash& hash, const DrawBlended& work, const Stage& stage) {
    const auto& [face, view, map, environment, background, reflections, draws, recorded] =
        work;  // others: reads(), and map in hashOfPasses()
    hash.add(face);
    addBackground(hash, background);
    addDrawnView(hash, view, {draws, recorded.draws}, stage);
    addReflections(hash, reflections);
}

std::vector<TargetId> FollowRays::reads() const {
    std::vector<TargetId> reads = records;
    if (environment != kNoTarget) reads.push_back(environment);
    return reads;
}
std::string_view FollowRays::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t FollowRays::shadedSamples(const TargetSpec& target,
                                        const SampleFactors& factors) const {
    return samplesOf(target) * factors.rayBounces * factors.lobePaths;
}
void addTo(PlanHash& hash, const FollowRays& work, const Stage& stage) {
    // records: in reads(); radiance: written before it is read
    const auto& [face, view, map, environment, background, records, rect, radiance, everyPixel] =
        work;
    hash.add(everyPixel);
    addBackground(hash, background);
    hash.add(rect.x);
    hash.add(rect.y);
    hash.add(rect.width);
    hash.add(rect.height);
    hash.add(face);
    addView(hash, view);
    addRayScene(hash, stage);
}

namespace {

void addTile(PlanHash& hash, const TargetRect& tile) {
    hash.add(tile.x);
    hash.add(tile.y);
    hash.add(tile.width);
    hash.add(tile.height);
}

}  // namespace

std::vector<TargetId> DrawShadow::reads() const {
    if (still == kNoTarget) return {};
    return {still};
}
std::string_view DrawShadow::knobs() const {
    return "/effects/shadows, /accuracy";
}
std::uint64_t DrawShadow::shadedSamples(const TargetSpec&, const SampleFactors&) const {
    return 0;  // depth only
}
void addTo(PlanHash& hash, const DrawShadow& work, const Stage& stage) {
    addTile(hash, work.tile);
    addDrawnView(hash, work.view, {work.draws}, stage);
    hash.add(work.still != kNoTarget);  // hashOfPasses() adds the key of what is read
}

std::string_view DrawShadowTint::knobs() const {
    return "/effects/shadows, /accuracy";
}
std::uint64_t DrawShadowTint::shadedSamples(const TargetSpec&, const SampleFactors&) const {
    return 0;  // resident, and small next to a picture
}
void addTo(PlanHash& hash, const DrawShadowTint& work, const Stage& stage) {
    addTile(hash, work.tile);
    addDrawnView(hash, work.view, {work.draws}, stage);
}

std::string_view DrawBackFaces::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t DrawBackFaces::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return samplesOf(target);
}
void addTo(PlanHash& hash, const DrawBackFaces& work, const Stage& stage) {
    const auto& [view, draws] = work;
    addDrawnView(hash, view, {draws}, stage);
}

std::string_view DrawChannel::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t DrawChannel::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return samplesOf(target);
}
void addTo(PlanHash& hash, const DrawChannel& work, const Stage& stage) {
    const auto& [view, draws] = work;
    addDrawnView(hash, view, {draws}, stage);
}

std::string_view CopyBackdrop::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t CopyBackdrop::shadedSamples(const TargetSpec& target, const SampleFactors&) const {
    return samplesOf(target);
}
void addTo(PlanHash& hash, const CopyBackdrop& work, const Stage&) {
    const auto& [source, face] = work;  // reads(): source
    hash.add(face);
}

}  // namespace clerestory
