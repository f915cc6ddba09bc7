#include "light/bake.h"

#include "light/light_rays.h"
#include "light/open_light.h"
#include "light/places.h"
#include "light/ray_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace clerestory::light {
namespace {

// Steps from neighbour to neighbour by which buried samples receive values.
constexpr int kFillSteps = 12;
// Distance of places, relative to the length of edges.
constexpr double kPerEdge = 0.7;

std::function<double(const glm::dvec3&)> distanceNearBodies(const EdgeLengths& edges) {
    if (edges.small.empty()) return {};
    return [&edges](const glm::dvec3& world) { return kPerEdge * edges.at(world); };
}

float hiddenShare(const RaySums& s) {
    return std::max(1.0f - s.visible / std::max(s.count, 1.0f), 0.0f);
}

}  // namespace

struct Bake::State {
    State(BakeInput given, const BakeQuality& quality);

    const Receiver& pointOf(std::uint32_t place) const {
        return places.points[places.chosen[place]];
    }
    // Light there is that of its neighbours. What a lamp covers is as bright as the lamp, and
    // hidden.
    bool buried(std::uint32_t place) const {
        const RaySums& s = sums[0][place];
        return s.behind > kMaxBehind * s.count ||
               (s.covered > kMaxCovered * s.count && !pointOf(place).twoSided);
    }
    void updateGrid();
    void fillBuried();
    void updateRadiosity();
    glm::vec3 irradianceOf(const RaySums& s) const {  // over pi; without lights
        return s.direct() + series.scale() * s.bounced();
    }
    float partOfNearby(const RaySums& s) const;
    glm::vec3 nearbyFrom(const RaySums& s) const;
    glm::vec3 nearbyOnBothSides(std::uint32_t place) const;
    EmittersAtVertex emittersOf(std::uint32_t place) const;
    LightAtVertex lightOf(std::uint32_t place) const;
    LightAtVertex unhidden() const {
        return lightInTheOpen(*input.environment, input.environmentIntensity);
    }

    const BakeInput input;
    const BakeQuality quality;
    LightRays rays;
    Places places;
    // Of both sides of each place: sums, and irradiance of punctual lights over pi.
    std::vector<RaySums> sums[2];
    std::vector<glm::vec3> punctual[2];
    Radiosity radiosity;  // after a round
    // The point that a point takes its light from if all its places are buried; else itself.
    std::vector<std::uint32_t> source;
    LightGrid grid;
    std::vector<std::uint32_t> moving;  // instances
    BounceSeries series;
    std::uint32_t round = 0;
    bool nothingHidden = false;  // in the rounds so far
};

