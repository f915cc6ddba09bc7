#include "light/bake.h"

#include "light/places.h"
#include "light/sky.h"
#include "rays/path.h"
#include "rays/triangle_tree.h"
#include "scene/bvh.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace clerestory::light {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kGoldenAngle = 2.39996323f;
// An emitter that fills this share of the directions is what a specular lobe sees.
constexpr float kLargeEmitter = 0.25f;
constexpr std::uint32_t kLampRays = 12;  // to a lamp with a radius

float luminance(const glm::vec3& c) {
    return glm::dot(c, glm::vec3(0.2126f, 0.7152f, 0.0722f));
}

// Sums over rays on one side of a surface.
struct Sums {
    float count = 0.0f;           // rays
    glm::vec3 open{0.0f};         // radiance of the environment that arrives
    glm::vec3 hidden{0.0f};       // and that does not
    glm::vec3 wholeSky{0.0f};     // irradiance over pi if nothing hid it
    glm::vec3 emittersMet{0.0f};  // of emitters that rays met, weighted
    glm::vec3 openFlux{0.0f};     // luminance of both times direction over cosine
    glm::vec3 directions{0.0f};
    float visible = 0.0f;     // share of the environment
    glm::vec3 towards{0.0f};  // that times the direction
    float behind = 0.0f;      // rays that began behind a surface
    // Light from other surfaces: later rounds know more of it, so that earlier ones count less.
    float bounceCount = 0.0f;
    glm::vec3 bounces{0.0f};
    glm::vec3 bounceFlux{0.0f};
    // Rays towards emitters: irradiance over pi, weighted.
    float emitterCount = 0.0f;
    glm::vec3 emitters{0.0f};
    glm::vec3 emitterFlux{0.0f};
    float emitterShare = 0.0f;  // of the directions, by cosine, that emitters fill

    void forgetBounces(float factor) {
        bounceCount *= factor;
        bounces *= factor;
        bounceFlux *= factor;
    }
    // Irradiance over pi. The more of the environment is open, the less does what is hidden vary:
    // a surface that sees bright windows of a map from everywhere has no noise.
    glm::vec3 fromSky() const {
        const float perRay = 1.0f / std::max(count, 1.0f);
        const glm::vec3 less = glm::max(wholeSky - hidden * perRay, 0.0f);
        return glm::mix(open * perRay, less, std::clamp(visible * perRay, 0.0f, 1.0f));
    }
    // From the environment and emitters, and from other surfaces.
    glm::vec3 direct() const {
        return fromSky() + emittersMet / std::max(count, 1.0f) +
               emitters / std::max(emitterCount, 1.0f);
    }
    glm::vec3 bounced() const { return bounces / std::max(bounceCount, 1e-6f); }
    // The share of the environment by direction, as LightAtVertex::visible: least squares over
    // directions with the density of cosines. The variance of the direction's part along the normal
    // is 1/18, of those across it 1/4.
    glm::vec4 visibleFrom(const glm::vec3& normal) const {
        const float rays = std::max(count, 1.0f), mean = visible / rays;
        const glm::vec3 direction = directions / rays;
        const glm::vec3 covariance = towards / rays - mean * direction;
        const float upward = glm::dot(covariance, normal);
        const glm::vec3 slope = 4.0f * (covariance - upward * normal) + 18.0f * upward * normal;
        return {slope, mean - glm::dot(slope, direction)};
    }
    // bounceScale: see BounceSeries.
    glm::vec3 flux(const glm::vec3& bounceScale) const {
        return openFlux / std::max(count, 1.0f) +
               bounceScale * bounceFlux / std::max(bounceCount, 1e-6f) +
               emitterFlux / std::max(emitterCount, 1.0f);
    }
};

// Rounds before this one count for less in the bounces that follow them.
float keptOfBounces(std::uint32_t round) {
    return round <= 3 ? 0.25f : 1.0f;
}

// Scales the bounces to the sum of all, of which n rounds know the first n - 1. The light S that
// surfaces have from each other and the light D that they have from elsewhere fulfil S = T (D + S).
// In the mean over all places T is the factor by which a round's bounces fall behind what the round
// before has sent; then S = t D / (1 - t), which is exact once S has the shape of the limit.
class BounceSeries {
public:
    // Means over all places after a round: of light from elsewhere, and of Sums::bounced().
    void endRound(std::uint32_t round, const glm::dvec3& direct, const glm::dvec3& bounced) {
        const double kept = keptOfBounces(round) * weight_;
        for (int c = 0; c < 3; ++c) {
            const double ofRound = bounced[c] * (kept + 1.0) - bounced_[c] * kept;
            const double factor = sent_[c] > 0.0 ? std::clamp(ofRound / sent_[c], 0.0, 0.98) : 0.0;
            const double limit = factor * direct[c] / (1.0 - factor);
            scale_[c] = bounced[c] > 0.0 && limit > bounced[c]
                            ? static_cast<float>(std::min(limit / bounced[c], kMaxScale))
                            : 1.0f;
            sent_[c] = direct[c] + double{scale_[c]} * bounced[c];
        }
        weight_ = kept + 1.0;
        bounced_ = bounced;
    }
    const glm::vec3& scale() const { return scale_; }

private:
    static constexpr double kMaxScale = 8.0;
    glm::vec3 scale_{1.0f};
    glm::dvec3 sent_{0.0}, bounced_{0.0};
    double weight_ = 0.0;  // of the rounds in `bounced_`, in rounds
};

