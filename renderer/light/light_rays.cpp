#include "light/light_rays.h"

#include "light/bodies.h"
#include "light/directions.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace clerestory::light {
namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr std::uint32_t kLightRays = 12;  // to a light with a radius
constexpr std::size_t kMaxImages = 32;    // of lights in mirrors

std::vector<PlacedLight> strongest(std::vector<PlacedLight> lights, std::size_t count) {
    std::stable_sort(lights.begin(), lights.end(), [](const PlacedLight& a, const PlacedLight& b) {
        return luminance(a.intensity) > luminance(b.intensity);
    });
    if (lights.size() > count) lights.resize(count);
    return lights;
}

// All sides can be hit: rays that begin inside a body must notice it.
std::vector<BvhTriangle> fromBothSides(std::vector<BvhTriangle> triangles) {
    for (BvhTriangle& t : triangles) t.side = 0.0f;
    return triangles;
}

}  // namespace

glm::vec3 Radiosity::sentFrom(const Places& places, std::uint32_t instance,
                              const std::uint32_t vertices[3], const float weights[3],
                              const glm::vec3& normal) const {
    const std::int32_t first = places.firstOfInstance[instance];
    if (first == kNoLight) return mean;
    glm::vec3 sum(0.0f);
    for (int k = 0; k < 3; ++k) {
        const std::uint32_t index =
            places
                .pointOf[static_cast<std::size_t>(first + static_cast<std::int32_t>(vertices[k]))];
        const Receiver& point = places.points[index];
        const int side = point.twoSided && glm::dot(point.normal, normal) < 0.0f ? 1 : 0;
        sum += weights[k] * sent[side][index];
    }
    return sum;
}

LightRays::LightRays(const BakeInput& input, const BakeQuality& quality)
    : input_(input), quality_(quality), sky_(*input.environment) {
    triangles_ = stillTriangles(*input.scene, *input.pose, input.materials);
    tree_.setStill(fromBothSides(std::move(triangles_.triangles)));
    tracer_.emplace(
        rays::Surroundings{.tree = tree_,
                           .vertices = input.scene->vertices,
                           .indices = input.scene->indices,
                           .instances = input.instances,
                           .materials = input.materialRows,
                           .firstTextureRow = input.firstTextureRow,
                           .texels = *input.texels,
                           .lights = noLights_,
                           .environment = sky_.map(),
                           .brdf = noBrdf_,
                           .brdfSize = 1,
                           .worldFromEye = glm::mat3(glm::transpose(input.mapFromWorld)),
                           .hitFeatures = input.hitFeatures});
    offset_ = static_cast<float>(
        1e-4 * static_cast<double>(lastingBounds(*input.scene, *input.pose).diagonal()));
    faces_ = facesOf(input, tree_, *tracer_);
    const std::vector<bool> bodies = closedBodies(input, tree_, faces_, triangles_.origin);
    for (std::uint32_t i = 0; i < faces_.size(); ++i) {
        faces_[i].ofBody = bodies[static_cast<std::size_t>(tree_.triangle(i).instance)];
    }
    emitters_ = emittersOf(input, tree_, faces_);
    mirrors_ = mirrorsOf(input, tree_, faces_, triangles_.origin);
    lights_ = input.lights;
    for (PlacedLight& light : lights_) light.position -= triangles_.origin;
    if (!mirrors_.empty()) mirroredLights_ = strongest(lights_, kMaxImages / mirrors_.size());
}

// A direction with the map's axes, in those of the world.
glm::vec3 LightRays::inWorld(const glm::vec3& direction) const {
    return {glm::transpose(input_.mapFromWorld) * glm::dvec3(direction)};
}

glm::vec3 LightRays::startOf(const Receiver& point, float side) const {
    return point.start + inWorld(point.normal) * (side * offset_);
}

float LightRays::clearanceAbove(const Receiver& point) const {
    const glm::vec3 normal = inWorld(point.normal);
    // Nearer than other rays, because surfaces that lie on each other are.
    const glm::vec3 start = point.position + normal * (0.01f * offset_);
    rays::TriangleHit hit;
    return tree_.nearestHit(&start.x, &normal.x, hit) ? hit.distance
                                                      : std::numeric_limits<float>::infinity();
}

