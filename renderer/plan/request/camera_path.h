// A camera's way between key poses, as single frames. Pure.
#pragma once

#include "plan/request/frame_request.h"

namespace clerestory {

enum class PathInterpolation { linear, smooth };

struct CameraKey {
    double time = 0.0;     // seconds
    CameraRequest camera;  // with a pose of its own, not a camera of the scene
};

struct CameraPath {
    std::vector<CameraKey> keys;  // of ascending times
    double frameRate = 30.0;      // frames a second
    PathInterpolation interpolation = PathInterpolation::smooth;
};

inline constexpr std::size_t kMaxCameraKeys = 1024;

template <class V>
void fields(CameraKey& k, V&& visit) {
    visit("time", k.time, Range{0, 1e6, "seconds"}, "seconds, later than the key before");
    visit("camera", k.camera, Nested{}, "a pose and lens; not a camera of the scene");
}

template <class V>
void fields(CameraPath& p, V&& visit) {
    visit("keys", p.keys, NestedList{kMaxCameraKeys}, "where the camera is, and when");
    visit("frameRate", p.frameRate, Range{0.001, 1000}, "frames a second");
    visit("interpolation", p.interpolation,
          Choice<PathInterpolation>{
              {{"linear", PathInterpolation::linear}, {"smooth", PathInterpolation::smooth}}},
          "between keys: straight, or a smooth curve through them");
}

// What single fields cannot know: a key at least, ascending times, a whole pose in each. Pointers
// begin at the path.
std::vector<FieldError> problems(const CameraPath& path);

struct PathFrame {
    double time = 0.0;
    CameraRequest camera;
};

// How many frames there are from the first key to the last, at frameRate, both ends included.
double frameCount(const CameraPath& path);

// Those frames; path has no problems(). Where both keys about a frame have a target, position,
// target and up move, so that what was looked at is looked at all the way; otherwise position and
// orientation. Smooth is the cubic Hermite curve whose slope at a key is that of the chord between
// its neighbours (Catmull and Rom 1974, for uneven times); turns then go through the quaternion's
// components and are normalised. The field of view moves too; the rest of the lens is the earlier
// key's.
std::vector<PathFrame> framesOf(const CameraPath& path);

}  // namespace clerestory
