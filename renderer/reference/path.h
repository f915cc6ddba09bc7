// Monte Carlo estimate of the radiance along a ray: follows one light path through the scene; the
// mean of many samples converges to the radiance.
#pragma once

#include "reference/bsdf.h"
#include "reference/lights.h"
#include "reference/mode.h"
#include "reference/sampler.h"

#include <array>
#include <map>
#include <string>

namespace clerestory::reference {

struct Lighting {
    EnvironmentLight environment;
    std::map<std::string, EnvironmentLight>
        named;  // by the name in Material::environmentMap; in the map's own axes
    std::vector<PunctualLight> lights;
    bool backgroundVisible = true;  // camera rays that leave the scene show the environment
};

// The glass bodies that contain the current path vertex, outermost first.
struct MediumStack {
    struct Body {
        Index instance = 0;
        const Material* material = nullptr;
    };
    static constexpr std::size_t kMax = 8;  // deeper bodies are ignored
    std::array<Body, kMax> bodies;
    std::size_t count = 0;

    double ior() const { return count > 0 ? std::max(1.0, double(top().material->ior)) : 1.0; }
    const Body& top() const { return bodies[count - 1]; }
    void enter(const SurfaceInteraction& point);
    bool leave(const SurfaceInteraction& point);  // false if the body is not on the stack
};

// The part of the pixel that one sample represents.
struct PixelFootprint {
    double fraction = 0.0;  // of the pixel's edge, 0..1; 0: highlights are not averaged
    double spread = 0.0;    // radians between neighbouring rays
    double width = 0.0;     // metres between neighbouring rays at the ray's origin
};

class PathTracer {
public:
    // The arguments must outlive the tracer.
    PathTracer(const SceneGeometry& geometry, const Lighting& lighting, const Effects& effects,
               ReferenceMode mode);

    // One sample of the radiance along the ray. Highlights of punctual lights are averaged over the
    // footprint, so that few samples find them, on a floor in the light of a mirror too; the bias
    // decreases with the footprint (Kaplanyan and Dachsbacher 2013).
    glm::dvec3 radiance(const Ray& ray, Sampler& sampler,
                        const PixelFootprint& footprint = {}) const;

private:
    // The state of one path. Each event adds to `radiance` and either continues or terminates the
    // path.
    struct Path {
        Ray ray;
        Sampler& sampler;
        glm::dvec3 radiance{0.0};
        glm::dvec3 throughput{1.0};
        MediumStack media;
        bool fromCamera = true;  // not reflected so far
        // At the last bounce punctual light from flat mirrors was sampled, too.
        bool mirrorsSampled = false;
        // At the last opaque surface punctual light through glass was sampled in a wide lobe,
        // as if the glass was clear.
        bool glassSampled = false;
        int primary = -1;  // the only one that is left after dispersion; -1: all
        // Solid-angle density of the last bounce if lights were sampled there as well; 0 if they
        // were not, so that emission counts with weight 1.
        double pdf = 0.0;
        double distance = 0.0;  // metres since the last bounce
        PixelFootprint footprint;
        bool terminated = false;

        // Scattering by microfacets of this alpha, on a surface whose normal varies by
        // `normalSpread` radians over the footprint.
        void widen(double alpha, double normalSpread) {
            if (footprint.fraction > 0.0) {
                footprint.spread += 2.0 * (alpha * footprint.fraction + normalSpread);
            }
        }
        void scatter(const Ray& next, const glm::dvec3& factor, double pdfOfDirection = 0.0);
    };

    void addBackground(Path& path) const;
    void scatterAt(Path& path, const Hit& hit) const;
    // Emission of a surface that the path hits, with its multiple importance sampling weight.
    glm::dvec3 weightedEmission(const Path& path, const SurfaceInteraction& point) const;

    // glass_path.cpp
    void scatterAtPane(Path& path, const SurfaceInteraction& point) const;
    void scatterAtSolid(Path& path, const SurfaceInteraction& point) const;
    double dispersedIor(Path& path, const SurfaceInteraction& point) const;
    void reflectFromGlass(Path& path, const SurfaceInteraction& point,
                          const glm::dvec3& towards) const;