// A triangle that is no hole, no veil and no glass; see PathTracer::middleOf().
struct Face {
    glm::vec3 normal{0.0f};  // world, on the front; any length
    glm::vec3 albedo{0.0f};
    glm::vec3 emitted{0.0f};
    float density = 0.0f;  // of rays towards emitters, per square metre
    bool plain = false;
    bool twoSided = false;
};

// A triangle that emits.
struct Emitter {
    glm::vec3 a, ab, ac;   // world axes, from the origin
    double end = 0.0;      // of its part of the sum of powers, 0..1
    float density = 0.0f;  // per square metre
    bool plain = false;    // rays that meet it at random count, too
};

// Two axes across a unit vector (Duff et al. 2017).
void axesAbout(const glm::vec3& n, glm::vec3& x, glm::vec3& y) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    x = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
    y = {b, sign + n.y * n.y * a, -n.y};
}

std::uint32_t hashed(std::uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

float fraction(float x) {
    return x - std::floor(x);
}

// Point `i` of a sequence with even gaps (Roberts 2018), moved by a hash.
glm::vec2 pointOfSequence(std::uint32_t i, std::uint32_t seed) {
    const std::uint32_t h = hashed(seed);
    const double x = 0.7548776662466927 * i, y = 0.5698402909980532 * i;
    return {
        fraction(static_cast<float>(x - std::floor(x)) +
                 static_cast<float>(h & 0xffffu) / 65536.0f),
        fraction(static_cast<float>(y - std::floor(y)) + static_cast<float>(h >> 16) / 65536.0f)};
}

// All sides can be hit: rays that begin inside a body must notice it.
std::vector<BvhTriangle> fromBothSides(std::vector<BvhTriangle> triangles) {
    for (BvhTriangle& t : triangles) t.side = 0.0f;
    return triangles;
}

// Part of the rays that may begin behind surfaces before a sample counts as buried.
constexpr float kMaxBehind = 0.25f;
// Steps from neighbour to neighbour by which buried samples receive values.
constexpr int kFillSteps = 12;

}  // namespace

struct Bake::State {
    State(BakeInput given, const BakeQuality& quality);

    void collectFaces();
    void collectEmitters();
    const SurfacePoint& pointOf(std::uint32_t place) const {
        return places.points[places.chosen[place]];
    }
    bool buried(std::uint32_t place) const {
        return sums[0][place].behind > kMaxBehind * sums[0][place].count;
    }
    glm::vec3 lampsAt(const SurfacePoint& point, float side) const;
    glm::vec3 shareOf(const PlacedLight& lamp, const glm::vec3& start, const glm::vec3& along,
                      float distance) const;
    void gather(std::uint32_t place, int side);
    void sampleEmitters(std::uint32_t place, int side);
    struct Seen {
        bool met = false, begins = true;
        glm::vec3 light{0.0f}, share{1.0f};
        glm::vec3 emitted{0.0f};  // times the weight of rays that meet emitters at random
    };
    Seen look(const glm::vec3& start, const glm::vec3& along, float cosine) const;
    float randomWeight(float cosine, float facing, float distance, float density) const;
    glm::vec3 sentFrom(std::uint32_t instance, const std::uint32_t vertices[3],
                       const float weights[3], const glm::vec3& normal) const;
    glm::vec3 startOf(const SurfacePoint& point, float side) const;
    // Light at a point of the grid; nothing if it lies within a body.
    std::optional<LightAtVertex> lightAround(const glm::vec3& point) const;
    void updateGrid();
    void fillBuried();
    void updateRadiosity();
    glm::vec3 irradianceOf(const Sums& s) const {  // over pi; without lamps
        return s.direct() + series.scale() * s.bounced();
    }
    glm::vec3 nearbyFrom(const Sums& s) const;
    LightAtVertex lightOf(std::uint32_t place) const;
    LightAtVertex unhidden() const;

    const BakeInput input;
    BakeQuality quality;
    BvhTriangles triangles;
    rays::TriangleTree tree;
    Sky sky;
    std::vector<glm::vec2> noBrdf{glm::vec2(0.0f)};
    std::vector<glm::vec4> noLights{glm::vec4(0.0f)};
    std::optional<rays::PathTracer> tracer;
    float offset = 0.0f;  // of ray starts, metres

