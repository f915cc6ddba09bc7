// What changes from draw to draw, gathered for a whole pass and uploaded at once: transforms
// relative to the eye, and the light: the environment's diffuse one and the lists of lamps.
#pragma once

#include "gl/buffer.h"
#include "gl/state.h"
#include "plan/graph/frame_plan.h"
#include "scene/scene.h"

#include <array>
#include <map>
#include <vector>

namespace clerestory {

// Per-instance vertex attributes of one draw.
struct DrawRecord {
    glm::vec4 eyeFromModel[3];  // rows
    glm::vec4
        normalFromModel[3];  // rows; w: first light, number of lights, object id or Draw::through
};
static_assert(sizeof(DrawRecord) == 96);

class DrawStream {
public:
    const gl::Buffer& records() const { return records_; }
    const gl::BufferTexture& lights() const { return lightTexture_; }

    // Starts anew for a view. Axes of eye space: those of the world, turned by `axesFromWorld`.
    void begin(const Scene& scene, const Pose& pose, const View& view,
               const glm::dmat3& axesFromWorld, const std::vector<PlacedLight>& lights);
    // The environment's diffuse light in eye space's axes; without a call it is dark.
    void setHarmonics(const std::array<glm::vec3, 9>& harmonics, float intensity);
    // Returns the place of the first draw's record; the others follow it.
    std::uint32_t add(const std::vector<Draw>& draws);
    // For rays, which may meet any instance: where it stands, and a list of lights of any length,
    // of which the first one's number is returned.
    const DrawRecord& place(std::uint32_t instance) { return placed(instance).record; }
    bool mirrored(std::uint32_t instance) { return placed(instance).mirrored; }
    std::uint32_t firstLight(const std::vector<std::uint8_t>& list);
    void upload();

    gl::Facing facing(const Draw& draw, bool doubleSided) const;

private:
    struct Placed {
        DrawRecord record;
        bool mirrored = false;
    };
    const Placed& placed(std::uint32_t instance);

    gl::Buffer records_, lightRows_;
    gl::BufferTexture lightTexture_{lightRows_};

    const Scene* scene_ = nullptr;
    const Pose* pose_ = nullptr;
    const View* view_ = nullptr;
    glm::dmat3 axesFromWorld_{1.0};
    const std::vector<PlacedLight>* lights_ = nullptr;
    std::map<std::uint32_t, Placed> instances_;
    std::map<std::vector<std::uint8_t>, std::uint32_t> lists_;
    std::vector<DrawRecord> recordData_;
    std::vector<glm::vec4> lightData_;
};

}  // namespace clerestory
