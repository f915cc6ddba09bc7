#include "passes/gpu_tracer.h"

#include "gl/api.h"
#include "passes/draw_stream.h"
#include "passes/gpu_scene.h"
#include "passes/traced_texels.h"
#include "scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace clerestory {
namespace {

template <class T>
std::span<const std::byte> bytesOf(const std::vector<T>& values) {
    return std::as_bytes(std::span(values));
}

MaterialBindings materialsOf(const FramePlan& plan) {
    return {plan.materials, plan.rays->materialOfInstance};
}

float flagsOf(const Scene& scene, const Material& m,
              const RayScene::MaterialProperties& properties) {
    int flags = 0;
    if (m.alphaMode == AlphaMode::mask) flags |= TRACE_MASK;
    if (m.alphaMode == AlphaMode::blend) flags |= TRACE_BLEND;
    if (m.doubleSided) flags |= TRACE_DOUBLE_SIDED;
    if (m.unlit) flags |= TRACE_UNLIT;
    if (m.normalTexture.present() &&
        scene.images[scene.textures[m.normalTexture.texture].image].packedNormal) {
        flags |= TRACE_PACKED_NORMAL;
    }
    if (properties.mirrorsWhereFlat) flags |= TRACE_MIRROR_FLAT;
    if (properties.mirrorsWhereCurved) flags |= TRACE_MIRROR_CURVED;
    return static_cast<float>(flags);
}

// A MaterialBlock with the flags and the texture of each slot (1 + index, 0: none) in unused
// components.
void appendMaterial(std::vector<glm::vec4>& rows, const Scene& scene, const Material& m,
                    const RayScene::MaterialProperties& properties) {
    blocks::MaterialBlock block = materialBlock(m);
    block.attenuation.w = flagsOf(scene, m, properties);
    const auto slots = textureSlots(m);
    for (std::size_t s = 0; s < slots.size(); ++s) {
        block.texCoordRows[2 * s + 1].w =
            slots[s]->present() ? static_cast<float>(slots[s]->texture + 1) : 0.0f;
    }
    static_assert(sizeof block == TRACE_MATERIAL_ROWS * sizeof(glm::vec4));
    const std::size_t first = rows.size();
    rows.resize(first + TRACE_MATERIAL_ROWS);
    std::memcpy(rows.data() + first, &block, sizeof block);
}

int flagOf(Glass glass) {
    switch (glass) {
        case Glass::none:
            return 0;
        case Glass::pane:
            return TRACE_PANE;
        case Glass::solid:
            return TRACE_SOLID;
    }
    return 0;
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
    TracedTexels texels = tracedTexels(scene.scene(), scene.images());
    texels_.assign(texels.bytes);
    texelBytes_ = texels.bytes.size();
    textureRows_ = std::move(texels.rows);
}

void GpuTracer::prepare(const FramePlan& plan, const Pose& pose) {
    std::vector<std::uint64_t> deformed;
    for (const auto& mesh : pose.deformed) deformed.push_back(mesh->hash);
    const bool moved = !built_ || pose.worldFromNode != worldFromNode_ || deformed != deformed_;
    const bool materialsChanged = !built_ || plan.materials != ownMaterials_ ||
                                  plan.rays->materialOfInstance != rays_.materialOfInstance ||
                                  plan.rays->materials != rays_.materials;
    if (moved || materialsChanged) buildHierarchy(plan, pose, materialsChanged);
    if (materialsChanged) fillMaterials(plan);
    worldFromNode_ = pose.worldFromNode;
    deformed_ = std::move(deformed);
    ownMaterials_ = plan.materials;
    rays_ = *plan.rays;
    built_ = true;
}

void GpuTracer::buildHierarchy(const FramePlan& plan, const Pose& pose, bool materialsChanged) {
    const Scene& scene = scene_.scene();
    const MaterialBindings materials = materialsOf(plan);
    if (scene.clips.empty()) return uploadHierarchy(buildBvh(scene, pose, materials));
    if (materialsChanged) static_ = buildStill(scene, pose, materials);
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
    std::vector<glm::vec4> rows;
    const Scene& scene = scene_.scene();
    auto properties = plan.rays->materials.begin();
    for (const Material& m : scene.materials) appendMaterial(rows, scene, m, *properties++);
    for (const Material& m : plan.materials) appendMaterial(rows, scene, m, *properties++);
    materialCount_ = rows.size() / TRACE_MATERIAL_ROWS;
    rows.insert(rows.end(), textureRows_.begin(), textureRows_.end());
    if (rows.empty()) rows.resize(1);
    materials_.assign(bytesOf(rows));
    tableBytes_ = bytesOf(rows).size();
}

void GpuTracer::addInstances(DrawStream& draws) {
    const Scene& scene = scene_.scene();
    std::vector<glm::vec4> rows;
    rows.reserve(TRACE_INSTANCE_ROWS * scene.instances.size());
    for (Index i = 0; i < scene.instances.size(); ++i) {
        const DrawRecord& record = draws.record(i);
        const std::vector<std::uint8_t>& lights = rays_.instances[i].lights;
        const Index material = rays_.materialOfInstance.empty() ? scene.instances[i].material
                                                                : rays_.materialOfInstance[i];
        for (int row = 0; row < 3; ++row) rows.push_back(record.normalFromModel[row]);
        for (int row = 0; row < 3; ++row) rows.push_back(record.eyeFromModel[row]);
        glm::vec4* instance = rows.data() + rows.size() - TRACE_INSTANCE_ROWS;
        instance[0].w = static_cast<float>(material);
        instance[1].w = static_cast<float>(draws.firstLight(lights));
        instance[2].w = static_cast<float>(lights.size());
        const glm::mat3 linear(instance[3], instance[4], instance[5]);  // its transpose
        instance[3].w = draws.mirrored(i) ? -1.0f : 1.0f;
        instance[5].w = static_cast<float>(flagOf(rays_.instances[i].glass));
        instance[4].w = std::cbrt(std::abs(glm::determinant(linear)));
    }
    if (rows.empty()) rows.resize(1);
    instances_.assign(bytesOf(rows));
}

void GpuTracer::bind(const FramePlan& plan, const glm::dvec3& eye) {
    blocks::TraceBlock block{};
    block.eye = glm::vec4(glm::vec3(eye - origin_), static_cast<float>(nodeCount_));
    block.limits = {plan.rays->bounces, materialCount_ * TRACE_MATERIAL_ROWS, 0.0f, 0.0f};
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