    Places places;
    std::vector<Face> faces;  // of `tree`
    std::vector<Emitter> emitters;
    // Of both sides of each place: sums, and irradiance of punctual lights over pi.
    std::vector<Sums> sums[2];
    std::vector<glm::vec3> lamps[2];
    // Of both sides of each point: light that a white surface sends back, after a round.
    std::vector<glm::vec3> sent[2];
    // The point that a point takes its light from if all its places are buried; else itself.
    std::vector<std::uint32_t> source;
    LightGrid grid;
    std::vector<std::uint32_t> moving;  // instances
    glm::vec3 meanSent{0.0f};
    BounceSeries series;
    std::uint32_t round = 0;
    bool nothingHidden = false;  // in the rounds so far
    std::atomic<std::uint64_t> rayCount{0};
};

Bake::State::State(BakeInput given, const BakeQuality& q)
    : input(std::move(given)), quality(q), sky(*input.environment) {
    triangles = stillTriangles(*input.scene, *input.pose, input.materials);
    tree.setStill(fromBothSides(triangles.triangles));
    rays::Surroundings surroundings{.tree = tree,
                                    .vertices = input.scene->vertices,
                                    .indices = input.scene->indices,
                                    .instances = input.instances,
                                    .materials = input.materialRows,
                                    .firstTextureRow = input.firstTextureRow,
                                    .texels = *input.texels,
                                    .lights = noLights,
                                    .environment = sky.map(),
                                    .brdf = noBrdf,
                                    .brdfSize = 1,
                                    .worldFromEye = glm::mat3(glm::transpose(input.mapFromWorld)),
                                    .hitFeatures = input.hitFeatures};
    tracer.emplace(surroundings);
    const auto diagonal = static_cast<double>(lastingBounds(*input.scene, *input.pose).diagonal());
    offset = static_cast<float>(1e-4 * diagonal);
    places = placesOf({.scene = *input.scene,
                       .pose = *input.pose,
                       .materials = input.materials,
                       .mapFromWorld = input.mapFromWorld,
                       .origin = triangles.origin,
                       .distance = input.edge > 0.0 ? 0.7 * input.edge : diagonal / 400.0,
                       .limit = quality.places});
    const std::size_t least =
        std::max<std::size_t>(places.chosen.size(), 1) * (quality.rays + quality.emitterRays);
    const auto more =
        static_cast<std::uint32_t>(std::clamp<std::size_t>(quality.allRays / least, 1, 4));
    quality.rays *= more;
    quality.emitterRays *= more;
    if (!triangles.triangles.empty()) {
        const std::vector<bool> moves = instancesThatMove(*input.scene);
        for (std::uint32_t i = 0; i < moves.size(); ++i) {
            const Mesh& mesh = input.scene->meshes[input.scene->instances[i].mesh];
            const bool surface = mesh.primitive == Primitive::triangles;
            if (surface ? moves[i] : mesh.lit) moving.push_back(i);
        }
    }
    if (!moving.empty()) {
        grid = gridOver(lastingBounds(*input.scene, *input.pose), quality.gridPoints);
    }
    collectFaces();
    if (input.emission) collectEmitters();
    for (int side = 0; side < 2; ++side) {
        sums[side].resize(places.chosen.size());
        lamps[side].resize(places.chosen.size());
        sent[side].resize(places.points.size());
    }
}

void Bake::State::collectFaces() {
    std::vector<bool> mirrored;
    for (const Instance& instance : input.scene->instances) {
        mirrored.push_back(glm::determinant(glm::dmat3(input.pose->worldFromNode[instance.node])) <
                           0.0);
    }
    faces.resize(triangles.triangles.size());
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const BvhTriangle& t = tree.triangle(i);
        Face& face = faces[i];
        face.normal = glm::cross(t.b - t.a, t.c - t.a);
        const Material& material = input.materials.material(
            *input.scene, input.materials.materialOf(*input.scene, static_cast<Index>(t.instance)));
        face.twoSided = material.doubleSided;
        if (mirrored[static_cast<std::size_t>(t.instance)]) face.normal = -face.normal;
        if (const auto middle = tracer->middleOf(i)) {
            face.albedo = middle->albedo;
            face.emitted = middle->emitted;
            face.plain = true;
        }
    }
}

