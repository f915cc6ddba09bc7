// What each surface is to light: emitter, glass, mirror. Pure; the words are made only when asked.
//
// Does not: decide what is drawn for it (plan), nor look at views or switches.
#pragma once

#include "scene/material_bindings.h"

#include <string>
#include <vector>

namespace clerestory {

enum class Glass : std::uint8_t {
    none,
    pane,   // thin-walled: light leaves parallel to how it came
    solid,  // light passes both interfaces of a volume
};
enum class Reflector : std::uint8_t {
    none,
    flat,    // one plane: the scene from the mirrored camera
    curved,  // a map of its surroundings, or rays
};

// Why a surface reflects the scene, or why not.
enum class ReflectorReason : std::uint8_t {
    metal,    // metallic >= kMirrorMetallic and roughness <= kMirrorRoughness
    gloss,    // a smooth dielectric in one plane: floors, panes, table tops
    asked,    // reflection: mirror
    probe,    // its material names a probe
    map,      // its material names an environment map
    unlit,    // not: unlit
    refused,  // not: reflection: none
    rough,    // not: a metal, but too rough
    dull,     // not: a dielectric too rough for a mirror
    round,    // not: a smooth dielectric that is not flat; its highlights come from the environment
    cutOut,   // not: a masked dielectric: leaves, chains, lattices
    noLobe,   // not: reflects nothing at any angle
};

inline constexpr float kMirrorMetallic = 0.5f;
inline constexpr float kMirrorRoughness = 0.5f;
inline constexpr float kGlossRoughness = 0.3f;

// Of a material alone; factors with the mean of their textures.
struct MaterialClass {
    bool emitter = false;
    bool transmits = false;
    Reflector onFlat = Reflector::none;    // what its flat parts are
    Reflector onCurved = Reflector::none;  // and everything else
    ReflectorReason whyFlat = ReflectorReason::dull, whyCurved = ReflectorReason::dull;
    float metallic = 0.0f, roughness = 1.0f, transmission = 0.0f;
    float reflectance = 0.0f;  // of light along the normal, mean of the channels
};
MaterialClass classOf(const Scene& scene, const Material& material);

// Clusters of one instance that follow each other and are one thing to light.
struct Surface {
    Index instance = 0;
    Index material = 0;  // as in MaterialBindings
    std::uint32_t firstCluster = 0;
    std::uint32_t clusterCount = 0;
    Index flatPart = kNone;  // in Scene::flatParts, when it is a flat mirror
    bool emitter = false;
    Glass glass = Glass::none;
    Reflector reflector = Reflector::none;
    ReflectorReason why = ReflectorReason::dull;
    float roughness = 1.0f;    // mean
    float reflectance = 0.0f;  // along the normal, mean
    double area = 0.0;         // mesh space

    bool plain() const { return !emitter && glass == Glass::none && reflector == Reflector::none; }
};

// Every cluster of every instance once: an instance's flat mirrors first, largest first, then the
// rest of it as one surface. In the order of instances.
std::vector<Surface> surfacesOf(const Scene& scene, const MaterialBindings& materials = {});

// Sentences without a full stop, for people: why it reflects or not, why it is glass of that kind,
// what it emits.
std::string reflectorReason(const Scene& scene, const MaterialBindings& materials,
                            const Surface& surface);
std::string glassReason(const Scene& scene, const MaterialBindings& materials,
                        const Surface& surface);
std::string emitterReason(const Scene& scene, const MaterialBindings& materials,
                          const Surface& surface);

}  // namespace clerestory
