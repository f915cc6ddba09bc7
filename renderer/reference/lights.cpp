#include "reference/lights.h"

namespace clerestory::reference {
namespace {

// As in shaders/include/optics.glsl: the minimum distance is 1 cm, and a spot's edge has a minimum
// width in the cosine.
constexpr double kMinDistanceSquared = 1e-4;
constexpr double kMinConeWidth = 1e-3;

double areaOf(const SceneGeometry::Triangle& t) {
    return 0.5 * glm::length(glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a),
                                        glm::dvec3(t.c) - glm::dvec3(t.a)));
}

constexpr std::uint32_t kIrradianceCells = 24;  // along an edge of a face
constexpr std::uint32_t kIrradianceSource = 64;

// A point on a cube face: s to the right and t down in the face's image, -1..1.
struct CubePoint {
    std::uint32_t face = 0;
    double s = 0.0, t = 0.0;
};

// OpenGL 4.3, table 8.18.
CubePoint cubeCoordinates(const glm::dvec3& d) {
    const glm::dvec3 a = glm::abs(d);
    if (a.x >= a.y && a.x >= a.z) {
        const double m = std::max(a.x, 1e-300);
        return d.x > 0.0 ? CubePoint{0, -d.z / m, -d.y / m} : CubePoint{1, d.z / m, -d.y / m};
    }
    if (a.y >= a.z) {
        return d.y > 0.0 ? CubePoint{2, d.x / a.y, d.z / a.y} : CubePoint{3, d.x / a.y, -d.z / a.y};
    }
    return d.z > 0.0 ? CubePoint{4, d.x / a.z, -d.y / a.z} : CubePoint{5, -d.x / a.z, -d.y / a.z};
}

glm::dvec3 cubeDirection(const CubePoint& p) {
    switch (p.face) {
        case 0:
            return {1.0, -p.t, -p.s};
        case 1:
            return {-1.0, -p.t, p.s};
        case 2:
            return {p.s, 1.0, p.t};
        case 3:
            return {p.s, -1.0, -p.t};
        case 4:
            return {p.s, -p.t, 1.0};
        default:
            return {-p.s, -p.t, -1.0};
    }
}

std::uint32_t cellOf(double s, std::uint32_t cells) {
    return std::min(static_cast<std::uint32_t>(std::max(0.5 * (s + 1.0) * cells, 0.0)), cells - 1);
}

// The texel at whole coordinates; those beyond the face's edge are taken from the adjacent face.
glm::dvec3 texelAt(const EnvironmentMap& map, std::uint32_t face, double x, double y) {
    const double n = map.faceSize;
    if (x < 0.0 || y < 0.0 || x >= n || y >= n) {
        const CubePoint other = cubeCoordinates(
            cubeDirection({face, 2.0 * (x + 0.5) / n - 1.0, 2.0 * (y + 0.5) / n - 1.0}));
        face = other.face;
        x = cellOf(other.s, map.faceSize);
        y = cellOf(other.t, map.faceSize);
    }
    const auto at =
        (std::size_t{face} * map.faceSize + static_cast<std::size_t>(y)) * map.faceSize +
        static_cast<std::size_t>(x);
    return glm::dvec3(map.texels[at]);
}

// Solid angle per unit of s and t.
double solidAngleAt(double s, double t) {
    const double squared = 1.0 + s * s + t * t;
    return 1.0 / (squared * std::sqrt(squared));
}

struct DirectionalSample {
    glm::dvec3 direction;
    glm::dvec3 flux;  // radiance times solid angle
};