void Bake::State::collectEmitters() {
    double sum = 0.0;
    std::vector<std::uint32_t> places;
    for (std::uint32_t i = 0; i < faces.size(); ++i) {
        const BvhTriangle& t = tree.triangle(i);
        const Material& material = input.materials.material(
            *input.scene, input.materials.materialOf(*input.scene, static_cast<Index>(t.instance)));
        const float radiance = material.unlit ? 0.0f : luminance(emittedRadiance(material));
        Emitter emitter{t.a, t.b - t.a, t.c - t.a};
        const float area = 0.5f * glm::length(glm::cross(emitter.ab, emitter.ac));
        if (!(radiance > 0.0f) || !(area > 0.0f)) continue;
        sum += double{radiance} * area;
        emitter.end = sum;
        emitter.density = radiance;
        emitter.plain = faces[i].plain;
        emitters.push_back(emitter);
        places.push_back(i);
    }
    for (std::size_t i = 0; i < emitters.size(); ++i) {
        Emitter& emitter = emitters[i];
        emitter.end /= sum;
        emitter.density = static_cast<float>(emitter.density / sum);
        if (emitter.plain) faces[places[i]].density = emitter.density;
    }
}

glm::vec3 Bake::State::startOf(const SurfacePoint& point, float side) const {
    const glm::vec3 normal(glm::transpose(input.mapFromWorld) * glm::dvec3(point.normal));
    return point.start + normal * (side * offset);
}

// What arrives of a lamp's light: along: to its centre, axes of the map; distance: to it.
glm::vec3 Bake::State::shareOf(const PlacedLight& lamp, const glm::vec3& start,
                               const glm::vec3& along, float distance) const {
    const bool soft = lamp.radius > 0.0f;
    const float reach = lamp.kind == LightKind::directional ? 1.0f : distance;
    glm::vec3 x, y, sum(0.0f);
    axesAbout(along, x, y);
    for (std::uint32_t i = 0; i < (soft ? kLampRays : 1u); ++i) {
        const float radius = lamp.radius * std::sqrt(static_cast<float>(i) / kLampRays);
        const float turn = kGoldenAngle * static_cast<float>(i);
        const glm::vec3 way = glm::normalize(along * reach + x * (radius * std::cos(turn)) +
                                             y * (radius * std::sin(turn)));
        const float limit = std::min(distance / std::max(glm::dot(way, along), 1e-6f), 1e30f);
        const rays::SurfaceHit hit = tracer->surfaceAlong(start, way, 0.0f, 1e-3f, limit);
        if (!hit.met) sum += hit.share;
    }
    return soft ? sum / static_cast<float>(kLampRays) : sum;
}

glm::vec3 Bake::State::lampsAt(const SurfacePoint& point, float side) const {
    glm::vec3 sum(0.0f);
    const glm::vec3 start = startOf(point, side);
    for (const PlacedLight& lamp : input.lights) {
        glm::vec3 towards(lamp.toLight);
        float distance = 1e30f, falloff = 1.0f;
        if (lamp.kind != LightKind::directional) {
            const glm::vec3 way = glm::vec3(lamp.position - triangles.origin) - start;
            distance = std::max(glm::length(way), 1e-6f);
            towards = way / distance;
            falloff = 1.0f / std::max(distance * distance, 1e-4f);
            if (lamp.range > 0.0f) {
                const float r = std::min(distance / lamp.range, 1.0f);
                falloff *= 1.0f - r * r * r * r;
            }
            if (lamp.kind == LightKind::spot) {
                const float width = std::max(lamp.cosInner - lamp.cosOuter, 1e-3f);
                const float in = std::clamp(
                    (glm::dot(lamp.toLight, towards) - lamp.cosOuter) / width, 0.0f, 1.0f);
                falloff *= in * in;
            }
        }
        const glm::vec3 along(input.mapFromWorld * glm::dvec3(towards));
        const float cosine = side * glm::dot(point.normal, along);
        if (!(cosine > 0.0f) || !(falloff > 0.0f)) continue;
        const glm::vec3 arriving = shareOf(lamp, start, along, distance);
        sum += lamp.intensity * arriving * (falloff * cosine / kPi);
    }
    return sum;
}

// Light that a white surface sends back from a point of a triangle. normal: axes of the map, on the
// side that is seen.
glm::vec3 Bake::State::sentFrom(std::uint32_t instance, const std::uint32_t vertices[3],
                                const float weights[3], const glm::vec3& normal) const {
    const std::int32_t first = places.firstOfInstance[instance];
    if (first == kNoLight) return meanSent;
    glm::vec3 sum(0.0f);
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t index =
            places
                .pointOf[static_cast<std::size_t>(first + static_cast<std::int32_t>(vertices[k]))];
        const SurfacePoint& point = places.points[index];
        const int side = point.twoSided && glm::dot(point.normal, normal) < 0.0f ? 1 : 0;
        sum += weights[k] * sent[side][index];
    }
    return sum;
}

// Weight of a ray that meets an emitter at random against those that are sent to it (balance
// heuristic, Veach 1997). cosine: at the start; facing: at the emitter.
float Bake::State::randomWeight(float cosine, float facing, float distance, float density) const {
    const float atRandom = static_cast<float>(quality.rays) * cosine / kPi;
    const float sent = static_cast<float>(quality.emitterRays) * density * distance * distance /
                       std::max(facing, 1e-6f);
    return atRandom / std::max(atRandom + sent, 1e-30f);
}

