// The part of a request that determines how any view of its frame is drawn. Mirrored views and
// captured cubes receive this and nothing else of the request, so that a captured map cannot depend
// on a setting that its key omits.
//
//     const ViewSettings settings = viewSettings(request, scene, maxAnisotropy);
//     hashOf(captureSettings(settings));  // a part of a captured cube's key
#pragma once

#include "plan/request/frame_request.h"
#include "scene/scene.h"

namespace clerestory {

// World direction from environment map direction: the request's rotation, else the scene's.
glm::dmat3 worldFromMap(const FrameRequest& request, const Scene& scene);

struct ViewSettings {
    Effects effects;
    Accuracy accuracy;  // fields that only the whole frame uses hold their defaults
    bool skyVisible = true;
    float environmentIntensity = 1.0f;
    glm::dmat3 mapFromWorld{1.0};  // turns a world direction into one of the environment map
    float pointSize = 1.0f;        // of lines and points, pixels
};

// maxAnisotropy: of the device, at least 1; the request's value is lowered to it.
ViewSettings viewSettings(const FrameRequest& request, const Scene& scene,
                          std::uint32_t maxAnisotropy);

// The same for views that are captured into a cube; what those do not use holds its default.
ViewSettings captureSettings(ViewSettings settings);

// Of every member; walks the field tables, so that a new field cannot be left out.
std::uint64_t hashOf(const ViewSettings& settings);

}  // namespace clerestory