    void scatterAtOpaque(Path& path, SurfaceInteraction point) const;
    void scatterInEffects(Path& path, const SurfaceInteraction& point, const Bsdf& bsdf) const;
    void scatterInFull(Path& path, const SurfaceInteraction& point, const Bsdf& bsdf) const;

    // direct_light.cpp
    // Which glass lets light through on its way to a light.
    enum class ThroughGlass { none, clear, all };
    // Mode `full` samples one light and traces a shadow ray; mode `effects` adds all lights without
    // shadows.
    glm::dvec3 evalPunctualLights(Path& path, const SurfaceInteraction& point, const Bsdf& bsdf,
                                  double diffuseScale) const;
    // Light of punctual lights behind a face of rough glass that is refracted towards v, which is
    // local to `frame`, whose z is on the side of v. eta: index behind the face / in front of it.
    // reflects: less what the face reflects.
    glm::dvec3 evalLightsBehind(Path& path, const SurfaceInteraction& point, const Frame& frame,
                                const glm::dvec3& v, double alpha, double eta, bool reflects) const;
    template <class Scattered>
    glm::dvec3 sampleLights(Path& path, const SurfaceInteraction& point, const glm::dvec3& normal,
                            ThroughGlass glass, Scattered scattered) const;
    // How a path continues. The specular direction is sampled first and taken in proportion to its
    // weight: a fixed probability would make paths at grazing angles several times as heavy.
    struct LobeChoice {
        glm::dvec3 diffuse{0.0};  // albedo, less what the sampled microfacet reflects
        double albedo = 0.0;      // greatest channel of the diffuse albedo
        bool specular = true;     // the specular direction is followed
        double diffuseProbability = 0.0;
        // Of following the specular direction whose weight (lobe * cosine / pdf) is this.
        double probability(const glm::dvec3& weight) const {
            if (!specular) return 0.0;
            return albedo > 0.0 ? greatest(weight) / (greatest(weight) + albedo) : 1.0;
        }
    };
    // The environment and emissive triangles, one sample each, weighted against sampling the BSDF.
    glm::dvec3 evalAreaLights(Path& path, const SurfaceInteraction& point, const Bsdf& bsdf,
                              const LobeChoice& choice) const;
    // Transmittance along the ray up to tMax. Glass does not refract here: light passes straight
    // through.
    glm::dvec3 transmittance(const Ray& ray, ThroughGlass glass) const {
        return passage(ray, glass, nullptr).transmittance;
    }
    // The same up to a surface, if it is met; without one, up to tMax.
    struct Passage {
        glm::dvec3 transmittance{0.0};
        std::optional<SurfaceInteraction> end;
    };
    Passage passage(Ray ray, ThroughGlass glass, const Surface* end) const;

    // mirrored_light.cpp
    // Punctual light that flat mirrors throw on diffuse and wide lobes: a path finds a light
    // behind a mirror only by the width of its highlight. One image of a light is sampled.
    glm::dvec3 evalMirroredLights(Path& path, const SurfaceInteraction& point,
                                  const Bsdf& bsdf) const;
    // Whether evalMirroredLights() has added the punctual light of this mirror.
    bool wasSampled(const Path& path, const SurfaceInteraction& mirror) const;

    // Whether the specular lobe at this point is traced through the scene.
    bool tracesReflection(const SurfaceInteraction& point) const;
    // The environment that the specular lobe reflects where it is not traced.
    glm::dvec3 environmentRadiance(const SurfaceInteraction& point,
                                   const glm::dvec3& towards) const;
    bool hasMaterialMap(const SurfaceInteraction& point) const;

    const SceneGeometry& geometry_;
    const Lighting& lighting_;
    Effects effects_;
    ReferenceMode mode_;
    Emitters emitters_;
};

// Whether glass scatters punctual light on its way through. Through clearer glass, as without
// any, a light is not seen.
bool scattersLight(const SurfaceInteraction& point);

// Weight of multiple importance sampling (balance heuristic, Veach 1997); pdf: of the strategy that
// made the sample.
inline double balanceHeuristic(double pdf, double otherPdf) {
    return pdf / (pdf + otherPdf);
}

// Directions below the horizon of the geometric normal are moved just above it; others are returned
// unchanged.
glm::dvec3 clampToHorizon(const glm::dvec3& direction, const glm::dvec3& geometricNormal);

}  // namespace clerestory::reference
