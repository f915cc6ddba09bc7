// The camera of a requested frame: its pose and lens. See plan/visibility/view.h for what they
// make.
#pragma once

#include "plan/request/lens_request.h"
#include "scene/fields.h"

#include <glm/glm.hpp>

#include <array>
#include <optional>
#include <string>

namespace clerestory {

enum class Convention { opengl, opencv };
enum class PixelCenter { half, integer };

struct Intrinsics {  // pixels, first row on top
    double fx = 1000, fy = 1000, cx = 640, cy = 360;
    PixelCenter pixelCenter = PixelCenter::half;
    bool operator==(const Intrinsics&) const = default;
};

// A pose from which chosen surfaces fill the frame; see scene/fit.h.
struct FitRequest {
    std::optional<std::string> node, material;  // names; none: everything
    double azimuth = 0.463647609;               // as the default view of a scene without a camera
    double elevation = 0.303385417;
    double margin = 0.1;     // of the frame, on each of two opposite sides
    bool allAround = false;  // one distance and one middle for all azimuths
};

struct CameraRequest {
    std::optional<glm::dvec3> position;
    std::optional<glm::dvec3> target;
    std::optional<glm::dvec3> up;
    std::optional<std::array<double, 4>> orientation;     // x y z w
    std::optional<std::array<double, 16>> cameraToWorld;  // column-major
    Convention convention = Convention::opengl;
    std::optional<std::string> name;
    std::optional<FitRequest> fit;
    std::optional<double> yfov;
    std::optional<double> orthographicHeight;
    std::optional<Intrinsics> intrinsics;
    std::optional<LensRequest> lens;  // none: perspective, or orthographicHeight, or the scene's
    std::optional<double> znear;
    std::optional<double> zfar;
};

template <class V>
void fields(Intrinsics& i, V&& visit) {
    visit("fx", i.fx, Range{1e-3, 1e7, "pixels"}, "focal length along x");
    visit("fy", i.fy, Range{1e-3, 1e7, "pixels"}, "focal length along y");
    visit("cx", i.cx, Range{-1e6, 1e6, "pixels"}, "principal point, from the left edge");
    visit("cy", i.cy, Range{-1e6, 1e6, "pixels"}, "principal point, from the top edge");
    visit("pixelCenter", i.pixelCenter,
          Choice<PixelCenter>{{{"half", PixelCenter::half}, {"integer", PixelCenter::integer}}},
          "coordinate of the centre of the first pixel: half is 0.5, integer is 0");
}

template <class V>
void fields(FitRequest& f, V&& visit) {
    visit("node", f.node, Text{256}, "name of a node; everything at or below it fills the frame");
    visit("material", f.material, Text{256},
          "name of a material; everything that has it without a variant fills the frame");
    visit("azimuth", f.azimuth, Range{-1e3, 1e3, "radians"},
          "direction of the camera about +Y: 0 is +Z, a quarter turn is +X");
    visit("elevation", f.elevation, Range{-1.5707964, 1.5707964, "radians"},
          "angle of the camera above the horizon");
    visit("margin", f.margin, Range{0, 0.45},
          "share of the frame left free on each of two opposite sides");
    visit("allAround", f.allAround, Flag{},
          "true: the camera has one distance and one target for all azimuths, so that an object "
          "that turns about the vertical axis through its centre stays in the frame");
}

template <class V>
void fields(CameraRequest& c, V&& visit) {
    visit("position", c.position, Range{-1e9, 1e9, "metres"},
          "position of the camera in the world");
    visit("target", c.target, Range{-1e9, 1e9, "metres"}, "point that the camera looks at");
    visit("up", c.up, Range{-1e9, 1e9}, "direction that points up in the picture; +Y when absent");
    visit("orientation", c.orientation, Range{-1e3, 1e3},
          "rotation from camera to world, unit quaternion x y z w; the camera looks along its own "
          "-Z axis");
    visit("cameraToWorld", c.cameraToWorld, Range{-1e9, 1e9},
          "rigid 4x4 matrix from camera to world, column-major");
    visit("convention", c.convention,
          Choice<Convention>{{{"opengl", Convention::opengl}, {"opencv", Convention::opencv}}},
          "camera axes of cameraToWorld: opengl has +Y up and looks along -Z, opencv has +Y down "
          "and looks along +Z");
    visit("name", c.name, Text{256}, "name of a camera of the scene");
    visit("fit", c.fit, Nested{},
          "instead of a pose: chosen surfaces fill the frame, seen from a direction");
    visit("yfov", c.yfov, Range{0.0174532925, 3.1241394, "radians"},
          "vertical field of view (1 to 179 degrees); 0.7 with fit when absent");
    visit("orthographicHeight", c.orthographicHeight, Range{1e-9, 1e9, "metres"},
          "height of the view of an orthographic lens, instead of yfov");
    visit("intrinsics", c.intrinsics, Nested{},
          "focal lengths and principal point, instead of yfov");
    visit("lens", c.lens, NestedUnion{"Lens"},
          "projection and distortion; perspective without distortion when absent");
    visit("znear", c.znear, Range{1e-9, 1e9, "metres"},
          "distance of the near plane; derived from the scene when absent");
    visit("zfar", c.zfar, Range{1e-9, 1e12, "metres"},
          "distance of the far plane; infinite when absent");
}

}  // namespace clerestory
