#include "passes/pixel_triangles.h"

#include "plan/visibility/visibility.h"

#include <limits>

namespace clerestory {
namespace {

constexpr double kNoArea = 1e-9;  // pixels, of a triangle that is seen edge-on
constexpr float kFar = 1e30f;

// A lattice: each row and each column of 64 has one place. Along the axes a square grid of as many
// places finds a share to an eighth only.
glm::dvec2 placeInPixel(std::uint32_t place) {
    constexpr std::uint32_t kStep = 19;
    return (glm::dvec2(place, place * kStep % 64) + 0.5) / 64.0;
}

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

}  // namespace

double PixelTriangle::area() const {
    return 0.5 * cross(corners[1].position - corners[0].position,
                       corners[2].position - corners[0].position);
}

double PixelTriangle::innerRadius() const {
    double length = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
        length += glm::distance(corners[i].position, corners[(i + 1) % 3].position);
    }
    return 2.0 * area() / length;
}

std::pair<float, float> PixelTriangle::depths() const {
    return std::minmax({corners[0].depth, corners[1].depth, corners[2].depth});
}

std::size_t PixelTriangle::longest() const {
    std::size_t found = 0;
    double most = -1.0;
    for (std::size_t i = 0; i < 3; ++i) {
        const double length = glm::distance(corners[i].position, corners[(i + 1) % 3].position);
        if (length > most) {
            most = length;
            found = i;
        }
    }
    return found;
}

float PixelTriangle::depthAt(const glm::dvec2& position) const {
    const std::size_t i = longest();
    const Corner &a = corners[i], &b = corners[(i + 1) % 3];
    const glm::dvec2 way = b.position - a.position;
    const double square = glm::dot(way, way);
    if (!(square > 0.0)) return a.depth;
    const double share = std::clamp(glm::dot(position - a.position, way) / square, 0.0, 1.0);
    return static_cast<float>(a.depth + share * (b.depth - a.depth));
}

bool PixelTriangle::contains(const glm::dvec2& position) const {
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2& from = corners[i].position;
        if (cross(corners[(i + 1) % 3].position - from, position - from) < 0.0) return false;
    }
    return true;
}

double PixelTriangle::shareOf(const glm::dvec2& pixel) const {
    const auto isInside = [&](const Corner& corner) {
        const glm::dvec2 place = corner.position - pixel;
        return place.x >= 0.0 && place.y >= 0.0 && place.x <= 1.0 && place.y <= 1.0;
    };
    if (std::all_of(corners.begin(), corners.end(), isInside)) return area();
    // A triangle that four lines cut has at most seven corners.
    std::array<glm::dvec2, 8> polygon, cut;
    std::size_t count = 3;
    for (std::size_t i = 0; i < 3; ++i) polygon[i] = corners[i].position - pixel;
    for (const auto& [axis, sign] : {std::pair(0, 1.0), {0, -1.0}, {1, 1.0}, {1, -1.0}}) {
        const auto inside = [axis, sign](const glm::dvec2& p) {
            return sign > 0.0 ? p[axis] : 1.0 - p[axis];
        };
        std::size_t kept = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dvec2 &a = polygon[i], &b = polygon[(i + 1) % count];
            const double inA = inside(a), inB = inside(b);
            if (inA >= 0.0) cut[kept++] = a;
            if ((inA >= 0.0) != (inB >= 0.0)) cut[kept++] = a + (b - a) * (inA / (inA - inB));
        }
        count = kept;
        polygon = cut;
    }
    double doubled = 0.0;
    for (std::size_t i = 0; i < count; ++i) doubled += cross(polygon[i], polygon[(i + 1) % count]);
    return std::clamp(0.5 * doubled, 0.0, 1.0);
}

std::uint64_t PixelTriangle::placesIn(const glm::dvec2& pixel) const {
    std::uint64_t places = ~std::uint64_t{0};
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2& from = corners[i].position;
        const glm::dvec2 way = corners[(i + 1) % 3].position - from;
        const double atCorner = cross(way, pixel - from);
        // A place on an edge that two triangles share is in one of them.
        const bool ownsEdge = way.y > 0.0 || (way.y == 0.0 && way.x > 0.0);
        std::uint64_t inside = 0;
        for (std::uint32_t place = 0; place < 64; ++place) {
            const double value = atCorner + cross(way, placeInPixel(place));
            inside |= std::uint64_t{ownsEdge ? value >= 0.0 : value > 0.0} << place;
        }
        places &= inside;
    }
    return places;
}

std::pair<double, double> PixelTriangle::columnsBetween(double low, double high) const {
    double left = std::numeric_limits<double>::max(), right = std::numeric_limits<double>::lowest();
    const auto add = [&](double x) {
        left = std::min(left, x);
        right = std::max(right, x);
    };
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 &a = corners[i].position, &b = corners[(i + 1) % 3].position;
        if (a.y >= low && a.y <= high) add(a.x);
        for (const double y : {low, high}) {
            if ((a.y < y) != (b.y < y)) add(a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y));
        }
    }
    return {left, right};
}

PixelTriangles::PixelTriangles(const Scene& scene, const Pose& pose, const View& view,
                               std::uint32_t instance, std::uint32_t width, std::uint32_t height)
    : scene_(scene),
      vertices_(verticesOf(scene, pose, scene.meshes[scene.instances[instance].mesh])),
      clipPlane_(view.clipPlane),
      eyeFromMesh_(eyeFromLocal(view, pose.worldFromNode[scene.instances[instance].node])),
      viewFromEye_(glm::dmat3(view.viewFromWorld)),
      clipFromView_(view.clipFromView),
      size_(width, height),
      clockwiseIsFront_((glm::determinant(glm::dmat3(eyeFromMesh_)) < 0.0) != view.mirrored) {}

std::variant<PixelTriangles::Seen, PixelTriangles::Absent> PixelTriangles::at(
    std::uint32_t firstIndex) const {
    Seen seen;
    for (std::uint32_t k = 0; k < 3; ++k) {
        const Vertex& vertex = vertices_[scene_.indices[firstIndex + k]];
        const glm::dvec4 fromEye = eyeFromMesh_ * glm::dvec4(glm::dvec3(vertex.position), 1.0);
        if (clipPlane_ && glm::dot(*clipPlane_, fromEye) < 0.0) return Absent::notSeen;
        const glm::dvec4 inView = viewFromEye_ * fromEye;
        const glm::dvec4 clip = clipFromView_ * inView;
        if (!(clip.w > 0.0) || !(clip.z <= clip.w)) return Absent::behindEye;
        PixelTriangle::Corner& corner = seen.triangle.corners[k];
        corner.position = (0.5 * glm::dvec2(clip) / clip.w + 0.5) * size_;
        corner.depth = static_cast<float>(-inView.z);
        if (!std::isfinite(corner.position.x) || !std::isfinite(corner.position.y) ||
            !std::isfinite(corner.depth)) {
            return Absent::behindEye;
        }
    }
    const double area = seen.triangle.area();
    if (!(std::abs(area) > kNoArea)) return Absent::notSeen;
    seen.facesEye = (area > 0.0) != clockwiseIsFront_;
    if (area < 0.0) std::swap(seen.triangle.corners[1], seen.triangle.corners[2]);
    return seen;
}

float depthOf(const View& view, float stored) {
    // clip z = a z + b and clip w = c z + d of a position z in view space.
    const glm::dmat4& m = view.clipFromView;
    const double z = (stored * m[3][3] - m[3][2]) / (m[2][2] - stored * m[2][3]);
    return z < 0.0 && -z < kFar ? static_cast<float>(-z) : kFar;
}

}  // namespace clerestory