// The light along a ray. cosine: between it and the normal of the surface that it leaves; below 0
// if it leaves none, and no other rays are sent to emitters.
Bake::State::Seen Bake::State::look(const glm::vec3& start, const glm::vec3& along,
                                    float cosine) const {
    const glm::vec3 world(glm::transpose(input.mapFromWorld) * glm::dvec3(along));
    rays::TriangleHit hit;
    if (!tree.nearestHit(&start.x, &world.x, hit)) return {};
    const Face& face = faces[hit.place];
    const bool front = glm::dot(face.normal, world) < 0.0f;
    if (face.plain && (front || face.twoSided)) {
        const BvhTriangle& t = tree.triangle(hit.place);
        const std::uint32_t* corners =
            &input.scene->indices[3 * static_cast<std::size_t>(t.triangle)];
        const float weights[3] = {1.0f - hit.u - hit.v, hit.u, hit.v};
        Seen seen{.met = true};
        seen.light = face.albedo *
                     sentFrom(static_cast<std::uint32_t>(t.instance), corners, weights, -along);
        if (face.density > 0.0f) {
            const float facing =
                std::abs(glm::dot(face.normal, world)) / std::max(glm::length(face.normal), 1e-30f);
            seen.emitted = face.emitted;
            if (cosine >= 0.0f) {
                seen.emitted *= randomWeight(cosine, facing, hit.distance, face.density);
            }
        }
        return seen;
    }
    const rays::SurfaceHit passing = tracer->surfaceAlong(start, along, 0.0f, 0.1f);
    Seen seen{.met = passing.met, .begins = passing.begins, .share = passing.share};
    if (passing.met) {
        seen.light = passing.share * passing.albedo *
                     sentFrom(passing.instance, passing.vertices, passing.weights, passing.normal);
    }
    return seen;
}

void Bake::State::gather(std::uint32_t place, int side) {
    const SurfacePoint& point = pointOf(place);
    const float sign = side == 0 ? 1.0f : -1.0f;
    const glm::vec3 normal = sign * point.normal;
    const glm::vec3 start = startOf(point, sign);
    glm::vec3 x, y;
    axesAbout(normal, x, y);
    Sums& sum = sums[side][place];
    sum.forgetBounces(keptOfBounces(round));
    sum.wholeSky = sky.irradiance(normal) * input.environmentIntensity;
    for (std::uint32_t i = 0; i < quality.rays; ++i) {
        const glm::vec2 u =
            pointOfSequence(round * quality.rays + i, 2 * place + static_cast<unsigned>(side));
        const float radius = std::sqrt(u.x), turn = 2.0f * kPi * u.y;
        const float cosine = std::sqrt(std::max(1.0f - u.x, 1e-4f));
        const glm::vec3 along = glm::normalize(x * (radius * std::cos(turn)) +
                                               y * (radius * std::sin(turn)) + normal * cosine);
        const Seen seen = look(start, along, cosine);
        if (!seen.begins) sum.behind += 1.0f;
        const glm::vec3 radiance = sky.radiance(along) * input.environmentIntensity;
        const glm::vec3 open = seen.met ? glm::vec3(0.0f) : seen.share * radiance;
        if (!seen.met) {
            const float through = luminance(seen.share);
            sum.visible += through;
            sum.towards += through * along;
        }
        const float perCosine = 1.0f / std::max(cosine, 0.15f);
        sum.count += 1.0f;
        sum.directions += along;
        sum.open += open;
        sum.hidden += radiance - open;
        sum.openFlux += luminance(open + seen.emitted) * perCosine * along;
        sum.bounceCount += 1.0f;
        sum.bounces += seen.light;
        sum.bounceFlux += luminance(seen.light) * perCosine * along;
        sum.emittersMet += seen.emitted;
    }
    rayCount.fetch_add(quality.rays, std::memory_order_relaxed);
}