// Visible fraction of a punctual light. along: to its centre, axes of the map; distance: to it,
// metres.
glm::vec3 LightRays::shareOf(const PlacedLight& source, const glm::vec3& start,
                             const glm::vec3& along, float distance) const {
    const bool soft = source.radius > 0.0f;
    const float reach = source.kind == LightKind::directional ? 1.0f : distance;
    glm::vec3 x, y, sum(0.0f);
    axesAbout(along, x, y);
    for (std::uint32_t i = 0; i < (soft ? kLightRays : 1u); ++i) {
        const float radius = source.radius * std::sqrt(static_cast<float>(i) / kLightRays);
        const float turn = kGoldenAngle * static_cast<float>(i);
        const glm::vec3 way = glm::normalize(along * reach + x * (radius * std::cos(turn)) +
                                             y * (radius * std::sin(turn)));
        const float limit = std::min(distance / std::max(glm::dot(way, along), 1e-6f), 1e30f);
        const glm::vec3 world = inWorld(way);
        rays::TriangleHit first;
        if (!tree_.nearestHit(&start.x, &world.x, first) || first.distance >= limit) {
            sum += glm::vec3(1.0f);
        } else if (!plainFace(first, world)) {
            const rays::SurfaceHit hit =
                tracer_->surfaceAlong(start, way, 0.0f, 1e-3f, limit, &first);
            if (!hit.met) sum += hit.share;
        }
    }
    return soft ? sum / static_cast<float>(kLightRays) : sum;
}

LightRays::Arriving LightRays::arriving(const PlacedLight& source, const glm::vec3& at) const {
    glm::vec3 towards(source.toLight);
    Arriving light{.perSquareMetre = 1.0f};
    if (source.kind != LightKind::directional) {
        const glm::vec3 way = glm::vec3(source.position) - at;
        light.distance = std::max(glm::length(way), 1e-6f);
        towards = way / light.distance;
        light.perSquareMetre = 1.0f / std::max(light.distance * light.distance, 1e-4f);
        if (source.range > 0.0f) {
            const float r = std::min(light.distance / source.range, 1.0f);
            light.perSquareMetre *= 1.0f - r * r * r * r;
        }
        if (source.kind == LightKind::spot) {
            const float width = std::max(source.cosInner - source.cosOuter, 1e-3f);
            const float in = std::clamp(
                (glm::dot(source.toLight, towards) - source.cosOuter) / width, 0.0f, 1.0f);
            light.perSquareMetre *= in * in;
        }
    }
    light.along = glm::vec3(input_.mapFromWorld * glm::dvec3(towards));
    return light;
}

glm::vec3 LightRays::punctualLightAt(const Receiver& point, float side) const {
    glm::vec3 sum(0.0f);
    const glm::vec3 start = startOf(point, side);
    for (const PlacedLight& source : lights_) {
        const Arriving light = arriving(source, start);
        const float cosine = side * glm::dot(point.normal, light.along);
        if (!(cosine > 0.0f) || !(light.perSquareMetre > 0.0f)) continue;
        const glm::vec3 share = shareOf(source, start, light.along, light.distance);
        sum += source.intensity * share * (light.perSquareMetre * cosine / kPi);
    }
    return sum;
}

// arrives(along): whether light from this direction counts; add(along, irradiance): of a surface
// that faces it.
template <class Arrives, class Add>
void LightRays::eachThrown(const glm::vec3& start, const Arrives& arrives, const Add& add) const {
    for (const PlacedLight& source : mirroredLights_) {
        for (std::size_t k = 0; k < mirrors_.size(); ++k) {
            if (!mirrors_[k].shows(source, glm::dvec3(start))) continue;
            const Arriving light = arriving(mirrors_[k].imageOf(source), start);
            if (!(light.perSquareMetre > 0.0f) || !arrives(light.along)) continue;
            const glm::vec3 world = inWorld(light.along);
            rays::TriangleHit hit;
            if (!tree_.nearestHit(&start.x, &world.x, hit) || faces_[hit.triangle].mirror != k) {
                continue;
            }
            const Bounce bounce =
                bounceAt(faces_[hit.triangle], start + hit.distance * world, world);
            const glm::vec3 share =
                shareOf(source, bounce.start, bounce.along, light.distance - hit.distance);
            add(light.along, source.intensity * bounce.share * share * light.perSquareMetre);
        }
    }
}

