// Triangles of one material under a map of one colour, for rays on the processor.
#pragma once

#include "rays/path.h"
#include "scene/environment.h"
#include "shaders/include/bindings.glsl"

#include <cstdint>
#include <vector>

namespace clerestory::rays {

class RayRoom {
public:
    // map: radiance of the environment.
    explicit RayRoom(float map) : map_(8, 4), brdf_(environmentBrdfTable(8)) {
        for (std::uint32_t level = 0; level < 4; ++level) {
            const std::uint32_t size = 8 >> level;
            const std::vector<float> texels(std::size_t{4} * size * size, map);
            for (std::uint32_t face = 0; face < 6; ++face) map_.setFace(level, face, texels);
        }
        map_.joinEdges();
        instances_.assign(TRACE_INSTANCE_ROWS, glm::vec4(0.0f));
        for (int row = 0; row < 6; ++row) instances_[row][row % 3] = 1.0f;
        instances_[3].w = instances_[4].w = 1.0f;
        materials_.assign(TRACE_MATERIAL_ROWS, glm::vec4(0.0f));
        materials_[0] = glm::vec4(1.0f);
        materials_[4].y = 1.5f;
        for (Vertex& vertex : vertices_) vertex.normal = {0.0f, 0.0f, -1.0f};
    }

    // A triangle that rays hit from both sides. Its normal is -Z.
    void add(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
        triangles_.push_back({a, 0.0f, b, 0.0f, c, 0.0f});
        tree_.setStill(triangles_);
    }
    // Greys at the corners of each triangle, times the material's colour.
    void colorCorners(float a, float b, float c) {
        vertices_[0].color = glm::vec4(glm::vec3(a), 1.0f);
        vertices_[1].color = glm::vec4(glm::vec3(b), 1.0f);
        vertices_[2].color = glm::vec4(glm::vec3(c), 1.0f);
        features_ |= kVertexColor;
    }
    // As in passes/ray_tables.h.
    glm::vec4& materialRow(int row) { return materials_[static_cast<std::size_t>(row)]; }

    // Refers to this object.
    Surroundings surroundings(const glm::vec3& eye) const {
        return {.tree = tree_,
                .vertices = vertices_,
                .indices = indices_,
                .instances = instances_,
                .materials = materials_,
                .firstTextureRow = materials_.size(),
                .texels = {},
                .lights = {},
                .environment = map_,
                .brdf = brdf_,
                .brdfSize = 8,
                .eye = eye,
                .bounces = 2,
                .hitFeatures = features_};
    }

private:
    static constexpr std::uint32_t kUnlit = 1u << 12;       // FEATURE_UNLIT
    static constexpr std::uint32_t kVertexColor = 1u << 6;  // FEATURE_VERTEX_COLOR
    std::uint32_t features_ = kUnlit;
    CubeMap map_;
    TriangleTree tree_;
    std::vector<BvhTriangle> triangles_;
    std::vector<glm::vec2> brdf_;
    std::vector<glm::vec4> instances_, materials_;
    std::vector<Vertex> vertices_{3};
    std::vector<std::uint32_t> indices_{0, 1, 2};
};

}  // namespace clerestory::rays
