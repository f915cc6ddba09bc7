// GPU data for ray tracing through a scene, as texture buffers: bounding volume hierarchy,
// vertices, and tables of instances, materials and texels. Created by the first plan that traces
// rays, freed with the scene.
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
    // Returns true if the driver has enough texture units and large enough buffer textures for any
    // scene of up to kMaxBvhTriangles.
    static bool supported();

    // Uploads the data that no frame changes. `scene` must outlive this object.
    explicit GpuTracer(const GpuScene& scene);

    // Updates the data that changed with the pose or with the plan's materials and rays. Requires
    // plan.rays.
    void prepare(const FramePlan& plan, const Pose& pose);
    // Fills the table of instances for one pass: transforms to its eye space, and lights. Call it
    // between DrawStream::begin() and upload().
    void addInstances(DrawStream& draws);
    // Binds the buffers and the uniform block for rays from a view; eye: world.
    void bind(const FramePlan& plan, const glm::dvec3& eye, const OwnBackground& background = {});

    std::uint64_t bytes() const;

private:
    void buildHierarchy(const FramePlan& plan, const Pose& pose, bool sidesChanged);
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

    // Content of the buffers.
    glm::dvec3 origin_{0.0};
    std::size_t nodeCount_ = 0, materialCount_ = 0;
    bool built_ = false;
    Bvh static_;  // of an animated scene: the part that does not move
    std::vector<glm::dmat4> worldFromNode_;
    std::vector<std::uint64_t> deformed_;  // hashes of Pose::deformed
    std::vector<float> sides_;             // sidesOf() the materials
    std::vector<Material> ownMaterials_;
    RayScene rays_;
};

}  // namespace clerestory
