// A camera path between key poses, and its frames. Pure functions.
#pragma once

#include "plan/request/frame_request.h"

namespace clerestory {

enum class PathInterpolation { linear, smooth };

struct CameraKey {
    double time = 0.0;     // seconds
    CameraRequest camera;  // a pose, not a camera of the scene
};

struct CameraPath {
    std::vector<CameraKey> keys;  // in ascending order of time
    double frameRate = 30.0;      // frames per second
    PathInterpolation interpolation = PathInterpolation::smooth;
};

inline constexpr std::size_t kMaxCameraKeys = 1024;

template <class V>
void fields(CameraKey& k, V&& visit) {
    visit("time", k.time, Range{0, 1e6, "seconds"},
          "time of the key; later than that of the previous key");
    visit("camera", k.camera, Nested{}, "pose and lens; a camera of the scene is not allowed");
}

template <class V>
void fields(CameraPath& p, V&& visit) {
    visit("keys", p.keys, NestedList{kMaxCameraKeys}, "poses of the camera with their times");
    visit("frameRate", p.frameRate, Range{0.001, 1000}, "frames per second");
    visit("interpolation", p.interpolation,
          Choice<PathInterpolation>{
              {{"linear", PathInterpolation::linear}, {"smooth", PathInterpolation::smooth}}},
          "interpolation between keys: straight lines, or a smooth curve");
}

// Checks that involve several fields: at least one key, ascending times, a complete pose in each.
// Pointers are relative to the path.
std::vector<FieldError> problems(const CameraPath& path);

struct PathFrame {
    double time = 0.0;
    CameraRequest camera;
};

// The number of frames from the first key to the last one at frameRate, both included.
double frameCount(const CameraPath& path);

// These frames; requires that problems(path) is empty. If both keys around a frame have a target,
// position, target and up are interpolated, so that the camera keeps looking at the target;
// otherwise position and orientation. Smooth is the cubic Hermite curve whose slope at a key is
// that of the chord between its neighbours (Catmull and Rom 1974, for uneven times); quaternions
// are interpolated by component and normalised. The field of view is interpolated too; the rest of
// the lens is that of the earlier key.
std::vector<PathFrame> framesOf(const CameraPath& path);

}  // namespace clerestory