Bake::State::State(BakeInput given, const BakeQuality& q)
    : input(std::move(given)), quality(q), rays(input, q) {
    const auto diagonal = static_cast<double>(lastingBounds(*input.scene, *input.pose).diagonal());
    places = placesOf(
        {.scene = *input.scene,
         .pose = *input.pose,
         .materials = input.materials,
         .mapFromWorld = input.mapFromWorld,
         .origin = rays.origin(),
         .distance = input.edges.common > 0.0 ? kPerEdge * input.edges.common : diagonal / 400.0,
         .distanceAt = distanceNearBodies(input.edges),
         .limit = quality.places,
         .clearanceAbove = [&](const Receiver& p) { return rays.clearanceAbove(p); }});
    const std::size_t least =
        std::max<std::size_t>(places.chosen.size(), 1) * (quality.rays + quality.emitterRays);
    const auto more =
        static_cast<std::uint32_t>(std::clamp<std::size_t>(quality.allRays / least, 1, 4));
    rays.setRays(quality.rays * more, quality.emitterRays * more, quality.skyRays * more);
    rays.meet(places, radiosity);
    if (rays.anything()) {
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
    for (int side = 0; side < 2; ++side) {
        sums[side].resize(places.chosen.size());
        punctual[side].resize(places.chosen.size());
        radiosity.sent[side].resize(places.points.size());
    }
}

// The part of the light of emitters that specular lobes have from all directions: emitters that
// fill them are no lights.
float Bake::State::partOfNearby(const RaySums& s) const {
    return std::min(s.emitterShare / std::max(s.emitterCount, 1.0f), 1.0f);
}

// The mean light from surfaces, as for specular lobes.
glm::vec3 Bake::State::nearbyFrom(const RaySums& s) const {
    const glm::vec3 met = s.emittersMet / std::max(s.count, 1.0f);
    const glm::vec3 sent = s.emitters / std::max(s.emitterCount, 1.0f);
    return series.scale() * s.bounced() + partOfNearby(s) * (met + sent);
}

EmittersAtVertex Bake::State::emittersOf(std::uint32_t place) const {
    EmittersAtVertex brighter;
    for (int side = 0; side < (pointOf(place).twoSided ? 2 : 1); ++side) {
        const RaySums& s = sums[side][place];
        const float part = 1.0f - partOfNearby(s);
        EmittersAtVertex e = s.ofEmitters();
        e.light *= part;
        e.flux *= part;
        if (luminance(e.light) > luminance(brighter.light)) brighter = e;
    }
    return brighter;
}

// As ofBothSides() takes it: the mean over both sides, of which the brighter one does not outweigh
// the other.
glm::vec3 Bake::State::nearbyOnBothSides(std::uint32_t place) const {
    const float brightness[2] = {luminance(irradianceOf(sums[0][place])),
                                 luminance(irradianceOf(sums[1][place]))};
    const float least = 1e-3f * std::max(brightness[0], brightness[1]);
    glm::vec3 nearby(0.0f);
    float hidden = 0.0f;
    for (int side = 0; side < 2; ++side) {
        const RaySums& s = sums[side][place];
        const float weight = 1.0f / std::max(brightness[side] + least, 1e-20f);
        nearby += weight * nearbyFrom(s);
        hidden += weight * brightness[side] * hiddenShare(s);
    }
    return hidden > 0.0f ? nearby / hidden : glm::vec3(0.0f);
}

LightAtVertex Bake::State::lightOf(std::uint32_t place) const {
    const Receiver& sample = pointOf(place);
    const RaySums& front = sums[0][place];
    const RaySums& back = sums[1][place];
    if (sample.twoSided) {
        return ofBothSides({irradianceOf(front), front.visibleFrom(sample.normal)},
                           {irradianceOf(back), back.visibleFrom(sample.normal)}, sample.normal,
                           nearbyOnBothSides(place));
    }
    const float hidden = hiddenShare(front);
    const glm::vec3 nearby = hidden > 0.0f ? nearbyFrom(front) / hidden : glm::vec3(0.0f);
    LightAtVertex light{.irradiance = irradianceOf(front),
                        .visible = front.visibleFrom(sample.normal),
                        .nearby = nearby};
    const glm::vec3 flux = front.flux(series.scale());
    const float along = glm::dot(flux, sample.normal);
    light.turned = along > 0.0f ? glm::vec4(flux / along, 0.0f) : glm::vec4(sample.normal, 0.0f);
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
            const double area{places.areas[places.chosen[i]]};
            direct += area * glm::dvec3(sums[side][i].direct() + punctual[side][i]);
            bounced += area * glm::dvec3(sums[side][i].bounced());
        }
    }
    series.endRound(round, direct, bounced);

    glm::dvec3 total(0.0);
    double areas = 0.0;
    for (std::uint32_t i = 0; i < places.points.size(); ++i) {
        for (int side = 0; side < 2; ++side) {
            glm::vec3 sum(0.0f);
            float weights = 0.0f;
            for (const Places::Part& part : places.partsOf(source[i])) {
                if (buried(part.place)) continue;
                sum += part.weight *
                       (irradianceOf(sums[side][part.place]) + punctual[side][part.place]);
                weights += part.weight;
            }
            radiosity.sent[side][i] = weights > 0.0f ? sum / weights : glm::vec3(0.0f);
        }
        const double area{places.areas[i]};
        total += area * glm::dvec3(radiosity.sent[0][i]);
        areas += area;
    }
    if (areas > 0.0) radiosity.mean = glm::vec3(total / areas);
}

