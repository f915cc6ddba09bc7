// The lens of a requested camera: which point of the picture shows which direction. The formulae
// and their inverses are in lens/lens.h.
//
// A new lens needs a struct with kType and fields() here, an alternative of LensRequest, and its
// two functions in lens/lens.cpp.
#pragma once

#include "scene/fields.h"

#include <numbers>
#include <optional>
#include <string_view>
#include <variant>

namespace clerestory {

// Pixels by the tangent of the angle, with the distortion of Brown and Conrady as OpenCV defines
// it.
struct PerspectiveLens {
    static constexpr std::string_view kType = "perspective";
    double k1 = 0.0, k2 = 0.0, k3 = 0.0, p1 = 0.0, p2 = 0.0;
    bool distorts() const { return k1 != 0 || k2 != 0 || k3 != 0 || p1 != 0 || p2 != 0; }
    bool operator==(const PerspectiveLens&) const = default;
};

// Parallel rays.
struct OrthographicLens {
    static constexpr std::string_view kType = "orthographic";
    double height = 1.0;
    bool operator==(const OrthographicLens&) const = default;
};

// Longitude and latitude about the camera's own up axis; the middle of the picture looks ahead.
struct EquirectangularLens {
    static constexpr std::string_view kType = "equirectangular";
    double longitude = 2.0 * std::numbers::pi;
    double latitude = std::numbers::pi;
    bool operator==(const EquirectangularLens&) const = default;
};

enum class CubeLayout { grid, row, cross };

// Six perspective pictures of 90 degrees in one.
struct CubeLens {
    static constexpr std::string_view kType = "cube";
    CubeLayout layout = CubeLayout::grid;
    bool operator==(const CubeLens&) const = default;
};

// Pixels by the angle from the axis, with OpenCV's four coefficients.
struct FisheyeLens {
    static constexpr std::string_view kType = "fisheye";
    std::optional<double> fov;
    double k1 = 0.0, k2 = 0.0, k3 = 0.0, k4 = 0.0;
    bool operator==(const FisheyeLens&) const = default;
};

using LensRequest =
    std::variant<PerspectiveLens, OrthographicLens, EquirectangularLens, CubeLens, FisheyeLens>;

inline constexpr Range kCoefficient{-1e6, 1e6};

template <class V>
void fields(PerspectiveLens& l, V&& visit) {
    visit("k1", l.k1, kCoefficient,
          "radial distortion of Brown and Conrady, as in OpenCV: times r^2");
    visit("k2", l.k2, kCoefficient, "radial distortion: times r^4");
    visit("k3", l.k3, kCoefficient, "radial distortion: times r^6");
    visit("p1", l.p1, kCoefficient,
          "tangential distortion: adds 2 p1 x y to x and p1 (r^2 + 2 y^2) to y");
    visit("p2", l.p2, kCoefficient,
          "tangential distortion: adds p2 (r^2 + 2 x^2) to x and 2 p2 x y to y");
}

template <class V>
void fields(OrthographicLens& l, V&& visit) {
    visit("height", l.height, Required{Range{1e-9, 1e9, "metres"}}, "height of what it shows");
}

template <class V>
void fields(EquirectangularLens& l, V&& visit) {
    visit("longitude", l.longitude, Range{1e-3, 6.283185307179587, "radians"},
          "horizontal angle of the whole picture");
    visit("latitude", l.latitude, Range{1e-3, 3.1415926535897936, "radians"},
          "vertical angle of the whole picture");
}

template <class V>
void fields(CubeLens& l, V&& visit) {
    visit("layout", l.layout,
          Choice<CubeLayout>{
              {{"grid", CubeLayout::grid}, {"row", CubeLayout::row}, {"cross", CubeLayout::cross}}},
          "grid: right, left, up above down, back, front; row: the same six in one row; cross: "
          "left, front, right, back in the middle row, up and down at front");
}

template <class V>
void fields(FisheyeLens& l, V&& visit) {
    visit(
        "fov", l.fov, Range{0.0174532925, 6.283185307179587, "radians"},
        "angle of the image circle, black outside of it; without camera.intrinsics its diameter is "
        "the shorter edge of the frame. Absent: half a turn, or with camera.intrinsics as far as "
        "the lens reaches");
    visit("k1", l.k1, kCoefficient, "coefficient of OpenCV's fisheye model: times theta^2");
    visit("k2", l.k2, kCoefficient, "times theta^4");
    visit("k3", l.k3, kCoefficient, "times theta^6");
    visit("k4", l.k4, kCoefficient, "times theta^8");
}

// `type` of the lens.
std::string_view typeOf(const LensRequest& lens);

}  // namespace clerestory
