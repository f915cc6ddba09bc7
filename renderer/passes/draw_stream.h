// Per-draw data of a pass, collected and uploaded together: transforms relative to the eye, lists
// of lights, and the diffuse harmonics of the environment.
#pragma once

#include "gl/buffer.h"
#include "gl/pipeline.h"
#include "light/surface_light.h"
#include "plan/graph/frame_plan.h"
#include "scene/scene.h"

#include <array>
#include <map>
#include <vector>

namespace clerestory {

// Vertex attributes with divisor 1 of one draw.
struct DrawRecord {
    glm::vec4 eyeFromModel[3];     // rows
    glm::vec4 normalFromModel[3];  // rows; w: drawNumbers in surface_varyings.glsl
};
static_assert(sizeof(DrawRecord) == 96);

class DrawStream {
public:
    const gl::Buffer& records() const { return records_; }
    const gl::BufferTexture& lights() const { return lightTexture_; }

    // Clears the stream for a view. Eye space has its origin at the eye and its axes are those of
    // the world, rotated by `axesFromWorld`. The arguments must outlive the stream's use.
    void begin(const Scene& scene, const Pose& pose, const View& view,
               const glm::dmat3& axesFromWorld, const std::vector<PlacedLight>& lights);
    // Sets the diffuse light of the environment, in the axes of eye space; zero without a call.
    void setHarmonics(const std::array<glm::vec3, 9>& harmonics, float intensity);
    // Values of light at vertices for the draws and the rays of the view; see
    // light/surface_light.h. Must outlive the stream's use.
    void setSurfaceLight(const light::SurfaceLight& light) { surfaceLight_ = &light; }
    // Where the values of an instance begin; with a half added: the one of all its vertices.
    float firstLightValue(std::uint32_t instance) const;
    // Returns the index of the first draw's record; the others follow it.
    std::uint32_t add(const std::vector<Draw>& draws);
    // For ray tracing, which may hit any instance. firstLight() adds a list of lights of any length
    // and returns the index of its first entry.
    const DrawRecord& record(std::uint32_t instance) { return instanceData(instance).record; }
    bool mirrored(std::uint32_t instance) { return instanceData(instance).mirrored; }
    std::uint32_t firstLight(const std::vector<std::uint8_t>& list);
    void upload();
    // The light table, for rays on the processor; see bindings.glsl.
    std::span<const glm::vec4> lightRows() const { return lightData_; }

    gl::Facing facing(const Draw& draw, bool doubleSided) const;

private:
    struct InstanceData {
        DrawRecord record;
        bool mirrored = false;
    };
    const InstanceData& instanceData(std::uint32_t instance);

    gl::Buffer records_, lightRows_;
    gl::BufferTexture lightTexture_{lightRows_};

    const Scene* scene_ = nullptr;
    const Pose* pose_ = nullptr;
    const View* view_ = nullptr;
    glm::dmat3 axesFromWorld_{1.0};
    const std::vector<PlacedLight>* lights_ = nullptr;
    const light::SurfaceLight* surfaceLight_ = nullptr;
    std::map<std::uint32_t, InstanceData> instances_;
    std::map<std::vector<std::uint8_t>, std::uint32_t> lists_;
    std::vector<DrawRecord> recordData_;
    std::vector<glm::vec4> lightData_;
};

}  // namespace clerestory
