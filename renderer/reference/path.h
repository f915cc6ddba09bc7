// Light that comes along a ray: follows it through the world by chance, so that the mean of many
// samples is the radiance.
#pragma once

#include "reference/environment_light.h"
#include "reference/lamps.h"
#include "reference/lobes.h"
#include "reference/random.h"
#include "reference/reference.h"

#include <array>
#include <map>
#include <string>

namespace clerestory::reference {

struct Lighting {
    EnvironmentLight environment;
    std::map<std::string, EnvironmentLight> named;  // by what materials call them, but not turned
    std::vector<Lamp> lamps;
    bool backgroundVisible = true;  // what is seen straight on where nothing is
};

// The glass bodies that a path is in, from the outermost.
struct Media {
    struct Body {
        Index instance = 0;
        const Material* material = nullptr;
    };
    static constexpr std::size_t kMax = 8;  // deeper ones count as empty
    std::array<Body, kMax> bodies;
    std::size_t count = 0;

    double index() const { return count > 0 ? std::max(1.0, double(last().material->ior)) : 1.0; }
    const Body& last() const { return bodies[count - 1]; }
    void enter(const Point& point);
    bool leave(const Point& point);  // false: was not in it
};

// What a sample stands for: so much of the edge of all that was to be sampled, 0..1; of the pixel
// that is radians of directions, and metres where its ray begins.
struct PixelShare {
    double edge = 0.0, spread = 0.0, width = 0.0;
};

class PathTracer {
public:
    // What is referred to must outlive it.
    PathTracer(const World& world, const Lighting& lighting, const Effects& effects,
               ReferenceMode mode);

    // One sample of the radiance that comes against the ray. Highlights of lamps without size are
    // averaged over what the sample stands for, so that a few find them; what that gets wrong goes
    // with the share (Kaplanyan and Dachsbacher 2013).
    glm::dvec3 radiance(const Ray& ray, Random& random, const PixelShare& share = {}) const;

private:
    // A path on its way. Every step adds to `sum` and either sends it on or ends it.
    struct Path {
        Ray ray;
        Random& random;
        glm::dvec3 sum{0.0};
        glm::dvec3 weight{1.0};
        Media media;
        bool straight = true;  // nothing has reflected it
        double density = 0.0;  // of its last turn, per steradian, where lights were chosen as well;
                               // 0: they were not, and all that is met counts
        double travelled = 0.0;  // metres since that turn
        PixelShare stands;       // what it stands for by now

        // It was sent on by facets with this alpha, where normals turn by this much.
        void widen(double alpha, double turn) {
            if (stands.edge > 0.0) stands.spread += 2.0 * (alpha * stands.edge + turn);
        }
        bool ended = false;

        void turn(const Ray& next, const glm::dvec3& share, double turnDensity = 0.0);
    };

    void meetNothing(Path& path) const;
    void meet(Path& path, const Hit& hit) const;
    glm::dvec3 emittedAt(const Path& path, const Point& point) const;

    // glass_path.cpp
    void meetPane(Path& path, const Point& point) const;
    void meetSolid(Path& path, const Point& point) const;
    void reflectGlass(Path& path, const Point& point, const glm::dvec3& towards) const;

    void meetOpaque(Path& path, const Point& point) const;
    void meetInEffects(Path& path, const Point& point, const Lobes& lobes) const;
    void meetInFull(Path& path, const Point& point, const Lobes& lobes) const;

    // direct_light.cpp
    glm::dvec3 underLamps(Path& path, const Point& point, const Lobes& lobes,
                          double diffuseShare) const;
    glm::dvec3 underChosenLights(Path& path, const Point& point, const Lobes& lobes,
                                 double specularChance, double rest) const;
    // Share of light that gets from a point along a ray as far as its end. Through glass: as if it
    // bent nothing.
    glm::dvec3 arriving(Ray ray, bool throughGlass) const;

    bool traces(const Surface& surface) const;  // its specular lobe sees the scene
    // What the specular lobe of a point sees where it does not see the scene.
    glm::dvec3 surroundings(const Point& point, const glm::dvec3& towards) const;
    bool hasOwnMap(const Point& point) const;

    const World& world_;
    const Lighting& lighting_;
    Effects effects_;
    ReferenceMode mode_;
    Emitters emitters_;
};

// A direction above the normal's horizon that lies below the face's, laid along the face.
glm::dvec3 above(const glm::dvec3& direction, const glm::dvec3& face);

}  // namespace clerestory::reference
