#include "passes/gpu_tracer.h"

#include "gl/api.h"
#include "passes/draw_stream.h"
#include "passes/gpu_scene.h"
#include "passes/ray_tables.h"
#include "scene/scene.h"

#include <algorithm>

namespace clerestory {
namespace {

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

MaterialBindings materialsOf(const FramePlan& plan) {
    return {plan.materials, plan.rays->materialOfInstance, plan.rays->hidden};
}

}  // namespace

bool GpuTracer::supported() {
    // In the worst case triangles share no vertices.
    constexpr std::uint64_t kMaxTexels =
        std::max<std::uint64_t>(kMaxTracedTexels, 3 * TRACE_VERTEX_PAIRS * kMaxBvhTriangles);
    GLint units = 0, texels = 0;
    glGetIntegerv(GL_MAX_TEXTURE_IMAGE_UNITS, &units);
    glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
    return units > UNIT_TRACE_TEXELS && texels >= 0 &&
           static_cast<std::uint64_t>(texels) >= kMaxTexels;
}

GpuTracer::GpuTracer(const GpuScene& scene)
    : scene_(scene),
      vertexTexture_(scene.vertices(), gl::BufferFormat::rg32f),
      indexTexture_(scene.indices(), gl::BufferFormat::r32ui) {
    static_assert(sizeof(Vertex) == TRACE_VERTEX_PAIRS * sizeof(glm::vec2));
    const std::shared_ptr<const TracedTexels> texels = scene.texels();
    texels_.assign(texels->bytes);
    texelBytes_ = texels->bytes.size();
    textureRows_ = texels->rows;
}

void GpuTracer::prepare(const FramePlan& plan, const Pose& pose) {
    std::vector<std::uint64_t> deformed;
    for (const auto& mesh : pose.deformed) deformed.push_back(mesh->hash);
    const bool moved = !built_ || pose.worldFromNode != worldFromNode_ || deformed != deformed_;
    const bool materialsChanged = !built_ || plan.materials != ownMaterials_ ||
                                  plan.rays->materialOfInstance != rays_.materialOfInstance ||
                                  plan.rays->materials != rays_.materials;
    std::vector<float> sides = sidesOf(scene_.scene(), materialsOf(plan));
    const bool sidesChanged = !built_ || sides != sides_;
    if (moved || sidesChanged) buildHierarchy(plan, pose, sidesChanged);
    if (materialsChanged) fillMaterials(plan);
    sides_ = std::move(sides);
    worldFromNode_ = pose.worldFromNode;
    deformed_ = std::move(deformed);
    ownMaterials_ = plan.materials;
    rays_ = *plan.rays;
    built_ = true;
}

void GpuTracer::buildHierarchy(const FramePlan& plan, const Pose& pose, bool sidesChanged) {
    const Scene& scene = scene_.scene();
    const MaterialBindings materials = materialsOf(plan);
    if (scene.clips.empty()) return uploadHierarchy(buildBvh(scene, pose, materials));
    if (sidesChanged) static_ = buildStill(scene, pose, materials);
    uploadHierarchy(joined(static_, buildMoving(scene, pose, materials, static_)));
}

void GpuTracer::uploadHierarchy(Bvh bvh) {
    // Buffers must not be empty: adds a node that no ray hits.
    if (bvh.nodes.empty()) bvh.nodes.push_back({glm::vec3(1.0f), 0.0f, glm::vec3(-1.0f), -1.0f});
    if (bvh.triangles.empty()) bvh.triangles.emplace_back();
    origin_ = bvh.origin;
    nodeCount_ = bvh.nodes.size();
    nodes_.assign(bytesOf(bvh.nodes));
    triangles_.assign(bytesOf(bvh.triangles));
    hierarchyBytes_ = bytesOf(bvh.nodes).size() + bytesOf(bvh.triangles).size();
}

void GpuTracer::fillMaterials(const FramePlan& plan) {
    std::vector<glm::vec4> rows = materialRows(scene_.scene(), plan);
    materialCount_ = rows.size() / TRACE_MATERIAL_ROWS;
    rows.insert(rows.end(), textureRows_.begin(), textureRows_.end());
    if (rows.empty()) rows.resize(1);
    materials_.assign(bytesOf(rows));
    tableBytes_ = bytesOf(rows).size();
}

void GpuTracer::addInstances(DrawStream& draws) {
    instances_.assign(bytesOf(instanceRows(scene_.scene(), rays_, draws)));
}

void GpuTracer::bind(const FramePlan& plan, const glm::dvec3& eye,
                     const OwnBackground& background) {
    blocks::TraceBlock block{};
    block.eye = glm::vec4(glm::vec3(eye - origin_), static_cast<float>(nodeCount_));
    block.limits = {plan.rays->bounces, materialCount_ * TRACE_MATERIAL_ROWS, 0.0f, 0.0f};
    if (background.radiance) block.background = glm::vec4(*background.radiance, 1.0f);
    block_.assign(blocks::bytesOf(block));
    block_.bindUniform(BINDING_TRACE);
    nodeTexture_.bind(UNIT_TRACE_NODES);
    triangleTexture_.bind(UNIT_TRACE_TRIANGLES);
    vertexTexture_.bind(UNIT_TRACE_VERTICES);
    indexTexture_.bind(UNIT_TRACE_INDICES);
    instanceTexture_.bind(UNIT_TRACE_INSTANCES);
    materialTexture_.bind(UNIT_TRACE_MATERIALS);
    texelTexture_.bind(UNIT_TRACE_TEXELS);
}

std::uint64_t GpuTracer::bytes() const {
    return texelBytes_ + hierarchyBytes_ + tableBytes_;
}

}  // namespace clerestory
