// Lights that are placed by name (KHR_lights_punctual and the environment's sun), and surfaces that
// glow, as light sources to choose from.
#pragma once

#include "reference/world.h"
#include "scene/environment.h"

namespace clerestory::reference {

struct Lamp {
    LightKind kind = LightKind::point;
    glm::dvec3 place{0.0};             // relative to World::origin()
    glm::dvec3 toLamp{0.0, 1.0, 0.0};  // directional: towards it; spot: against its axis
    glm::dvec3 intensity{0.0};
    double range = 0.0;
    double cosInner = 1.0, cosOuter = 0.0;
};

std::vector<Lamp> lampsOf(const Scene& scene, const Pose& pose, const glm::dvec3& origin,
                          const EnvironmentMap& environment, const glm::dmat3& worldFromMap,
                          double environmentIntensity);

// A lamp from a place.
struct LampLight {
    glm::dvec3 toLamp{0.0};      // unit
    double distance = 0.0;       // infinite for directional ones
    glm::dvec3 irradiance{0.0};  // on a surface that faces it, nothing being in the way
};
LampLight lightAt(const Lamp& lamp, const glm::dvec3& place);

// All triangles that glow; one is chosen about as often as light comes from it.
class Emitters {
public:
    explicit Emitters(const World& world);

    bool empty() const { return triangles_.empty(); }

    struct Choice {
        std::uint32_t triangle = kNoTriangle;
        double weightB = 0.0, weightC = 0.0;
        glm::dvec3 place{0.0};
    };
    Choice choose(double which, const glm::dvec2& where) const;

    // Per steradian, of choosing the place that a ray meets on a triangle.
    double density(std::uint32_t triangle, const glm::dvec3& along, double distance) const;

private:
    struct Glowing {
        std::uint32_t triangle = 0;
        double upTo = 0.0;     // light of those before it
        double density = 0.0;  // per square metre
    };
    std::vector<Glowing> triangles_;  // in the order of their numbers
    const World& world_;
};

}  // namespace clerestory::reference
