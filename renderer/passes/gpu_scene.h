// Vertices, textures and materials of a scene as OpenGL objects.
#pragma once

#include "gl/buffer.h"
#include "gl/texture.h"
#include "passes/material_blocks.h"
#include "passes/ray_tables.h"
#include "plan/graph/frame_plan.h"
#include "scene/scene.h"

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

namespace clerestory {

// Creates one sampler object per description.
class SamplerCache {
public:
    const gl::Sampler& sampler(const gl::SamplerDescription& description);

private:
    std::map<gl::SamplerDescription, gl::Sampler> samplers_;
};

// Materials that belong to one frame (FramePlan::materials).
struct FrameMaterials {
    std::span<const Material> materials;
    const MaterialBlocks& blocks;
};

// How surfaces read their textures.
struct TextureFilter {
    std::uint32_t anisotropy = 1;
    int colorLevelsBelow = 0;  // gl::SamplerDescription::levelsBelow of colours
};

class GpuScene {
public:
    // Uploads everything; constant vertices may be read from the memory of `scene`, see
    // gl::Buffer::sharing(). `drawRecords` holds the per-draw attributes and must outlive this
    // object. `texturesOf`: scenes with the images of this one, one after another, whose textures
    // are shared; none: it uploads its own. afterImage: see Executor::upload().
    GpuScene(std::shared_ptr<const Scene> scene, const gl::Buffer& drawRecords,
             std::span<const GpuScene* const> texturesOf = {},
             const std::function<void(std::size_t)>& afterImage = {});

    // Uploads the vertices of deformed meshes that changed since the last call. Returns the number
    // of these meshes.
    std::uint64_t follow(const Pose& pose);
    // Makes the next follow() upload all deformed meshes.
    void forgetPose() { deformed_.clear(); }

    const Scene& scene() const { return *scene_; }
    const gl::VertexArray& vertexArray() const { return vertexArray_; }
    const gl::Buffer& vertices() const { return vertices_; }
    const gl::Buffer& indices() const { return indices_; }
    // For DrawParts.
    std::span<const float> clusterAreas() const;
    // For rays; read from the textures on first use and shared as they are.
    std::shared_ptr<const TracedTexels> texels() const;
    // Binds the material's block and those of its textures that `features` reads; white where it
    // has none. Materials beyond the scene's are those of `own`.
    void bindMaterial(Index material, const FrameMaterials& own, Features features,
                      const TextureFilter& filter, SamplerCache& samplers) const;

private:
    std::shared_ptr<const Scene> scene_;
    gl::Buffer vertices_, indices_;
    gl::VertexArray vertexArray_;
    MaterialBlocks materials_;
    std::vector<std::shared_ptr<const gl::Texture>> images_;
    std::shared_ptr<std::weak_ptr<const TracedTexels>> texels_;
    mutable std::vector<float> clusterAreas_;
    // For slots that a program samples and a material leaves empty: like the slot's first texture
    // in the scene, so that a driver compiles nothing for it.
    struct White {
        gl::Texture texture;
        Texture sampledAs;
    };
    std::map<std::size_t, White> whites_;
    std::vector<std::uint64_t> deformed_;  // hashes of the uploaded Pose::deformed
};

}  // namespace clerestory
