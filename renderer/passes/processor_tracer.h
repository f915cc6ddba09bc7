// Follows the recorded rays of a scene on the processor: keeps the hierarchy and the tables that no
// pass changes, and hands them to renderer/rays. Created by the first plan that needs it, freed
// with the scene.
#pragma once

#include "gl/buffer.h"
#include "light/surface_light.h"
#include "passes/ray_tables.h"
#include "passes/targets.h"
#include "plan/graph/frame_plan.h"
#include "rays/follow.h"

#include <array>
#include <future>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace clerestory {

class DrawStream;
class GpuScene;

class ProcessorTracer {
public:
    // Reads the texels of the scene's textures. `scene` must outlive this object.
    explicit ProcessorTracer(const GpuScene& scene);

    // Updates what changed with the pose or with the plan's materials and rays. Requires plan.rays.
    // The hierarchy of what stays is built on another thread, which the first ray waits for. frame:
    // counts frames.
    void prepare(const FramePlan& plan, const Pose& pose, std::uint64_t frame);
    // Binds the uniform block that programs with RECORDS_RAYS read; eye: world.
    void bind(const glm::dvec3& eye, const OwnBackground& background);

    // Begins a pass. environment: the prefiltered map, or null for darkness. draws: begun for the
    // view, with the harmonics of the environment; must outlive the pass. rect: of the records.
    // shadows: what the lights see; may be null.
    // surfaceLight: values at vertices; may be null. movingLight: see light::lightOfMoving().
    void beginPass(const FramePlan& plan, const FollowRays& work, const Target* environment,
                   const Target* shadows, const Target* tints, DrawStream& draws,
                   const gl::Rect& rect, const light::SurfaceLight* surfaceLight,
                   std::span<const light::LightValue> movingLight);
    // Follows one ray of each pixel; `list` numbers them. Returns the number of paths.
    std::uint64_t follow(std::size_t list, const gl::Framebuffer& starts,
                         const gl::Framebuffer& ways);
    // For each pixel of `rect`: the light along its rays (rgb).
    std::span<const glm::vec4> radiance() const { return radiance_; }

    // For passes that only ask what rays meet: begins one whose eye space has the world's axes.
    // draws: begun for its view. The surroundings are relative to origin() and valid until the
    // next pass.
    const rays::Surroundings& beginLookups(const FramePlan& plan, DrawStream& draws);
    const glm::dvec3& origin() const { return origin_; }

    std::uint64_t bytes();
    // Frees the copies of shadow maps and the tables of the last pass. The next pass fills them
    // again.
    void releaseScratch();

private:
    // What rays meet: the scene with the draws' instances and lights, before the environment or, if
    // null, blackness. Eye space is that of `draws`.
    rays::Surroundings sceneAround(const FramePlan& plan, DrawStream& draws,
                                   const Target* environment);
    const rays::CubeMap& cubeOf(const Target* environment);
    // part: of the shadow map.
    const rays::ShadowMap& shadowMapOf(const Target& shadows, const TargetRect& part,
                                       const Target* tints);

    void finishTree();

    const GpuScene& scene_;
    rays::TriangleTree tree_;
    std::size_t stillTriangles_ = 0;
    std::future<void> building_;  // tree_; after it, so that it ends before
    std::shared_ptr<const TracedTexels> texels_;
    std::vector<glm::vec4> materials_;  // then the textures
    std::size_t firstTextureRow_ = 0;
    std::vector<Vertex> vertices_;  // in the pose; empty if no mesh deforms
    gl::Buffer block_;
    rays::CubeMap cube_;
    rays::ShadowMap shadowMap_;
    // Of the present pass; members so that a frame allocates nothing.
    std::vector<glm::vec4> instances_;
    std::optional<rays::Surroundings> surroundings_;
    std::vector<light::LightValue> lightValues_;  // if something moves
    gl::Rect rect_;
    std::uint32_t stride_ = 1;
    std::vector<rays::Start> starts_;
    std::array<rays::Scratch, 2> paths_;  // of each list
    std::vector<rays::Way> ways_;
    std::vector<glm::vec4> radiance_;

    // TargetSpec::residentKey of cube_, and of both maps in shadowMap_; 0: none.
    std::uint64_t cubeKey_ = 0, depthsKey_ = 0, tintsKey_ = 0;
    std::uint64_t frame_ = 0, frameOfShadowMap_ = 0;

    // The state of the members above.
    glm::dvec3 origin_{0.0};
    bool built_ = false;
    std::vector<glm::dmat4> worldFromNode_;
    std::vector<std::uint64_t> deformed_;
    std::vector<float> sides_;  // sidesOf() the materials
    std::vector<Material> ownMaterials_;
    RayScene rays_;
};

}  // namespace clerestory
