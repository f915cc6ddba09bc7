// What rays need on the GPU: the hierarchy over the scene as it stands, its vertices by number, and
// tables of instances, materials and texels, all as texture buffers. Made when a plan first traces,
// freed with the scene.
#pragma once

#include "gl/buffer.h"
#include "passes/blocks.h"
#include "plan/graph/frame_plan.h"
#include "scene/bvh.h"

#include <vector>

namespace clerestory {

class DrawStream;
class GpuScene;

class GpuTracer {
public:
    // Whether the driver at hand has the texture units and the buffer textures for it, for any
    // scene of up to kMaxBvhTriangles.
    static bool offered();

    // Uploads what no frame changes. `scene` must outlive it.
    explicit GpuTracer(const GpuScene& scene);

    // Follows the pose and the plan's materials and rays (plan.rays is set); does nothing for what
    // has not changed.
    void prepare(const FramePlan& plan, const Pose& pose);
    // For one pass, between DrawStream::begin() and its upload(): where everything stands in the
    // pass's eye space, and which lights reach it.
    void addPlaces(DrawStream& draws);
    // Buffers and block, for rays from a view whose eye stands here (world).
    void bind(const FramePlan& plan, const glm::dvec3& eye);

    std::uint64_t bytes() const;

private:
    void buildHierarchy(const FramePlan& plan, const Pose& pose, bool materialsChanged);
    void uploadHierarchy(Bvh bvh);
    void fillMaterials(const FramePlan& plan);

    const GpuScene& scene_;
    std::vector<glm::vec4> textureRows_;
    std::uint64_t texelBytes_ = 0, hierarchyBytes_ = 0, tableBytes_ = 0;

    gl::Buffer nodes_, triangles_, instances_, materials_, texels_, block_;
    gl::BufferTexture nodeTexture_{nodes_}, triangleTexture_{triangles_},
        instanceTexture_{instances_}, materialTexture_{materials_},
        texelTexture_{texels_, gl::BufferFormat::rgba8};
    gl::BufferTexture vertexTexture_, indexTexture_;

    // What the buffers hold.
    glm::dvec3 origin_{0.0};
    std::size_t nodeCount_ = 0, materialCount_ = 0;
    bool built_ = false;
    Bvh still_;  // of a scene in which something moves: the part that does not
    std::vector<glm::dmat4> worldFromNode_;
    std::vector<std::uint64_t> deformed_;  // hashes; as Pose::deformed
    std::vector<Material> ownMaterials_;
    RayScene rays_;
};

}  // namespace clerestory