// The map as at most 6 x kIrradianceSource^2 directional lights.
std::vector<DirectionalSample> directionalSamples(const EnvironmentMap& map) {
    const std::uint32_t step = std::max(1u, map.faceSize / kIrradianceSource);
    const double n = map.faceSize;
    std::vector<DirectionalSample> lights;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; y += step) {
            for (std::uint32_t x = 0; x < map.faceSize; x += step) {
                DirectionalSample sum{glm::dvec3(0.0), glm::dvec3(0.0)};
                double sphere = 0.0;
                for (std::uint32_t j = y; j < std::min(y + step, map.faceSize); ++j) {
                    for (std::uint32_t i = x; i < std::min(x + step, map.faceSize); ++i) {
                        const double s = 2.0 * (i + 0.5) / n - 1.0, t = 2.0 * (j + 0.5) / n - 1.0;
                        const double angle = 4.0 / (n * n) * solidAngleAt(s, t);
                        sum.direction += glm::normalize(cubeDirection({face, s, t}));
                        sum.flux += texelAt(map, face, i, j) * angle;
                        sphere += angle;
                    }
                }
                sum.direction = glm::normalize(sum.direction);
                if (greatest(sum.flux) > 0.0) lights.push_back(sum);
            }
        }
    }
    return lights;
}

}  // namespace

std::vector<PunctualLight> collectPunctualLights(const std::vector<Light>& sources,
                                                 const Pose& pose, const glm::dvec3& origin,
                                                 const EnvironmentMap& environment,
                                                 const glm::dmat3& worldFromMap,
                                                 double environmentIntensity) {
    std::vector<PunctualLight> lights;
    for (const Light& light : sources) {
        if (!(greatest(light.intensity) > 0.0)) continue;
        const glm::dmat4 m = placeOf(light, pose);
        lights.push_back({.kind = light.kind,
                          .position = glm::dvec3(m[3]) - origin,
                          .toLight = unitOr(glm::dvec3(m[2]), glm::dvec3(0, 0, 1)),
                          .intensity = light.intensity,
                          .range = light.range,
                          .cosInner = std::cos(double(light.innerConeAngle)),
                          .cosOuter = std::cos(double(light.outerConeAngle)),
                          .radius = light.radius});
    }
    if (environment.sun) {
        const glm::dvec3 irradiance =
            glm::dvec3(environment.sun->irradiance) * environmentIntensity;
        if (greatest(irradiance) > 0.0) {
            lights.push_back({.kind = LightKind::directional,
                              .toLight = worldFromMap * glm::dvec3(environment.sun->toSun),
                              .intensity = irradiance});
        }
    }
    return lights;
}

LightSample evalLight(const PunctualLight& light, const glm::dvec3& position) {
    if (light.kind == LightKind::directional) {
        return {light.toLight, std::numeric_limits<double>::infinity(), light.intensity};
    }
    const glm::dvec3 offset = light.position - position;
    LightSample sample;
    sample.distance = glm::length(offset);
    sample.toLight = unitOr(offset, light.toLight);
    double attenuation = 1.0 / std::max(sample.distance * sample.distance, kMinDistanceSquared);
    if (light.range > 0.0) {
        const double relative = std::min(sample.distance / light.range, 1.0);
        attenuation *= 1.0 - relative * relative * relative * relative;
    }
    if (light.kind == LightKind::spot) {
        const double width = std::max(light.cosInner - light.cosOuter, kMinConeWidth);
        const double within = std::clamp(
            (glm::dot(sample.toLight, light.toLight) - light.cosOuter) / width, 0.0, 1.0);
        attenuation *= within * within;
    }
    sample.irradiance = light.intensity * attenuation;
    return sample;
}

LightSample towardsDisc(const PunctualLight& light, LightSample centre, const glm::dvec2& u) {
    const bool placed = light.kind != LightKind::directional;
    const glm::dvec3& along = centre.toLight;
    const glm::dvec3 aside = std::abs(along.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(along, aside)), y = glm::cross(along, x);
    const double radius = light.radius * std::sqrt(u.x), turn = 2.0 * kPi * u.y;
    const glm::dvec3 way = along * (placed ? centre.distance : 1.0) +
                           x * (radius * std::cos(turn)) + y * (radius * std::sin(turn));
    centre.toLight = unitOr(way, along);
    if (placed) centre.distance = glm::length(way);
    return centre;
}