void Bake::State::sampleEmitters(std::uint32_t place, int side) {
    const SurfacePoint& from = pointOf(place);
    const float sign = side == 0 ? 1.0f : -1.0f;
    const glm::vec3 start = startOf(from, sign);
    Sums& sum = sums[side][place];
    for (std::uint32_t i = 0; i < quality.emitterRays; ++i) {
        const std::uint32_t number = round * quality.emitterRays + i;
        const glm::vec2 u =
            pointOfSequence(number, 0x40000000u + 2 * place + static_cast<unsigned>(side));
        const double part =
            (i + static_cast<double>(hashed(number ^ (place << 8)) & 0xffffu) / 65536.0) /
            quality.emitterRays;
        const auto chosen =
            std::min(std::upper_bound(emitters.begin(), emitters.end(), part,
                                      [](double p, const Emitter& e) { return p < e.end; }),
                     emitters.end() - 1);
        const float root = std::sqrt(u.x);
        const glm::vec3 there =
            chosen->a + chosen->ab * (root * (1.0f - u.y)) + chosen->ac * (root * u.y);
        const glm::vec3 way = there - start;
        const float distance = glm::length(way);
        sum.emitterCount += 1.0f;
        if (!(distance > 0.0f)) continue;
        const glm::vec3 along(input.mapFromWorld * glm::dvec3(way / distance));
        const float cosine = sign * glm::dot(from.normal, along);
        const glm::vec3 face = glm::normalize(glm::cross(chosen->ab, chosen->ac));
        const float facing = std::abs(glm::dot(face, way / distance));
        if (!(cosine > 0.0f)) continue;
        const rays::SurfaceHit hit =
            tracer->surfaceAlong(start, along, 0.0f, 1e-3f, distance * 1.001f + offset);
        if (!hit.met || hit.distance < distance * 0.999f - 2.0f * offset) continue;
        const float sent = distance * distance * chosen->density / std::max(facing, 1e-6f);
        const float weight =
            chosen->plain ? 1.0f - randomWeight(cosine, facing, distance, chosen->density) : 1.0f;
        // Without the other rays, no point of an emitter fills more than the hemisphere.
        const float perSteradian = std::max(sent, chosen->plain ? 0.0f : 1.0f / kPi);
        const glm::vec3 light =
            hit.share * hit.emitted * (weight / (std::max(perSteradian, 1e-20f) * kPi));
        sum.emitters += light * cosine;
        sum.emitterShare += cosine / (std::max(perSteradian, 1e-20f) * kPi);
        sum.emitterFlux += luminance(light) * along;
    }
    rayCount.fetch_add(quality.emitterRays, std::memory_order_relaxed);
}

// The light of what is not the environment, as much as specular lobes see of it. Most do not see a
// small emitter.
glm::vec3 Bake::State::nearbyFrom(const Sums& s) const {
    const float emitterRays = std::max(s.emitterCount, 1.0f);
    const float seen = std::min(s.emitterShare / (kLargeEmitter * emitterRays), 1.0f);
    return series.scale() * s.bounced() +
           seen * (s.emittersMet / std::max(s.count, 1.0f) + s.emitters / emitterRays);
}

LightAtVertex Bake::State::lightOf(std::uint32_t place) const {
    const SurfacePoint& sample = pointOf(place);
    const Sums& front = sums[0][place];
    const Sums& back = sums[1][place];
    // The weights are for two sides: the inside of a body is dark, and it is not seen.
    glm::vec3 nearby(0.0f);
    float hidden = 0.0f;
    for (int side = 0; side < (sample.twoSided ? 2 : 1); ++side) {
        const Sums& s = sums[side][place];
        const float weight = luminance(irradianceOf(s));
        nearby += weight * nearbyFrom(s);
        hidden += weight * std::max(1.0f - s.visible / std::max(s.count, 1.0f), 0.0f);
    }
    nearby = hidden > 0.0f ? nearby / hidden : glm::vec3(0.0f);
    if (sample.twoSided) {
        return ofBothSides({irradianceOf(front), front.visibleFrom(sample.normal)},
                           {irradianceOf(back), back.visibleFrom(sample.normal)}, sample.normal,
                           nearby);
    }
    LightAtVertex light{.irradiance = irradianceOf(front),
                        .visible = front.visibleFrom(sample.normal),
                        .nearby = nearby};
    const glm::vec3 flux = front.flux(series.scale());
    const float along = glm::dot(flux, sample.normal);
    light.turned = along > 0.0f ? glm::vec4(flux / along, 0.0f) : glm::vec4(sample.normal, 0.0f);
    return light;
}

// Of the whole environment: its mean, and how that changes with the normal.
LightAtVertex Bake::State::unhidden() const {
    const std::array<glm::vec3, 9> harmonics = diffuseHarmonics(*input.environment);
    LightAtVertex light;
    light.irradiance = harmonics[0] * input.environmentIntensity;
    const float mean = std::max(luminance(harmonics[0]), 1e-20f);
    light.turned = {luminance(harmonics[3]) / mean, luminance(harmonics[1]) / mean,
                    luminance(harmonics[2]) / mean, 1.0f};
    return light;
}