// Of lights that flat mirrors show to a place, as often as rays with the density of cosines.
void LightRays::addThrown(const Receiver& point, float side, RaySums& sum) const {
    const auto cosineOf = [&](const glm::vec3& along) {
        return side * glm::dot(point.normal, along);
    };
    eachThrown(
        startOf(point, side), [&](const glm::vec3& along) { return cosineOf(along) > 0.0f; },
        [&](const glm::vec3& along, const glm::vec3& irradiance) {
            const glm::vec3 light =
                irradiance * (cosineOf(along) / kPi * static_cast<float>(quality_.rays));
            const glm::vec3 whole = light / std::max(cosineOf(along), 0.15f);
            sum.emittersMet += light;
            sum.openFlux += luminance(whole) * along;
            sum.metLight += whole;
            sum.metFlux += luminance(whole) * along;
        });
}

LightRays::Bounce LightRays::bounceAt(const Face& face, const glm::vec3& at,
                                      const glm::vec3& world) const {
    const FlatMirror& mirror = mirrors_[face.mirror];
    const glm::vec3 normal(mirror.plane.normal);
    const float facing = glm::dot(normal, world);
    const float grazing = std::pow(std::max(1.0f - std::abs(facing), 0.0f), 5.0f);
    return {.start = at + normal * std::copysign(offset_, -facing),
            .along = glm::vec3(input_.mapFromWorld * glm::dvec3(mirror.turned(world))),
            .share = glm::mix(face.albedo, glm::vec3(1.0f), grazing)};  // Schlick 1994
}

LightRays::Seen LightRays::lookInMirror(const Face& face, const glm::vec3& at,
                                        const glm::vec3& world, int mirrors) const {
    count_.fetch_add(1, std::memory_order_relaxed);
    const Bounce bounce = bounceAt(face, at, world);
    const Seen there = look(bounce.start, bounce.along, -1.0f, mirrors);
    Seen seen{.met = true, .light = bounce.share * there.light};
    seen.emitted = bounce.share * there.emitted;
    if (!there.met) {
        seen.emitted +=
            bounce.share * there.share * sky_.radiance(bounce.along) * input_.environmentIntensity;
    }
    return seen;
}

// Weight of a ray that meets an emitter at random against those that are sent to it (balance
// heuristic, Veach 1997). cosine: at the start; facing: at the emitter.
float LightRays::randomWeight(float cosine, float facing, float distance, float density) const {
    const float atRandom = static_cast<float>(quality_.rays) * cosine / kPi;
    const float sent = static_cast<float>(quality_.emitterRays) * density * distance * distance /
                       std::max(facing, 1e-6f);
    return atRandom / std::max(atRandom + sent, 1e-30f);
}

// What a ray brings that meets an emitter at random. cosine: as look() takes it.
glm::vec3 LightRays::emittedAtRandom(const Face& face, const glm::vec3& world, float distance,
                                     float cosine) const {
    if (!(face.density > 0.0f)) return glm::vec3(0.0f);
    if (cosine < 0.0f) return face.emitted;
    const float facing =
        std::abs(glm::dot(face.normal, world)) / std::max(glm::length(face.normal), 1e-30f);
    return face.emitted * randomWeight(cosine, facing, distance, face.density);
}

const Face* LightRays::plainFace(const rays::TriangleHit& hit, const glm::vec3& world) const {
    const Face& face = faces_[hit.triangle];
    const bool front = glm::dot(face.normal, world) < 0.0f;
    return face.plain && (front || face.twoSided) ? &face : nullptr;
}

// The light along a ray. cosine: between it and the normal of the surface that it leaves; below 0
// if it leaves none, and no other rays are sent to emitters.
LightRays::Seen LightRays::look(const glm::vec3& start, const glm::vec3& along, float cosine,
                                int mirrors) const {
    const glm::vec3 world = inWorld(along);
    rays::TriangleHit hit;
    if (!tree_.nearestHit(&start.x, &world.x, hit)) return {};
    if (const Face* const face = plainFace(hit, world)) {
        if (face->ofBody && glm::dot(face->normal, world) > 0.0f) {
            return {.met = true, .begins = false};
        }
        if (face->mirror != kNoMirror && mirrors > 0) {
            return lookInMirror(*face, start + hit.distance * world, world, mirrors - 1);
        }
        const BvhTriangle& t = tree_.triangle(hit.triangle);
        const std::uint32_t* corners =
            &input_.scene->indices[3 * static_cast<std::size_t>(t.triangle)];
        const float weights[3] = {1.0f - hit.u - hit.v, hit.u, hit.v};
        Seen seen{.met = true};
        seen.light =
            face->albedo * radiosity_->sentFrom(*places_, static_cast<std::uint32_t>(t.instance),
                                                corners, weights, -along);
        if (face->twoSided && face->through != glm::vec3(0.0f)) {
            seen.light += face->through *
                          radiosity_->sentFrom(*places_, static_cast<std::uint32_t>(t.instance),
                                               corners, weights, along);
        }
        seen.emitted = emittedAtRandom(*face, world, hit.distance, cosine);
        seen.covered = face->density > 0.0f && hit.distance < kCovering * places_->distance;
        return seen;
    }
    const rays::SurfaceHit passing =
        tracer_->surfaceAlong(start, along, 0.0f, 0.1f, rays::kNoLimit, &hit);
    Seen seen{.met = passing.met, .begins = passing.begins, .share = passing.share};
    if (passing.met && passing.share != glm::vec3(0.0f)) {
        seen.light = passing.share * passing.albedo *
                     radiosity_->sentFrom(*places_, passing.instance, passing.vertices,
                                          passing.weights, passing.normal);
        const Face& face = faces_[passing.face];
        if (face.plain) {
            seen.emitted = passing.share * emittedAtRandom(face, world, passing.distance, cosine);
        }
    }
    return seen;
}

