// Computes the light at the vertices of a scene with rays, in rounds that each bring it nearer to
// its limit.
//
//     Bake bake(input, {});
//     while (!bake.complete()) {
//         for (every range of samples) bake.work(first, end);  // from any number of threads
//         bake.endRound();
//     }
//     const SurfaceLight light = bake.light();
//
// Pure: the results depend neither on threads nor on the order of ranges.
#pragma once

#include "light/surface_light.h"
#include "plan/graph/draw.h"
#include "scene/environment.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace clerestory::light {

struct BakeInput {
    std::uint64_t key = 0;
    std::shared_ptr<const Scene> scene;  // refined()
    std::shared_ptr<const Pose> pose;    // of `scene`
    double edge = 0.0;                   // of triangles that were divided, metres; Refined::edge
    MaterialBindings materials;
    std::vector<PlacedLight> lights;
    std::shared_ptr<const EnvironmentMap> environment;
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    bool emission = true;  // emissive surfaces give light
    // Tables of passes/ray_tables.h; rows of instances are relative to the origin of the triangles,
    // with the axes of the map.
    std::vector<glm::vec4> instances, materialRows;
    std::size_t firstTextureRow = 0;
    std::shared_ptr<const std::vector<std::byte>> texels;
    std::uint64_t hitFeatures = 0;
};

struct BakeQuality {
    std::uint32_t rays = 48;         // of a sample in a round, at least
    std::uint32_t emitterRays = 16;  // likewise, towards emissive surfaces
    // Of a round; fewer samples send up to four times as many each.
    std::uint32_t allRays = 1'500'000;
    std::uint32_t rounds = 6;  // bounces of light are rounds, too
    // Places where light is gathered, at most about; the vertices between them have their mean.
    std::uint32_t places = 60'000;
    // Of the grid for what moves, about.
    std::uint32_t gridPoints = 1000;
};

class Bake {
public:
    Bake(BakeInput input, const BakeQuality& quality);
    ~Bake();
    Bake(const Bake&) = delete;
    Bake& operator=(const Bake&) = delete;

    // Places where light is gathered.
    std::uint32_t samples() const;
    bool complete() const;
    // Samples first .. end of the present round; each belongs to one call.
    void work(std::uint32_t first, std::uint32_t end);
    // After all samples of the round.
    void endRound();
    // After any round.
    SurfaceLight light() const;

    std::uint64_t rays() const;  // followed so far
    std::uint64_t bytes() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clerestory::light
