#include "plan/graph/scene_passes.h"

#include "plan/graph/features.h"
#include "plan/graph/frame_plan.h"
#include "plan/graph/stage.h"

#include <algorithm>

namespace clerestory {
namespace {

// ---- what a picture depends on -----------------------------------------------------------------

void addView(PlanHash& hash, const View& view) {
    hash.add(view.viewFromWorld);
    hash.add(view.clipFromView);
    hash.add(view.eye);
    hash.add(view.clipPlane.value_or(glm::dvec4(0.0)));
}

void addLight(PlanHash& hash, const PlacedLight& light) {
    hash.add(light.kind);
    hash.add(light.position);
    hash.add(light.toLight);
    hash.add(light.intensity);
    hash.add(light.range);
    hash.add(light.cosInner);
    hash.add(light.cosOuter);
}

void addDraws(PlanHash& hash, std::span<const Draw> draws, const Stage& stage) {
    hash.add(draws.size());
    for (const Draw& draw : draws) {
        const Instance& instance = stage.scene.instances[draw.instance];
        hash.add(draw.instance);
        hash.add(draw.material);
        hash.add(draw.firstIndex);
        hash.add(draw.indexCount);
        hash.add(draw.features);
        hash.add(draw.reflection);
        hash.add(stage.pose.worldFromNode[instance.node]);
        if (const auto* mesh = deformedMesh(stage.pose, stage.scene.meshes[instance.mesh])) {
            hash.add(mesh->hash);
        }
        hash.add(draw.lights.count);
        for (std::uint32_t i = 0; i < draw.lights.count; ++i) {
            addLight(hash, stage.lights[draw.lights.indices[i]]);
        }
    }
}

void addReflections(PlanHash& hash, const std::vector<ReflectedPicture>& reflections) {
    for (const ReflectedPicture& r : reflections) {
        hash.add(r.origin);
        hash.add(r.scale);
        hash.add(r.pixelsPerSlope);
        hash.add(r.samples);
        hash.add(r.center);
        hash.add(r.proxyMin);
        hash.add(r.proxyMax);
        hash.add(r.normal);
        hash.add(r.ownFromMap);
    }
}

// A ray may meet whatever there is.
void addWhatRaysMeet(PlanHash& hash, const Stage& stage) {
    for (const glm::dmat4& m : stage.pose.worldFromNode) hash.add(m);
    for (const auto& deformed : stage.pose.deformed) hash.add(deformed->hash);
    for (const PlacedLight& light : stage.lights) addLight(hash, light);
    hash.add(stage.settings.accuracy.bounces);
    hash.add(stage.settings.effects.emission);
    hash.add(stage.settings.effects.refraction);
}

template <class Lists>
bool anyDraw(const Lists& lists, auto&& is) {
    return std::any_of(lists.begin(), lists.end(), [&](std::span<const Draw> draws) {
        return std::any_of(draws.begin(), draws.end(), is);
    });
}

template <class Work>
void addDrawnView(PlanHash& hash, const Work& work, const Stage& stage) {
    if (anyDraw(work.drawLists(), [](const Draw& d) { return followsRays(d); })) {
        addWhatRaysMeet(hash, stage);
    }
    addView(hash, work.view);
    for (const std::span<const Draw> draws : work.drawLists()) addDraws(hash, draws, stage);
}

// ---- what it costs -----------------------------------------------------------------------------

std::uint64_t samplesOf(const TargetSpec& target) {
    return texelsOf(target, Faces::one, Levels::first) * std::max(1u, target.samples);
}

// As if every pixel followed rays, or added up directions, where some draw does.
template <class Work>
std::uint64_t litSamples(const Work& work, const TargetSpec& target, const FramePlan& plan) {
    std::uint64_t directions = 1;
    for (const ReflectedPicture& picture : work.reflections) {
        directions = std::max<std::uint64_t>(directions, picture.samples);
    }
    const auto lists = work.drawLists();
    if (anyDraw(lists, [](const Draw& d) { return (d.features & FEATURE_MAP_SAMPLES) != 0; })) {
        directions = std::max<std::uint64_t>(directions, plan.curvedSamples);
    }
    const bool rays = anyDraw(lists, [](const Draw& d) { return followsRays(d); });
    if (rays && plan.rays) directions += plan.rays->bounces;
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
            return "/accuracy/planarScale, /accuracy/generations, /accuracy/samples";
        case Purpose::capture:
            return "/accuracy/probeSize, /accuracy/probeSamples, /accuracy/generations";
    }
    return kKnobsOfTheFrame;
}
std::uint64_t DrawScene::shadedSamples(const TargetSpec& target, const FramePlan& plan) const {
    return litSamples(*this, target, plan);
}
void DrawScene::addTo(PlanHash& hash, const Stage& stage) const {
    hash.add(purpose);
    hash.add(face);
    hash.add(sky);
    addDrawnView(hash, *this, stage);
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
std::uint64_t DrawGlass::shadedSamples(const TargetSpec& target, const FramePlan& plan) const {
    return litSamples(*this, target, plan);
}
void DrawGlass::addTo(PlanHash& hash, const Stage& stage) const {
    hash.add(face);
    addDrawnView(hash, *this, stage);
    addReflections(hash, reflections);
}

std::string_view DrawBackFaces::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t DrawBackFaces::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return samplesOf(target);
}
void DrawBackFaces::addTo(PlanHash& hash, const Stage& stage) const {
    addDrawnView(hash, *this, stage);
}

std::string_view DrawChannel::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t DrawChannel::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return samplesOf(target);
}
void DrawChannel::addTo(PlanHash& hash, const Stage& stage) const {
    addDrawnView(hash, *this, stage);
}

std::string_view CopyBackdrop::knobs() const {
    return kKnobsOfTheFrame;
}
std::uint64_t CopyBackdrop::shadedSamples(const TargetSpec& target, const FramePlan&) const {
    return samplesOf(target);
}
void CopyBackdrop::addTo(PlanHash& hash, const Stage&) const {
    hash.add(face);
}

}  // namespace clerestory