void LightRays::gather(const Receiver& point, std::uint32_t place, int side, std::uint32_t round,
                       RaySums& sum) const {
    const float sign = side == 0 ? 1.0f : -1.0f;
    const glm::vec3 normal = sign * point.normal;
    const glm::vec3 start = startOf(point, sign);
    glm::vec3 x, y;
    axesAbout(normal, x, y);
    sum.forgetBounces(keptOfBounces(round));
    sum.wholeSky = sky_.irradiance(normal) * input_.environmentIntensity;
    for (std::uint32_t i = 0; i < quality_.rays; ++i) {
        const glm::vec2 u =
            pointOfSequence(round * quality_.rays + i, 2 * place + static_cast<unsigned>(side));
        const float radius = std::sqrt(u.x), turn = 2.0f * kPi * u.y;
        const float cosine = std::sqrt(std::max(1.0f - u.x, 1e-4f));
        const glm::vec3 along = glm::normalize(x * (radius * std::cos(turn)) +
                                               y * (radius * std::sin(turn)) + normal * cosine);
        const Seen seen = look(start, along, cosine);
        if (!seen.begins) sum.behind += 1.0f;
        if (seen.covered) sum.covered += 1.0f;
        const glm::vec3 radiance =
            sky_.radiance(along) * input_.environmentIntensity * weightAmongSkyRays(cosine, along);
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
        sum.metLight += seen.emitted * perCosine;
        sum.metFlux += luminance(seen.emitted) * perCosine * along;
    }
    count_.fetch_add(quality_.rays, std::memory_order_relaxed);
    addThrown(point, sign, sum);
    if (quality_.skyRays > 0) sampleSky(point, place, side, round, sum);
    if (!emitters_.empty()) sampleEmitters(point, place, side, round, sum);
}

// Weight of a ray with the density of cosines against those that have that of the map's light
// (balance heuristic).
float LightRays::weightAmongSkyRays(float cosine, const glm::vec3& along) const {
    if (quality_.skyRays == 0) return 1.0f;
    const float atRandom = static_cast<float>(quality_.rays) * cosine / kPi;
    const float sent = static_cast<float>(quality_.skyRays) * sky_.density(along);
    return atRandom / std::max(atRandom + sent, 1e-30f);
}

void LightRays::sampleSky(const Receiver& point, std::uint32_t place, int side, std::uint32_t round,
                          RaySums& sum) const {
    const float sign = side == 0 ? 1.0f : -1.0f;
    const glm::vec3 start = startOf(point, sign);
    // The sums are divided by the number of the other rays.
    const float perRay =
        static_cast<float>(quality_.rays) / static_cast<float>(quality_.skyRays) / kPi;
    std::uint32_t sent = 0;
    for (std::uint32_t i = 0; i < quality_.skyRays; ++i) {
        const std::uint32_t number = round * quality_.skyRays + i;
        const std::uint32_t seed = 0x80000000u + 2 * place + static_cast<unsigned>(side);
        const float part =
            (static_cast<float>(i) +
             static_cast<float>(hashed(number ^ (place << 8)) & 0xffffu) / 65536.0f) /
            static_cast<float>(quality_.skyRays);
        const glm::vec3 along = sky_.sample(part, pointOfSequence(number, seed));
        const float cosine = sign * glm::dot(point.normal, along);
        if (!(cosine > 0.0f)) continue;
        ++sent;
        const float weight = (1.0f - weightAmongSkyRays(cosine, along)) * perRay /
                             std::max(sky_.density(along), 1e-20f);
        const glm::vec3 radiance =
            sky_.radiance(along) * (input_.environmentIntensity * weight * cosine);
        const Seen seen = look(start, along, cosine);
        const glm::vec3 open = seen.met ? glm::vec3(0.0f) : seen.share * radiance;
        sum.open += open;
        sum.hidden += radiance - open;
        sum.openFlux += luminance(open) / std::max(cosine, 0.15f) * along;
    }
    count_.fetch_add(sent, std::memory_order_relaxed);
}