Emitters::Emitters(const SceneGeometry& geometry) : geometry_(geometry) {
    const auto& all = geometry.triangles();
    double sum = 0.0;
    for (std::uint32_t i = 0; i < all.size(); ++i) {
        const Surface& surface = geometry.surfaceOf(all[i]);
        if (!surface.emitter || !geometry.emissionEnabled()) continue;
        const double area = areaOf(all[i]);
        const double flux =
            area * luminance(glm::dvec3(emittedRadiance(geometry.materialOf(surface))));
        if (!(flux > 0.0)) continue;
        triangles_.push_back({i, sum, flux / area});
        sum += flux;
    }
    for (Entry& t : triangles_) {
        t.cdf /= sum;
        t.pdf /= sum;
    }
}

Emitters::Sample Emitters::sample(double uTriangle, const glm::dvec2& uPosition) const {
    const auto next = std::upper_bound(triangles_.begin(), triangles_.end(), uTriangle,
                                       [](double w, const Entry& t) { return w < t.cdf; });
    const Entry& chosen = *std::prev(next);  // the first cdf is 0
    // Uniform over the triangle (Turk 1990).
    const double root = std::sqrt(uPosition.x);
    const SceneGeometry::Triangle& t = geometry_.triangles()[chosen.triangle];
    Sample c{chosen.triangle, root * (1.0 - uPosition.y), root * uPosition.y, glm::dvec3(0.0)};
    c.position =
        glm::dvec3(t.a) * (1.0 - root) + glm::dvec3(t.b) * c.weightB + glm::dvec3(t.c) * c.weightC;
    return c;
}

double Emitters::pdf(std::uint32_t triangle, const glm::dvec3& direction, double distance) const {
    const auto found =
        std::lower_bound(triangles_.begin(), triangles_.end(), triangle,
                         [](const Entry& t, std::uint32_t n) { return t.triangle < n; });
    if (found == triangles_.end() || found->triangle != triangle) return 0.0;
    const SceneGeometry::Triangle& t = geometry_.triangles()[triangle];
    const glm::dvec3 normal =
        unitOr(glm::cross(glm::dvec3(t.b) - glm::dvec3(t.a), glm::dvec3(t.c) - glm::dvec3(t.a)),
               -direction);
    const double cosine = std::abs(glm::dot(normal, direction));
    return cosine > 1e-9 ? found->pdf * distance * distance / cosine : 0.0;
}

EnvironmentLight::EnvironmentLight(const EnvironmentMap& map, const glm::dmat3& worldFromMap,
                                   double intensity)
    : map_(map),
      worldFromMap_(worldFromMap),
      mapFromWorld_(glm::transpose(worldFromMap)),
      intensity_(intensity) {}

glm::dvec3 EnvironmentLight::radiance(const glm::dvec3& direction) const {
    const CubePoint p = cubeCoordinates(mapFromWorld_ * direction);
    const double n = map_.faceSize;
    const glm::dvec2 position = 0.5 * (glm::dvec2(p.s, p.t) + 1.0) * n - 0.5;
    const glm::dvec2 corner = glm::floor(position), fraction = position - corner;
    const auto at = [&](double dx, double dy) {
        return texelAt(map_, p.face, corner.x + dx, corner.y + dy);
    };
    return intensity_ * glm::mix(glm::mix(at(0, 0), at(1, 0), fraction.x),
                                 glm::mix(at(0, 1), at(1, 1), fraction.x), fraction.y);
}

void EnvironmentLight::prepareIrradiance() {
    const std::vector<DirectionalSample> lights = directionalSamples(map_);
    const std::uint32_t points = kIrradianceCells + 1;
    // Normalises the discrete solid angles to 4 pi, so that a uniform map gives exactly 1.
    double sphere = 0.0;
    for (std::uint32_t i = 0; i < 6 * map_.faceSize * map_.faceSize; ++i) {
        const std::uint32_t x = i % map_.faceSize, y = i / map_.faceSize % map_.faceSize;
        const double n = map_.faceSize;
        sphere +=
            4.0 / (n * n) * solidAngleAt(2.0 * (x + 0.5) / n - 1.0, 2.0 * (y + 0.5) / n - 1.0);
    }
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < points; ++y) {
            for (std::uint32_t x = 0; x < points; ++x) {
                const glm::dvec3 n = glm::normalize(cubeDirection(
                    {face, 2.0 * x / kIrradianceCells - 1.0, 2.0 * y / kIrradianceCells - 1.0}));
                glm::dvec3 sum(0.0);
                for (const DirectionalSample& light : lights) {
                    sum += light.flux * std::max(glm::dot(n, light.direction), 0.0);
                }
                irradiance_.push_back(sum * (4.0 * kPi / sphere) / kPi);
            }
        }
    }
}

