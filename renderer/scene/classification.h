// Classifies every surface as emitter, glass or reflector, from its material and its flat parts.
// Pure functions; the explanations are separate.
//
// Does not: decide what is drawn (plan), depend on views or effect switches.
#pragma once

#include "scene/scene.h"

#include <string>
#include <vector>

namespace clerestory {

enum class Glass : std::uint8_t {
    none,
    pane,   // thin-walled: light leaves in its original direction
    solid,  // light is refracted at both interfaces of a volume
};
enum class Reflector : std::uint8_t {
    none,
    flat,    // one plane: mirrored view
    curved,  // environment map, captured cube or rays
};

// Why a surface reflects the scene, or why not.
enum class ReflectorReason : std::uint8_t {
    // It reflects:
    metal,      // metallic >= kMirrorMetallic and roughness <= kMirrorRoughness
    gloss,      // a smooth dielectric in one plane: floors, panes, table tops
    patches,    // a dielectric in one plane, at least a tenth of it as smooth as kPatchRoughness
    bright,     // a smooth, opaque dielectric that reflects kBrightReflectance or more
    clearcoat,  // a smooth coat in one plane
    requested,  // reflection: mirror
    probe,      // the material names a probe
    map,        // the material names an environment map
    // It does not reflect:
    unlit,
    disabled,          // reflection: none
    roughMetal,        // roughness > kMirrorRoughness
    roughDielectric,   // roughness > kGlossRoughness
    curvedDielectric,  // smooth, but neither flat nor bright: it reflects the environment map
    alphaMasked,       // a masked dielectric: leaves, chains, lattices
    noSpecular,        // a dielectric with specular factor 0
    anisotropic,       // its lobe is long: it reflects the environment map
    noSurface,         // lines or points
};

inline constexpr float kMirrorMetallic = 0.5f;
inline constexpr float kMirrorRoughness = 0.5f;
inline constexpr float kGlossRoughness = 0.3f;
inline constexpr float kPatchRoughness = 0.15f;
inline constexpr float kBrightReflectance = 0.15f;  // at normal incidence; glazes have 0.04
inline constexpr float kMirrorClearcoat = 0.5f;     // least share of the surface
inline constexpr float kMirrorAnisotropy = 0.1f;    // greatest strength

// The class of a material without its mesh. Factors are multiplied by the mean of their textures.
struct MaterialClass {
    bool emitter = false;
    bool transmits = false;
    Reflector onFlat = Reflector::none;    // of flat parts
    Reflector onCurved = Reflector::none;  // of everything else
    ReflectorReason reasonFlat = ReflectorReason::roughDielectric,
                    reasonCurved = ReflectorReason::roughDielectric;
    float metallic = 0.0f, roughness = 1.0f, transmission = 0.0f;
    float smoothest = 1.0f;  // roughness of the smoothest tenth of its texels
    float clearcoat = 0.0f, clearcoatRoughness = 0.0f;
    float reflectance = 0.0f;  // at normal incidence, mean of the channels
    float slope = 0.0f;        // of its normal map: root mean square
};
MaterialClass classOf(const Scene& scene, const Material& material);

// Contiguous clusters of one instance with the same class.
struct Surface {
    Index instance = 0;
    Index material = 0;  // as in MaterialBindings
    std::uint32_t firstCluster = 0;
    std::uint32_t clusterCount = 0;
    Index flatPart = kNone;  // in Scene::flatParts, of a flat mirror
    bool emitter = false;
    Glass glass = Glass::none;
    // A pane around an inside: its far wall, whose backs are visible, is seen through its near one.
    bool shell = false;
    Reflector reflector = Reflector::none;
    ReflectorReason reason = ReflectorReason::roughDielectric;
    float roughness = 1.0f;    // mean
    float smoothest = 1.0f;    // of the smoothest tenth of its texels
    float reflectance = 0.0f;  // at normal incidence, mean
    float slope = 0.0f;        // of its bumps: root mean square
    double area = 0.0;         // mesh space

    bool plain() const { return !emitter && glass == Glass::none && reflector == Reflector::none; }
};

// Covers every cluster of every instance once, in the order of instances: first the instance's flat
// mirrors, largest first, then its other clusters as one surface.
std::vector<Surface> surfacesOf(const Scene& scene, const MaterialBindings& materials = {});

// Explanations for users, without a full stop: why the surface reflects or not, why it is glass of
// its kind, what it emits.
std::string reflectorReason(const Scene& scene, const MaterialBindings& materials,
                            const Surface& surface);
std::string glassReason(const Scene& scene, const MaterialBindings& materials,
                        const Surface& surface);
std::string emitterReason(const Scene& scene, const MaterialBindings& materials,
                          const Surface& surface);

}  // namespace clerestory
