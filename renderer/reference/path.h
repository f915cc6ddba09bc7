// Light that comes along a ray: follows it through the world by chance, so that the mean of many
// samples is the radiance.
#pragma once

#include "reference/environment_light.h"
#include "reference/random.h"
#include "reference/reference.h"
#include "reference/world.h"

#include <map>

namespace clerestory::reference {

struct Lighting {
    EnvironmentLight environment;
    bool backgroundVisible = true;  // what is seen straight on where nothing is
};

class PathTracer {
public:
    // What is referred to must outlive it.
    PathTracer(const World& world, const Lighting& lighting, ReferenceMode mode)
        : world_(world), lighting_(lighting), mode_(mode) {}

    // One sample of the radiance that comes against the ray.
    glm::dvec3 radiance(const Ray& ray, Random& random) const;

private:
    const World& world_;
    const Lighting& lighting_;
    ReferenceMode mode_;
};

}  // namespace clerestory::reference