glm::dvec3 EnvironmentLight::irradianceOverPi(const glm::dvec3& normal) const {
    const CubePoint p = cubeCoordinates(mapFromWorld_ * normal);
    const glm::dvec2 position = 0.5 * (glm::dvec2(p.s, p.t) + 1.0) * double(kIrradianceCells);
    const std::uint32_t x = cellOf(p.s, kIrradianceCells), y = cellOf(p.t, kIrradianceCells);
    const glm::dvec2 fraction = position - glm::dvec2(x, y);
    const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
        const std::uint32_t points = kIrradianceCells + 1;
        return irradiance_[(std::size_t{p.face} * points + y + dy) * points + x + dx];
    };
    return intensity_ * glm::mix(glm::mix(at(0, 0), at(1, 0), fraction.x),
                                 glm::mix(at(0, 1), at(1, 1), fraction.x), fraction.y);
}

// Cells are sampled in proportion to mean luminance times solid angle. A uniform share of 1/20
// covers dark cells that interpolation with bright neighbours makes brighter.
void EnvironmentLight::prepareSampling() {
    constexpr std::uint32_t kMaxCells = 128;
    cells_ = std::min(map_.faceSize, kMaxCells);
    const std::uint32_t step = map_.faceSize / cells_;
    std::vector<double> weights;
    double total = 0.0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < cells_; ++y) {
            for (std::uint32_t x = 0; x < cells_; ++x) {
                double sum = 0.0;
                for (std::uint32_t k = 0; k < step * step; ++k) {
                    sum += luminance(texelAt(map_, face, x * step + k % step, y * step + k / step));
                }
                const double s = 2.0 * (x + 0.5) / cells_ - 1.0, t = 2.0 * (y + 0.5) / cells_ - 1.0;
                weights.push_back(sum / (step * step) * solidAngleAt(s, t));
                total += weights.back();
            }
        }
    }
    if (!(total * intensity_ > 0.0)) return;
    const double uniform = 0.05 / double(weights.size());
    double sum = 0.0;
    for (const double weight : weights) {
        cdf_.push_back(sum);
        sum += 0.95 * weight / total + uniform;
    }
    cdf_.push_back(1.0);
}

EnvironmentLight::Sample EnvironmentLight::sample(const glm::dvec2& u) const {
    if (cdf_.empty()) return {};
    const auto next = std::upper_bound(cdf_.begin(), cdf_.end() - 1, u.x);
    const auto cell = static_cast<std::size_t>(next - cdf_.begin() - 1);
    const double probability = cdf_[cell + 1] - cdf_[cell];
    const double within = std::clamp((u.x - cdf_[cell]) / probability, 0.0, 1.0);
    CubePoint p{.face = static_cast<std::uint32_t>(cell / (std::size_t{cells_} * cells_))};
    p.s = 2.0 * (double(cell % cells_) + within) / cells_ - 1.0;
    p.t = 2.0 * (double(cell / cells_ % cells_) + u.y) / cells_ - 1.0;
    return {worldFromMap_ * glm::normalize(cubeDirection(p)),
            probability * cells_ * cells_ / (4.0 * solidAngleAt(p.s, p.t))};
}

double EnvironmentLight::pdf(const glm::dvec3& direction) const {
    if (cdf_.empty()) return 0.0;
    const CubePoint p = cubeCoordinates(mapFromWorld_ * direction);
    const std::size_t cell =
        (std::size_t{p.face} * cells_ + cellOf(p.t, cells_)) * cells_ + cellOf(p.s, cells_);
    return (cdf_[cell + 1] - cdf_[cell]) * cells_ * cells_ / (4.0 * solidAngleAt(p.s, p.t));
}

}  // namespace clerestory::reference