void Bake::State::updateGrid() {
    std::vector<bool> known(grid.points());
    for (std::size_t i = 0; i < grid.points(); ++i) {
        const auto light = rays.lightAround(glm::vec3(grid.point(i) - rays.origin()));
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
        const Receiver& point = s.pointOf(i);
        for (int side = 0; side < (point.twoSided ? 2 : 1); ++side) {
            if (s.round == 0)
                s.punctual[side][i] = s.rays.punctualLightAt(point, side == 0 ? 1.0f : -1.0f);
            s.rays.gather(point, i, side, s.round, s.sums[side][i]);
        }
    }
}

void Bake::endRound() {
    state_->fillBuried();
    state_->updateRadiosity();
    state_->updateGrid();
    ++state_->round;
    // Surfaces that see only the environment do not change in further rounds.
    const auto open = [](const RaySums& s) { return s.visible >= s.count; };
    state_->nothingHidden = std::all_of(state_->sums[0].begin(), state_->sums[0].end(), open) &&
                            std::all_of(state_->sums[1].begin(), state_->sums[1].end(), open);
}

SurfaceLight Bake::light() const {
    const State& s = *state_;
    SurfaceLight light{.key = s.input.key,
                       .revision = s.round,
                       .share = complete() ? 1.0 : static_cast<double>(s.round) / s.quality.rounds,
                       .scene = s.input.scene,
                       .edges = s.input.edges,
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
    std::vector<EmittersAtVertex> emitters;
    for (std::uint32_t i = 0; i < s.places.chosen.size(); ++i) {
        gathered.push_back(s.lightOf(i));
        emitters.push_back(s.emittersOf(i));
    }
    std::vector<LightValue> ofPoints;
    std::vector<EmittersValue> emittersOfPoints;
    for (std::uint32_t i = 0; i < s.places.points.size(); ++i) {
        LightAtVertex mean{.turned = glm::vec4(0.0f), .visible = glm::vec4(0.0f)};
        EmittersAtVertex ofEmitters;
        float weights = 0.0f;
        for (const Places::Part& part : s.places.partsOf(s.source[i])) {
            if (s.buried(part.place)) continue;
            ofEmitters.light += part.weight * emitters[part.place].light;
            ofEmitters.flux += part.weight * emitters[part.place].flux;
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
        emittersOfPoints.push_back(
            packed(EmittersAtVertex{ofEmitters.light * scale, ofEmitters.flux * scale}));
    }
    light.values.reserve(s.places.pointOf.size() + 1 + s.moving.size());
    light.values.assign(1 + s.moving.size(), packed(s.unhidden()));
    for (const std::uint32_t point : s.places.pointOf) light.values.push_back(ofPoints[point]);
    if (s.input.emitters) {
        light.emitters.resize(1 + s.moving.size());
        for (const std::uint32_t point : s.places.pointOf) {
            light.emitters.push_back(emittersOfPoints[point]);
        }
    }
    return light;
}

std::uint64_t Bake::rays() const {
    return state_->rays.count();
}

std::uint64_t Bake::bytes() const {
    const Places& p = state_->places;
    return p.points.size() * (sizeof(Receiver) + 2 * sizeof(glm::vec3)) +
           p.chosen.size() * 2 * (sizeof(RaySums) + sizeof(glm::vec3)) +
           p.parts.size() * sizeof(Places::Part) + p.pointOf.size() * sizeof(std::uint32_t) +
           state_->rays.bytes();
}

}  // namespace clerestory::light