void Bake::State::fillBuried() {
    source.resize(places.points.size());
    std::vector<bool> known(places.points.size());
    bool any = false;
    for (std::uint32_t i = 0; i < places.points.size(); ++i) {
        source[i] = i;
        const auto parts = places.partsOf(i);
        known[i] = std::any_of(parts.begin(), parts.end(),
                               [&](const Places::Part& part) { return !buried(part.place); });
        any = any || !known[i];
    }
    const Scene& scene = *input.scene;
    for (int step = 0; any && step < kFillSteps; ++step) {
        any = false;
        std::vector<std::pair<std::uint32_t, std::uint32_t>> found;
        const auto visit = [&](const std::uint32_t corner[3]) {
            for (std::uint32_t j = 0; j < 3; ++j) {
                if (known[corner[j]]) continue;
                any = true;
                const std::uint32_t next = corner[(j + 1) % 3], other = corner[(j + 2) % 3];
                if (known[next] || known[other]) {
                    found.emplace_back(corner[j], source[known[next] ? next : other]);
                }
            }
        };
        for (std::size_t i = 0; i < scene.instances.size(); ++i) {
            const std::int32_t first = places.firstOfInstance[i];
            if (first == kNoLight) continue;
            const Mesh& mesh = scene.meshes[scene.instances[i].mesh];
            for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
                const Cluster& cluster = scene.clusters[mesh.firstCluster + c];
                for (std::uint32_t k = 0; k < cluster.indexCount; k += 3) {
                    std::uint32_t corner[3];
                    for (std::uint32_t j = 0; j < 3; ++j) {
                        const auto vertex =
                            static_cast<std::int32_t>(scene.indices[cluster.firstIndex + k + j]);
                        corner[j] = places.pointOf[static_cast<std::size_t>(first + vertex)];
                    }
                    visit(corner);
                }
            }
        }
        if (found.empty()) break;
        for (const auto& [to, from] : found) {
            if (known[to]) continue;
            source[to] = from;
            known[to] = true;
        }
    }
}

void Bake::State::updateRadiosity() {
    glm::dvec3 direct(0.0), bounced(0.0);
    for (int side = 0; side < 2; ++side) {
        for (std::uint32_t i = 0; i < places.chosen.size(); ++i) {
            if (buried(i)) continue;
            direct += glm::dvec3(sums[side][i].direct() + lamps[side][i]);
            bounced += glm::dvec3(sums[side][i].bounced());
        }
    }
    series.endRound(round, direct, bounced);

    glm::dvec3 total(0.0);
    for (std::uint32_t i = 0; i < places.points.size(); ++i) {
        for (int side = 0; side < 2; ++side) {
            glm::vec3 sum(0.0f);
            float weights = 0.0f;
            for (const Places::Part& part : places.partsOf(source[i])) {
                if (buried(part.place)) continue;
                sum +=
                    part.weight * (irradianceOf(sums[side][part.place]) + lamps[side][part.place]);
                weights += part.weight;
            }
            sent[side][i] = weights > 0.0f ? sum / weights : glm::vec3(0.0f);
        }
        total += glm::dvec3(sent[0][i]);
    }
    if (!places.points.empty()) {
        meanSent = glm::vec3(total / static_cast<double>(places.points.size()));
    }
}

std::optional<LightAtVertex> Bake::State::lightAround(const glm::vec3& point) const {
    constexpr int kRays = 192;
    const auto golden = static_cast<float>(std::numbers::pi * (3.0 - std::sqrt(5.0)));
    glm::vec3 mean(0.0f), met(0.0f), moment(0.0f), towards(0.0f);
    float visible = 0.0f;
    int behind = 0;
    for (int i = 0; i < kRays; ++i) {
        const float z = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / kRays;
        const float radius = std::sqrt(1.0f - z * z), turn = golden * static_cast<float>(i);
        const glm::vec3 along(radius * std::cos(turn), radius * std::sin(turn), z);
        const Seen seen = look(point, along, -1.0f);
        if (!seen.begins) ++behind;
        const glm::vec3 fromSurfaces = seen.light + seen.emitted;
        glm::vec3 light = fromSurfaces;
        if (!seen.met) {
            light += seen.share * sky.radiance(along) * input.environmentIntensity;
            const float through = luminance(seen.share);
            visible += through;
            towards += through * along;
        }
        mean += light;
        met += fromSurfaces;
        moment += luminance(light) * along;
    }
    if (behind > kMaxBehind * kRays) return std::nullopt;
    // Radiance a + b w, of which a surface with the normal n receives pi (a + 2/3 b n); b is three
    // times the mean of radiance times direction.
    const float perRay = 1.0f / kRays, share = visible * perRay;
    LightAtVertex light;
    light.irradiance = mean * perRay;
    const float scale = std::max(luminance(light.irradiance), 1e-20f);
    light.turned = glm::vec4(2.0f * perRay / scale * moment, 1.0f);
    light.visible = glm::vec4(3.0f * perRay * towards, share);
    if (share < 1.0f) light.nearby = met * (perRay / std::max(1.0f - share, 0.5f * perRay));
    return light;
}