void LightRays::sampleEmitters(const Receiver& point, std::uint32_t place, int side,
                               std::uint32_t round, RaySums& sum) const {
    const float sign = side == 0 ? 1.0f : -1.0f;
    const glm::vec3 start = startOf(point, sign);
    for (std::uint32_t i = 0; i < quality_.emitterRays; ++i) {
        const std::uint32_t number = round * quality_.emitterRays + i;
        const glm::vec2 u =
            pointOfSequence(number, 0x40000000u + 2 * place + static_cast<unsigned>(side));
        const double part =
            (i + static_cast<double>(hashed(number ^ (place << 8)) & 0xffffu) / 65536.0) /
            quality_.emitterRays;
        const auto chosen =
            std::min(std::upper_bound(emitters_.begin(), emitters_.end(), part,
                                      [](double p, const Emitter& e) { return p < e.end; }),
                     emitters_.end() - 1);
        const float root = std::sqrt(u.x);
        const glm::vec3 there =
            chosen->a + chosen->ab * (root * (1.0f - u.y)) + chosen->ac * (root * u.y);
        const glm::vec3 way = there - start;
        const float distance = glm::length(way);
        sum.emitterCount += 1.0f;
        if (!(distance > 0.0f)) continue;
        const glm::vec3 along(input_.mapFromWorld * glm::dvec3(way / distance));
        const float cosine = sign * glm::dot(point.normal, along);
        const glm::vec3 face = glm::normalize(glm::cross(chosen->ab, chosen->ac));
        const float facing = std::abs(glm::dot(face, way / distance));
        if (!(cosine > 0.0f)) continue;
        const glm::vec3 world = way / distance;
        const float least = distance * 0.999f - 2.0f * offset_, limit = distance * 1.001f + offset_;
        rays::TriangleHit first;
        if (!tree_.nearestHit(&start.x, &world.x, first) || first.distance >= limit) continue;
        if (first.distance < least && plainFace(first, world)) continue;
        const rays::SurfaceHit hit =
            tracer_->surfaceAlong(start, along, 0.0f, 1e-3f, limit, &first);
        if (!hit.met || hit.distance < least) continue;
        const float sent = distance * distance * chosen->density / std::max(facing, 1e-6f);
        const float weight =
            chosen->plain ? 1.0f - randomWeight(cosine, facing, distance, chosen->density) : 1.0f;
        // Without the other rays, no point of an emitter fills more than the hemisphere.
        const float perSteradian = std::max(sent, chosen->plain ? 0.0f : 1.0f / kPi);
        const glm::vec3 light =
            hit.share * hit.emitted * (weight / (std::max(perSteradian, 1e-20f) * kPi));
        sum.emitters += light * cosine;
        sum.emitterLight += light;
        sum.emitterShare += cosine / (std::max(perSteradian, 1e-20f) * kPi);
        sum.emitterFlux += luminance(light) * along;
    }
    count_.fetch_add(quality_.emitterRays, std::memory_order_relaxed);
}

std::optional<LightAtVertex> LightRays::lightAround(const glm::vec3& point) const {
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
            light += seen.share * sky_.radiance(along) * input_.environmentIntensity;
            const float through = luminance(seen.share);
            visible += through;
            towards += through * along;
        }
        mean += light;
        met += fromSurfaces;
        moment += luminance(light) * along;
    }
    if (behind > kMaxBehind * kRays) return std::nullopt;
    eachThrown(
        point, [](const glm::vec3&) { return true; },
        [&](const glm::vec3& along, const glm::vec3& irradiance) {
            const glm::vec3 light = irradiance * (kRays / (4.0f * kPi));
            mean += light;
            met += light;
            moment += luminance(light) * along;
        });
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

}  // namespace clerestory::light
