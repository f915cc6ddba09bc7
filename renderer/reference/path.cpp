#include "reference/path.h"

namespace clerestory::reference {

glm::dvec3 PathTracer::radiance(const Ray& ray, Random&) const {
    const std::optional<Hit> hit = world_.nearest(ray);
    if (!hit) {
        return lighting_.backgroundVisible ? lighting_.environment.along(ray.direction)
                                           : glm::dvec3(0.0);
    }
    const Point p = world_.pointAt(*hit, ray.direction);
    return p.emitted + p.baseColor * lighting_.environment.diffuse(p.normal);
}

}  // namespace clerestory::reference