void Bake::State::updateGrid() {
    std::vector<bool> known(grid.points());
    for (std::size_t i = 0; i < grid.points(); ++i) {
        const auto light = lightAround(glm::vec3(grid.point(i) - triangles.origin));
        known[i] = light.has_value();
        if (light) grid.values[i] = packed(*light);
    }
    // Points within bodies have the value of the nearest one that is not.
    for (std::size_t i = 0; i < grid.points(); ++i) {
        if (known[i]) continue;
        double least = std::numeric_limits<double>::infinity();
        for (std::size_t k = 0; k < grid.points(); ++k) {
            const double distance = glm::distance(grid.point(i), grid.point(k));
            if (!known[k] || distance >= least) continue;
            least = distance;
            grid.values[i] = grid.values[k];
        }
        if (std::isinf(least)) grid.values[i] = packed(unhidden());
    }
}

Bake::Bake(BakeInput input, const BakeQuality& quality)
    : state_(std::make_unique<State>(std::move(input), quality)) {}
Bake::~Bake() = default;

std::uint32_t Bake::samples() const {
    return static_cast<std::uint32_t>(state_->places.chosen.size());
}

bool Bake::complete() const {
    return state_->round >= state_->quality.rounds || (state_->round > 0 && state_->nothingHidden);
}

void Bake::work(std::uint32_t first, std::uint32_t end) {
    State& s = *state_;
    for (std::uint32_t i = first; i < end; ++i) {
        const SurfacePoint& point = s.pointOf(i);
        for (int side = 0; side < (point.twoSided ? 2 : 1); ++side) {
            if (s.round == 0) s.lamps[side][i] = s.lampsAt(point, side == 0 ? 1.0f : -1.0f);
            s.gather(i, side);
            if (!s.emitters.empty()) s.sampleEmitters(i, side);
        }
    }
}

void Bake::endRound() {
    state_->fillBuried();
    state_->updateRadiosity();
    state_->updateGrid();
    ++state_->round;
    // Surfaces that see only the environment have nothing to learn from further rounds.
    const auto open = [](const Sums& s) { return s.visible >= s.count; };
    state_->nothingHidden = std::all_of(state_->sums[0].begin(), state_->sums[0].end(), open) &&
                            std::all_of(state_->sums[1].begin(), state_->sums[1].end(), open);
}

SurfaceLight Bake::light() const {
    const State& s = *state_;
    SurfaceLight light{.key = s.input.key,
                       .revision = s.round,
                       .share = complete() ? 1.0 : static_cast<double>(s.round) / s.quality.rounds,
                       .scene = s.input.scene,
                       .firstOfInstance = s.places.firstOfInstance,
                       .moving = s.moving,
                       .grid = s.grid};
    // After the values of the open environment and of what moves.
    const auto before = static_cast<std::int32_t>(1 + s.moving.size());
    for (std::int32_t& first : light.firstOfInstance) {
        if (!isConstant(first)) first += before;
    }
    for (std::size_t i = 0; i < s.moving.size(); ++i) {
        light.firstOfInstance[s.moving[i]] = kNoLight + 1 + static_cast<std::int32_t>(i);
    }
    std::vector<LightAtVertex> gathered;
    for (std::uint32_t i = 0; i < s.places.chosen.size(); ++i) gathered.push_back(s.lightOf(i));
    std::vector<LightValue> ofPoints;
    for (std::uint32_t i = 0; i < s.places.points.size(); ++i) {
        LightAtVertex mean{.turned = glm::vec4(0.0f), .visible = glm::vec4(0.0f)};
        float weights = 0.0f;
        for (const Places::Part& part : s.places.partsOf(s.source[i])) {
            if (s.buried(part.place)) continue;
            const LightAtVertex& l = gathered[part.place];
            mean.irradiance += part.weight * l.irradiance;
            mean.turned += part.weight * l.turned;
            mean.visible += part.weight * l.visible;
            mean.nearby += part.weight * l.nearby;
            mean.sides += part.weight * l.sides;
            weights += part.weight;
        }
        const float scale = weights > 0.0f ? 1.0f / weights : 0.0f;
        ofPoints.push_back(packed({mean.irradiance * scale, mean.turned * scale,
                                   mean.visible * scale, mean.nearby * scale, mean.sides * scale}));
    }
    light.values.reserve(s.places.pointOf.size() + 1 + s.moving.size());
    light.values.assign(1 + s.moving.size(), packed(s.unhidden()));
    for (const std::uint32_t point : s.places.pointOf) light.values.push_back(ofPoints[point]);
    return light;
}

std::uint64_t Bake::rays() const {
    return state_->rayCount.load(std::memory_order_relaxed);
}

std::uint64_t Bake::bytes() const {
    const Places& p = state_->places;
    return p.points.size() * (sizeof(SurfacePoint) + 2 * sizeof(glm::vec3)) +
           p.chosen.size() * 2 * (sizeof(Sums) + sizeof(glm::vec3)) +
           p.parts.size() * sizeof(Places::Part) + p.pointOf.size() * sizeof(std::uint32_t) +
           state_->faces.size() * sizeof(Face) + state_->tree.bytes();
}

}  // namespace clerestory::light
