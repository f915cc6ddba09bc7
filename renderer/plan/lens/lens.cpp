#include "plan/lens/lens.h"

#include "plan/lens/distortion.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <type_traits>

namespace clerestory {
namespace {

constexpr double kLensPi = std::numbers::pi;

glm::dvec2 normalized(const Intrinsics& i, const glm::dvec2& pixel) {
    return {(pixel.x - i.cx) / i.fx, (pixel.y - i.cy) / i.fy};
}
glm::dvec2 pixelAt(const Intrinsics& i, const glm::dvec2& normal) {
    return {i.cx + i.fx * normal.x, i.cy + i.fy * normal.y};
}

Intrinsics centredHalf(Intrinsics i) {
    if (i.pixelCenter == PixelCenter::integer) {
        i.cx += 0.5;
        i.cy += 0.5;
        i.pixelCenter = PixelCenter::half;
    }
    return i;
}

// ---- limits --------------------------------------------------------------------------------

struct Term {
    const char* pointer;
    double slope;  // its part of the slope of the mapping, at the limit
};

// The coefficient that ends the range: that of the most negative term.
const char* worstOf(std::initializer_list<Term> terms) {
    return std::min_element(terms.begin(), terms.end(),
                            [](const Term& a, const Term& b) { return a.slope < b.slope; })
        ->pointer;
}

std::string worded(const char* pattern, double value) {
    char text[160];
    std::snprintf(text, sizeof text, pattern, value);
    return text;
}

// limit, needed: radii in pixels from the principal point.
[[noreturn]] void refuse(const char* pointer, double limit, double needed,
                         const std::string& otherwise) {
    throw InvalidRequest(
        {{pointer,
          "the distortion has no inverse over the frame: it has one up to a radius of " +
              worded("%.6g pixels from the principal point", limit) +
              worded(", and the frame reaches %.6g", needed),
          worded("a frame within a radius of %.6g pixels, or ", limit) + otherwise}});
}

double meanFocalLength(const Intrinsics& i) {
    return std::sqrt(i.fx * i.fy);
}

// Every point of the frame has a direction if its border has: the disc on which the distortion is
// injective is mapped to what the image of its border encloses.
void requireInverse(const PerspectiveLens& l, const Lens& lens) {
    constexpr int kPoints = 32;  // per side
    double needed = 0.0;
    bool all = true;
    for (int i = 0; i <= kPoints; ++i) {
        const double x = lens.width * double(i) / kPoints, y = lens.height * double(i) / kPoints;
        for (const glm::dvec2& pixel : {glm::dvec2(x, 0.0), glm::dvec2(x, lens.height),
                                        glm::dvec2(0.0, y), glm::dvec2(lens.width, y)}) {
            const glm::dvec2 at = normalized(lens.intrinsics, pixel);
            needed = std::max(needed, glm::length(at));
            all = all && undistorted(l, at, lens.maxRadius).has_value();
        }
    }
    if (all) return;
    double reached = INFINITY;
    for (int i = 0; i < 64; ++i) {
        const double angle = 2.0 * kLensPi * i / 64;
        const glm::dvec2 at = lens.maxRadius * glm::dvec2(std::cos(angle), std::sin(angle));
        reached = std::min(reached, glm::length(distorted(l, at)));
    }
    const double r = lens.maxRadius, f = meanFocalLength(lens.intrinsics);
    refuse(worstOf({{"/camera/lens/k1", 3.0 * l.k1 * r * r},
                    {"/camera/lens/k2", 5.0 * l.k2 * std::pow(r, 4)},
                    {"/camera/lens/k3", 7.0 * l.k3 * std::pow(r, 6)},
                    {"/camera/lens/p1", -6.0 * std::abs(l.p1) * r},
                    {"/camera/lens/p2", -6.0 * std::abs(l.p2) * r}}),
           f * reached, f * needed, "smaller coefficients");
}

double cornerRadius(const Lens& lens) {
    double radius = 0.0;
    for (const double x : {0.0, double(lens.width)}) {
        for (const double y : {0.0, double(lens.height)}) {
            radius = std::max(radius, glm::length(normalized(lens.intrinsics, {x, y})));
        }
    }
    return radius;
}

// Sets the image circle, and the intrinsics that it has without those of the request.
void placeCircle(Lens& lens, FisheyeLens& l, bool hasIntrinsics) {
    const double most = injectiveAngle(l), t2 = most * most;
    const char* worst = worstOf({{"/camera/lens/k1", 3.0 * l.k1 * t2},
                                 {"/camera/lens/k2", 5.0 * l.k2 * t2 * t2},
                                 {"/camera/lens/k3", 7.0 * l.k3 * t2 * t2 * t2},
                                 {"/camera/lens/k4", 9.0 * l.k4 * t2 * t2 * t2 * t2}});
    const std::string smaller = worded("a fov of at most %.9g radians", 2.0 * most);
    const double half = l.fov ? 0.5 * *l.fov : hasIntrinsics ? most : 0.5 * kLensPi;
    if (half > most) {
        throw InvalidRequest(
            {{l.fov ? "/camera/lens/fov" : worst,
              worded("the distortion has no inverse beyond %.9g radians from the axis", most),
              smaller}});
    }
    const double reach = distortedAngle(l, half);
    if (!hasIntrinsics) {
        const double focal = 0.5 * std::min(lens.width, lens.height) / reach;
        lens.intrinsics = {focal, focal, 0.5 * lens.width, 0.5 * lens.height, PixelCenter::half};
    } else if (!l.fov && most < kLensPi && cornerRadius(lens) > reach) {
        const double focal = meanFocalLength(lens.intrinsics);
        refuse(worst, focal * reach, focal * cornerRadius(lens), smaller);
    }
    l.fov = 2.0 * half;
}

// ---- rays and pixels of each model ---------------------------------------------------------

std::optional<glm::dvec3> ray(const Lens& lens, const PerspectiveLens& l, const glm::dvec2& pixel) {
    const auto t = undistorted(l, normalized(lens.intrinsics, pixel), lens.maxRadius);
    if (!t) return std::nullopt;
    return glm::normalize(glm::dvec3(t->x, -t->y, -1.0));
}
std::optional<glm::dvec2> pixel(const Lens& lens, const PerspectiveLens& l, const glm::dvec3& d) {
    if (!(d.z < 0.0)) return std::nullopt;
    const glm::dvec2 t(d.x / -d.z, -d.y / -d.z);
    if (glm::length(t) > lens.maxRadius) return std::nullopt;
    return pixelAt(lens.intrinsics, distorted(l, t));
}

std::optional<glm::dvec3> ray(const Lens& lens, const FisheyeLens& l, const glm::dvec2& pixel) {
    const glm::dvec2 at = normalized(lens.intrinsics, pixel);
    const double radius = glm::length(at), most = 0.5 * *l.fov;
    if (radius > distortedAngle(l, most)) return std::nullopt;
    if (radius == 0.0) return glm::dvec3(0.0, 0.0, -1.0);
    const double theta = undistortedAngle(l, radius, most);
    const glm::dvec2 sideways = std::sin(theta) / radius * at;
    return glm::dvec3(sideways.x, -sideways.y, -std::cos(theta));
}
std::optional<glm::dvec2> pixel(const Lens& lens, const FisheyeLens& l, const glm::dvec3& d) {
    const double sideways = std::hypot(d.x, d.y);
    const double theta = std::atan2(sideways, -d.z);
    if (theta > 0.5 * *l.fov) return std::nullopt;
    const glm::dvec2 towards =
        sideways > 0.0 ? glm::dvec2(d.x, -d.y) / sideways : glm::dvec2(1.0, 0.0);
    return pixelAt(lens.intrinsics, distortedAngle(l, theta) * towards);
}

std::optional<glm::dvec3> ray(const Lens& lens, const EquirectangularLens& l,
                              const glm::dvec2& pixel) {
    const double longitude = (pixel.x / lens.width - 0.5) * l.longitude;
    const double latitude = (0.5 - pixel.y / lens.height) * l.latitude;
    return glm::dvec3(std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                      -std::cos(longitude) * std::cos(latitude));
}
std::optional<glm::dvec2> pixel(const Lens& lens, const EquirectangularLens& l,
                                const glm::dvec3& d) {
    const double longitude = std::atan2(d.x, -d.z);
    const double latitude = std::atan2(d.y, std::hypot(d.x, d.z));
    return glm::dvec2((longitude / l.longitude + 0.5) * lens.width,
                      (0.5 - latitude / l.latitude) * lens.height);
}

struct Sheet {
    int columns, rows;
    std::array<int, 12> faces;  // row by row; -1: none
};
const Sheet& sheetOf(CubeLayout layout) {
    static const Sheet grid{
        3, 2, {cubeRight, cubeLeft, cubeUp, cubeDown, cubeBack, cubeFront, -1, -1, -1, -1, -1, -1}};
    static const Sheet row{
        6, 1, {cubeRight, cubeLeft, cubeUp, cubeDown, cubeBack, cubeFront, -1, -1, -1, -1, -1, -1}};
    static const Sheet cross{4,
                             3,
                             {-1, cubeUp, -1, -1,                        //
                              cubeLeft, cubeFront, cubeRight, cubeBack,  //
                              -1, cubeDown, -1, -1}};
    switch (layout) {
        case CubeLayout::grid:
            return grid;
        case CubeLayout::row:
            return row;
        case CubeLayout::cross:
            return cross;
    }
    return grid;
}

std::optional<glm::dvec3> ray(const Lens& lens, const CubeLens& l, const glm::dvec2& pixel) {
    const Sheet& sheet = sheetOf(l.layout);
    const glm::dvec2 cell(pixel.x * sheet.columns / lens.width, pixel.y * sheet.rows / lens.height);
    const double column = std::clamp(std::floor(cell.x), 0.0, sheet.columns - 1.0);
    const double row = std::clamp(std::floor(cell.y), 0.0, sheet.rows - 1.0);
    const int face = sheet.faces[static_cast<std::size_t>(row * sheet.columns + column)];
    if (face < 0) return std::nullopt;
    const glm::dvec2 t(2.0 * (cell.x - column) - 1.0, 1.0 - 2.0 * (cell.y - row));
    return cubeFaceAxes()[static_cast<std::size_t>(face)] *
           glm::normalize(glm::dvec3(t.x, t.y, -1.0));
}
std::optional<glm::dvec2> pixel(const Lens& lens, const CubeLens& l, const glm::dvec3& d) {
    int face = cubeRight;
    double ahead = -1.0;
    for (int i = 0; i < 6; ++i) {
        const double along = -glm::dot(cubeFaceAxes()[static_cast<std::size_t>(i)][2], d);
        if (along > ahead) ahead = along, face = i;
    }
    const glm::dvec3 local = glm::transpose(cubeFaceAxes()[static_cast<std::size_t>(face)]) * d;
    const glm::dvec2 t(local.x / ahead, local.y / ahead);
    const Sheet& sheet = sheetOf(l.layout);
    const auto at = std::find(sheet.faces.begin(), sheet.faces.end(), face) - sheet.faces.begin();
    const double column = static_cast<double>(at % sheet.columns);
    const double row = static_cast<double>(at / sheet.columns);
    return glm::dvec2((column + 0.5 * (t.x + 1.0)) * lens.width / sheet.columns,
                      (row + 0.5 * (1.0 - t.y)) * lens.height / sheet.rows);
}

// One projection matrix draws it: no Lens has it.
std::optional<glm::dvec3> ray(const Lens&, const OrthographicLens&, const glm::dvec2&) {
    return std::nullopt;
}
std::optional<glm::dvec2> pixel(const Lens&, const OrthographicLens&, const glm::dvec3&) {
    return std::nullopt;
}

}  // namespace

const std::array<glm::dmat3, 6>& cubeFaceAxes() {
    static const glm::dvec3 x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
    static const std::array<glm::dmat3, 6> axes = {glm::dmat3(z, y, -x),  glm::dmat3(-z, y, x),
                                                   glm::dmat3(x, z, -y),  glm::dmat3(x, -z, y),
                                                   glm::dmat3(-x, y, -z), glm::dmat3(x, y, z)};
    return axes;
}

bool needsLens(const LensRequest& lens) {
    if (const auto* perspective = std::get_if<PerspectiveLens>(&lens)) {
        return perspective->distorts();
    }
    return !std::holds_alternative<OrthographicLens>(lens);
}

Lens lensFor(const LensRequest& request, const std::optional<Intrinsics>& intrinsics,
             std::uint32_t width, std::uint32_t height) {
    Lens lens{.model = request, .width = width, .height = height};
    if (intrinsics) lens.intrinsics = centredHalf(*intrinsics);
    if (auto* fisheye = std::get_if<FisheyeLens>(&lens.model)) {
        placeCircle(lens, *fisheye, intrinsics.has_value());
    } else if (const auto* perspective = std::get_if<PerspectiveLens>(&lens.model)) {
        lens.maxRadius = injectiveRadius(*perspective);
        requireInverse(*perspective, lens);
    }
    return lens;
}

std::optional<glm::dvec3> rayOf(const Lens& lens, const glm::dvec2& at) {
    return std::visit([&](const auto& model) { return ray(lens, model, at); }, lens.model);
}

std::optional<glm::dvec2> pixelOf(const Lens& lens, const glm::dvec3& direction) {
    return std::visit([&](const auto& model) { return pixel(lens, model, direction); }, lens.model);
}

double depthPerDistance(const Lens& lens, const glm::dvec3& direction) {
    return std::holds_alternative<PerspectiveLens>(lens.model) ? -direction.z : 1.0;
}

}  // namespace clerestory
