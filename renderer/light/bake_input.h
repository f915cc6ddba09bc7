// What the light of a scene is computed from, and how finely.
#pragma once

#include "light/edge_lengths.h"
#include "plan/graph/draw.h"
#include "scene/environment.h"
#include "scene/scene.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace clerestory::light {

struct BakeInput {
    std::uint64_t key = 0;
    std::shared_ptr<const Scene> scene;  // refined()
    std::shared_ptr<const Pose> pose;    // of `scene`
    EdgeLengths edges;                   // of triangles that were divided
    MaterialBindings materials;
    std::vector<PlacedLight> lights;
    std::shared_ptr<const EnvironmentMap> environment;
    glm::dmat3 mapFromWorld{1.0};
    float environmentIntensity = 1.0f;
    bool emission = true;   // emissive surfaces give light
    bool emitters = false;  // there are some: their light is stored for specular lobes
    // Tables of passes/ray_tables.h; rows of instances are relative to the origin of the triangles,
    // with the axes of the map.
    std::vector<glm::vec4> instances, materialRows;
    std::size_t firstTextureRow = 0;
    std::shared_ptr<const std::span<const std::byte>> texels;
    std::uint64_t hitFeatures = 0;
    std::shared_ptr<const void> kept;  // until the computation ends
};

struct BakeQuality {
    std::uint32_t rays = 48;         // of a sample in a round, at least
    std::uint32_t emitterRays = 16;  // likewise, towards emissive surfaces
    std::uint32_t skyRays = 32;      // likewise, towards the light of an uneven map
    // Of a round; fewer samples send up to four times as many each.
    std::uint32_t allRays = 1'500'000;
    std::uint32_t rounds = 6;  // bounces of light are rounds, too
    // Places where light is gathered, at most about; the vertices between them have their mean.
    std::uint32_t places = 60'000;
    // Of the grid for what moves, about.
    std::uint32_t gridPoints = 1000;
};

}  // namespace clerestory::light
