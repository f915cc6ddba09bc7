// One ray of a pixel and its path through the scene, with the same formulae as the shaders: the
// includes of shaders/ are compiled as C++.
//
//     const PathTracer tracer(surroundings);
//     const Path path = tracer.follow(rayOf(start, way), Ray::mirrored, {.paths = 4});
//
// Pure: the same arguments give the same bytes. Threads may share a tracer.
#pragma once

#include "rays/record.h"
#include "rays/surroundings.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <memory>

namespace clerestory::rays {

enum class Ray { mirrored, transmitted };

// How many paths share a lobe that is rough; a smooth one has one path.
struct Lobe {
    std::uint32_t paths = 1;    // 1..16
    std::uint32_t pattern = 0;  // pixels of other patterns look in other directions of the lobe
};

// A record, decoded.
struct RecordedRay {
    glm::vec3 start, along, share;  // along: eye space's axes
    float width, pixel, lobe;       // of its cone: metres, and slopes
    bool intoBody;                  // through one face of a body; else through a pane
};
RecordedRay rayOf(const Start& start, const Way& way);

// Whether several paths show more than one.
bool isRough(const RecordedRay& ray);

struct Path {
    float radiance[3];       // mean of the paths of a lobe
    std::uint32_t surfaces;  // hash of those that were met; 0: there is no ray
    float distance;          // to what is met first, metres: a harmonic mean; of a ray into a body,
                             // length of the path
    std::uint32_t count;     // of paths
};

class PathTracer {
public:
    // The members of `surroundings` must outlive this object.
    explicit PathTracer(const Surroundings& surroundings);
    ~PathTracer();

    // Weights of the directions of a lobe add up to one, so that a uniform environment stays as it
    // is.
    Path follow(const RecordedRay& ray, Ray kind, const Lobe& lobe) const;

private:
    struct Scene;
    std::unique_ptr<Scene> scene_;
};

}  // namespace clerestory::rays
