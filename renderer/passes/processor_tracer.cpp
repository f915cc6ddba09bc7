#include "passes/processor_tracer.h"

#include "passes/blocks.h"
#include "passes/draw_stream.h"
#include "passes/gpu_scene.h"
#include "passes/ray_tables.h"
#include "scene/environment.h"

#include <algorithm>

namespace clerestory {

ProcessorTracer::ProcessorTracer(const GpuScene& scene) : scene_(scene), texels_(scene.texels()) {}

void ProcessorTracer::prepare(const FramePlan& plan, const Pose& pose, std::uint64_t frame) {
    frame_ = frame;
    const Scene& scene = scene_.scene();
    std::vector<std::uint64_t> deformed;
    for (const auto& mesh : pose.deformed) deformed.push_back(mesh->hash);
    const bool materialsChanged = !built_ || plan.materials != ownMaterials_ ||
                                  plan.rays->materialOfInstance != rays_.materialOfInstance ||
                                  plan.rays->materials != rays_.materials;
    const bool moved = !built_ || pose.worldFromNode != worldFromNode_ || deformed != deformed_;
    const MaterialBindings materials{plan.materials, plan.rays->materialOfInstance,
                                     plan.rays->hidden};
    std::vector<float> sides = sidesOf(scene, materials);
    const bool sidesChanged = !built_ || sides != sides_;
    if (sidesChanged) {
        finishTree();
        BvhTriangles still = stillTriangles(scene, pose, materials);
        origin_ = still.origin;
        stillTriangles_ = still.triangles.size();
        building_ = std::async(std::launch::async,
                               [&tree = tree_, triangles = std::move(still.triangles)]() mutable {
                                   tree.setStill(std::move(triangles));
                               });
    }
    if (materialsChanged) {
        materials_ = materialRows(scene, plan);
        firstTextureRow_ = materials_.size();
        materials_.insert(materials_.end(), texels_->rows.begin(), texels_->rows.end());
    }
    if (moved || sidesChanged) {
        auto moving = movingTriangles(scene, pose, materials, stillTriangles_).triangles;
        if (!moving.empty()) finishTree();
        tree_.setMoving(std::move(moving));
    }
    if (moved && !pose.deformed.empty()) {
        if (vertices_.empty()) vertices_ = scene.vertices;
        for (const auto& mesh : pose.deformed) {
            std::copy(mesh->vertices.begin(), mesh->vertices.end(),
                      vertices_.begin() + static_cast<std::ptrdiff_t>(mesh->firstVertex));
        }
    }
    sides_ = std::move(sides);
    worldFromNode_ = pose.worldFromNode;
    deformed_ = std::move(deformed);
    ownMaterials_ = plan.materials;
    rays_ = *plan.rays;
    built_ = true;
}

void ProcessorTracer::finishTree() {
    if (building_.valid()) building_.get();
}

void ProcessorTracer::bind(const glm::dvec3& eye, const OwnBackground& background) {
    blocks::TraceBlock block{};
    block.eye = glm::vec4(glm::vec3(eye - origin_), 0.0f);
    block.limits = {0.0f, 0.0f, rays_.leastShare, 0.0f};
    if (background.radiance) block.background = glm::vec4(*background.radiance, 1.0f);
    block_.assign(blocks::bytesOf(block));
    block_.bindUniform(BINDING_TRACE);
}

const rays::CubeMap& ProcessorTracer::cubeOf(const Target* environment) {
    const std::uint64_t key = environment ? environment->spec().residentKey : 0;
    if (key != 0 && key == cubeKey_) return cube_;
    cubeKey_ = key;
    if (!environment) {
        cube_ = rays::CubeMap(1, 1);
        return cube_;
    }
    const TargetSpec& spec = environment->spec();
    cube_ = rays::CubeMap(spec.width, spec.levels);
    std::vector<float> texels;
    for (std::uint32_t level = 0; level < spec.levels; ++level) {
        for (std::uint32_t face = 0; face < 6; ++face) {
            const gl::Framebuffer& source = environment->face(level, face);
            texels.resize(std::size_t{4} * source.width() * source.height());
            source.readFloats(texels);
            cube_.setFace(level, face, texels);
        }
    }
    cube_.joinEdges();
    return cube_;
}

// Maps of a warm-up have no keys, and are read each time.
const rays::ShadowMap& ProcessorTracer::shadowMapOf(const Target& shadows, const TargetRect& part,
                                                    const Target* tints) {
    const TargetSpec& spec = shadows.spec();
    const std::uint64_t key = spec.residentKey, tintsKey = tints ? tints->spec().residentKey : 0;
    if (key != 0 && key == depthsKey_ && tintsKey == tintsKey_) {
        // One that lasts is worth a summary.
        if (shadowMap_.blocks.empty() && frame_ != frameOfShadowMap_) shadowMap_.summarize();
        return shadowMap_;
    }
    frameOfShadowMap_ = frame_;
    shadowMap_.blocks.clear();
    shadowMap_.clearBlocks.clear();
    if (key == 0 || key != depthsKey_) {
        shadowMap_.width = part.width;
        shadowMap_.height = part.height;
        shadowMap_.depths.resize(std::size_t{part.width} * part.height);
        shadows.readable().readDepths({part.x, part.y, part.width, part.height}, shadowMap_.depths);
    }
    if (tintsKey == 0 || tintsKey != tintsKey_) {
        shadowMap_.tints.clear();
        if (tints) {
            shadowMap_.tints.resize(std::size_t{tints->spec().width} * tints->spec().height);
            tints->readable().readHalves(shadowMap_.tints);
        }
    }
    depthsKey_ = key;
    tintsKey_ = tintsKey;
    return shadowMap_;
}

rays::Surroundings ProcessorTracer::sceneAround(const FramePlan& plan, DrawStream& draws,
                                                const Target* environment) {
    finishTree();
    const Scene& scene = scene_.scene();
    instances_ = instanceRows(scene, rays_, draws);
    return {.tree = tree_,
            .vertices = vertices_.empty() ? std::span<const Vertex>(scene.vertices) : vertices_,
            .indices = scene.indices,
            .instances = instances_,
            .materials = materials_,
            .firstTextureRow = firstTextureRow_,
            .texels = texels_->bytes,
            .lights = draws.lightRows(),
            .environment = cubeOf(environment),
            .environmentIntensity = plan.environmentIntensity,
            .brdf = environmentBrdfTable(),
            .brdfSize = kEnvironmentBrdfSize,
            .hitFeatures = rays_.hitFeatures};
}

void ProcessorTracer::beginPass(const FramePlan& plan, const FollowRays& work,
                                const Target* environment, const Target* shadows,
                                const Target* tints, DrawStream& draws, const gl::Rect& rect,
                                const light::SurfaceLight* surfaceLight,
                                std::span<const light::LightValue> movingLight) {
    const View& view = work.view;
    std::span<const std::uint32_t> values, emitters;
    if (surfaceLight) {
        std::span<const light::LightValue> all = surfaceLight->values;
        if (!movingLight.empty()) {
            lightValues_.assign(all.begin(), all.end());
            std::copy(movingLight.begin(), movingLight.end(), lightValues_.begin() + 1);
            all = lightValues_;
        }
        values = {all.front().halves, 8 * all.size()};
        if (plan.emitters && !surfaceLight->emitters.empty()) {
            emitters = {surfaceLight->emitters.front().halves, 4 * surfaceLight->emitters.size()};
        }
    }
    rays::Surroundings around = sceneAround(plan, draws, environment);
    around.eye = glm::vec3(view.eye - origin_);
    if (view.orthographic) {
        around.towardsEye = glm::vec3(glm::transpose(glm::dmat3(view.viewFromWorld))[2]);
    }
    around.worldFromEye = glm::mat3(glm::transpose(plan.mapFromWorld));
    around.bounces = rays_.bounces;
    around.surfaceLight = values;
    around.emitters = emitters;
    around.roundLights = hasRoundLight(plan.lights);
    around.shadows = shadows != nullptr;
    if (shadows && !rays_.shadowRays) {
        around.shadowMap = &shadowMapOf(*shadows, plan.wholeShadows, tints);
    }
    around.shadowSamples = shadows ? plan.shadowSamples : 0;
    around.leastShare = rays_.leastShare;
    around.background = work.background.radiance;
    surroundings_.emplace(around);
    rect_ = rect;
    radiance_.assign(std::size_t{rect.width} * rect.height, glm::vec4(0.0f));
    stride_ = work.everyPixel ? 1 : rays_.stride;
}

const rays::Surroundings& ProcessorTracer::beginLookups(const FramePlan& plan, DrawStream& draws) {
    return surroundings_.emplace(sceneAround(plan, draws, nullptr));
}

std::uint64_t ProcessorTracer::follow(std::size_t list, const gl::Framebuffer& starts,
                                      const gl::Framebuffer& ways) {
    starts_.resize(radiance_.size());
    ways_.resize(radiance_.size());
    starts.readWords(rect_, std::as_writable_bytes(std::span(starts_)));
    ways.readWords(rect_, std::as_writable_bytes(std::span(ways_)));
    const std::uint32_t lobePaths = list == 0 ? rays_.lobePaths : rays_.glassLobePaths;
    return rays::follow(*surroundings_,
                        {stride_, std::min(stride_, rays_.finest), rays_.contrast,
                         rays_.contrastNextTo, rays_.contrastBetween, lobePaths},
                        {.kind = list == 0 ? rays::Ray::mirrored : rays::Ray::transmitted,
                         .width = rect_.width,
                         .starts = starts_,
                         .ways = ways_},
                        radiance_, paths_[list]);
}

void ProcessorTracer::releaseScratch() {
    shadowMap_ = {};
    depthsKey_ = tintsKey_ = 0;
    paths_ = {};
    std::vector<rays::Start>().swap(starts_);
    std::vector<rays::Way>().swap(ways_);
    std::vector<glm::vec4>().swap(radiance_);
}

std::uint64_t ProcessorTracer::bytes() {
    finishTree();
    return tree_.bytes() + texels_->bytes.size() + materials_.size() * sizeof(glm::vec4) +
           vertices_.size() * sizeof(Vertex) + shadowMap_.bytes();
}

}  // namespace clerestory
