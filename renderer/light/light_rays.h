// Rays that gather light at the places of a scene and at points of the space between surfaces. One
// object serves all threads of a computation.
#pragma once

#include "light/bake_input.h"
#include "light/faces.h"
#include "light/places.h"
#include "light/ray_sums.h"
#include "light/sky.h"
#include "light/surface_light.h"
#include "rays/path.h"
#include "rays/triangle_tree.h"
#include "scene/bvh.h"

#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

namespace clerestory::light {

// Light that white surfaces would reflect, for both sides of each point of Places.
struct Radiosity {
    std::vector<glm::vec3> sent[2];
    glm::vec3 mean{0.0f};  // over all points

    // From a point of a triangle. normal: axes of the map, on the side that is seen.
    glm::vec3 sentFrom(const Places& places, std::uint32_t instance,
                       const std::uint32_t vertices[3], const float weights[3],
                       const glm::vec3& normal) const;
};

// Fraction of rays that begin behind surfaces above which a place is treated as inside a body.
inline constexpr float kMaxBehind = 0.25f;
// A place is covered by an emitter if at least a fraction of its rays meet it within this fraction
// of the distance of places.
inline constexpr float kMaxCovered = 0.5f, kCovering = 0.15f;

class LightRays {
public:
    // `input` must outlive this.
    LightRays(const BakeInput& input, const BakeQuality& quality);
    LightRays(const LightRays&) = delete;
    LightRays& operator=(const LightRays&) = delete;

    // Sets the light that surfaces reflect, for later rays; both must outlive these calls.
    void meet(const Places& places, const Radiosity& radiosity) {
        places_ = &places;
        radiosity_ = &radiosity;
    }
    // World; all points are relative to it.
    const glm::dvec3& origin() const { return triangles_.origin; }
    bool anything() const { return tree_.stillTriangles() > 0; }
    void setRays(std::uint32_t rays, std::uint32_t emitterRays, std::uint32_t skyRays) {
        quality_.rays = rays;
        quality_.emitterRays = emitterRays;
        quality_.skyRays = sky_.uneven() ? skyRays : 0;
    }

    // See PlacesInput.
    float clearanceAbove(const Receiver& point) const;
    // Irradiance over pi of the punctual lights. side: 1 or -1.
    glm::vec3 punctualLightAt(const Receiver& point, float side) const;
    // Adds a round of rays: with the density of cosines, towards emitters, and under an uneven map
    // with the density of its light. place: its number, from which the rays follow.
    void gather(const Receiver& point, std::uint32_t place, int side, std::uint32_t round,
                RaySums& sum) const;
    // Light at a point, relative to the origin; nothing if it lies within a body.
    std::optional<LightAtVertex> lightAround(const glm::vec3& point) const;

    std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
    std::uint64_t bytes() const { return faces_.size() * sizeof(Face) + tree_.bytes(); }

private:
    static constexpr int kMaxReflections = 4;
    // What a ray meets.
    struct Seen {
        bool met = false, begins = true;
        bool covered = false;  // it meets an emitter within kCovering of the distance of places
        glm::vec3 light{0.0f}, share{1.0f};
        glm::vec3 emitted{0.0f};  // times the weight of rays that meet emitters at random
    };
    // mirrors: that the ray may meet.
    Seen look(const glm::vec3& start, const glm::vec3& along, float cosine,
              int mirrors = kMaxReflections) const;
    // A ray of the world's axes after its reflection by the mirror of a face.
    struct Bounce {
        glm::vec3 start{0.0f}, along{0.0f};  // along: axes of the map
        glm::vec3 share{0.0f};
    };
    template <class Arrives, class Add>
    void eachThrown(const glm::vec3& start, const Arrives& arrives, const Add& add) const;
    void addThrown(const Receiver& point, float side, RaySums& sum) const;
    Bounce bounceAt(const Face& face, const glm::vec3& at, const glm::vec3& world) const;
    Seen lookInMirror(const Face& face, const glm::vec3& at, const glm::vec3& world,
                      int mirrors) const;
    // Irradiance by a punctual light without shadows, and where it comes from.
    struct Arriving {
        glm::vec3 along{0.0f};  // axes of the map
        float distance = 1e30f, perSquareMetre = 0.0f;
    };
    Arriving arriving(const PlacedLight& source, const glm::vec3& at) const;
    // The face of a hit, if the ray can meet nothing else; null if it may pass the face, which
    // PathTracer::surfaceAlong() finds out. world: the ray's direction, axes of the world.
    const Face* plainFace(const rays::TriangleHit& hit, const glm::vec3& world) const;
    float randomWeight(float cosine, float facing, float distance, float density) const;
    glm::vec3 emittedAtRandom(const Face& face, const glm::vec3& world, float distance,
                              float cosine) const;
    glm::vec3 shareOf(const PlacedLight& source, const glm::vec3& start, const glm::vec3& along,
                      float distance) const;
    glm::vec3 inWorld(const glm::vec3& direction) const;
    glm::vec3 startOf(const Receiver& point, float side) const;
    float weightAmongSkyRays(float cosine, const glm::vec3& along) const;
    void sampleSky(const Receiver& point, std::uint32_t place, int side, std::uint32_t round,
                   RaySums& sum) const;
    void sampleEmitters(const Receiver& point, std::uint32_t place, int side, std::uint32_t round,
                        RaySums& sum) const;

    const BakeInput& input_;
    BakeQuality quality_;
    BvhTriangles triangles_;  // without their list, which the tree has
    rays::TriangleTree tree_;
    Sky sky_;
    std::vector<glm::vec2> noBrdf_{glm::vec2(0.0f)};
    std::vector<glm::vec4> noLights_{glm::vec4(0.0f)};
    std::optional<rays::PathTracer> tracer_;
    float offset_ = 0.0f;  // of ray starts, metres
    std::vector<Face> faces_;
    // Relative to the origin.
    std::vector<PlacedLight> lights_, mirroredLights_;
    std::vector<FlatMirror> mirrors_;
    std::vector<Emitter> emitters_;
    const Places* places_ = nullptr;
    const Radiosity* radiosity_ = nullptr;
    mutable std::atomic<std::uint64_t> count_{0};
};

}  // namespace clerestory::light
