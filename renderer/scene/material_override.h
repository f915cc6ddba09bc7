// Material overrides: from a request for one frame, from a sidecar file for the loaded scene.
#pragma once

#include "scene/fields.h"
#include "scene/geometry.h"
#include "scene/scene.h"

#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

// Selects the instances whose material has the name `material` and whose node, or an ancestor of
// it, has the name `node`; a name that is absent selects all. A field that is set also replaces the
// texture that would scale it.
struct MaterialOverride {
    std::optional<std::string> material;
    std::optional<std::string> node;
    std::optional<glm::dvec3> baseColor;
    std::optional<double> metallic;
    std::optional<double> roughness;
    std::optional<glm::dvec3> emissive;
    std::optional<double> emissiveStrength;
    std::optional<double> transmission;
    std::optional<double> ior;
    std::optional<double> thickness;
    std::optional<glm::dvec3> attenuationColor;
    std::optional<double> attenuationDistance;
    std::optional<double> dispersion;
    std::optional<double> clearcoat;
    std::optional<double> clearcoatRoughness;
    std::optional<glm::dvec3> sheenColor;
    std::optional<double> sheenRoughness;
    std::optional<double> iridescence;
    std::optional<double> iridescenceIor;
    std::optional<double> iridescenceThickness;
    std::optional<double> anisotropy;
    std::optional<double> anisotropyRotation;
    std::optional<double> diffuseTransmission;
    std::optional<glm::dvec3> diffuseTransmissionColor;
    std::optional<Reflection> reflection;
    std::optional<std::string> probe;
    std::optional<std::string> environmentMap;
    std::optional<Quaternion> environmentRotation;
    std::optional<MapBlur> mapBlur;
};

inline Choice<Reflection> reflectionChoice() {
    return {{{"automatic", Reflection::automatic},
             {"none", Reflection::none},
             {"mirror", Reflection::mirror}}};
}

template <class O, class V>
requires std::same_as<std::remove_const_t<O>, MaterialOverride>
void fields(O& o, V&& visit) {
    visit("material", o.material, Text{256}, "name of the material to change");
    visit("node", o.node, Text{256}, "name of the node at or below which materials change");
    visit("baseColor", o.baseColor, Range{0, 1e6}, "linear RGB; alpha is unchanged");
    visit("metallic", o.metallic, Range{0, 1}, "0: dielectric, 1: metal");
    visit("roughness", o.roughness, Range{0, 1}, "perceptual; alpha is its square");
    visit("emissive", o.emissive, Range{0, 1e6}, "linear RGB radiance, times emissiveStrength");
    visit("emissiveStrength", o.emissiveStrength, Range{0, 1e6}, "factor on emissive");
    visit("transmission", o.transmission, Range{0, 1},
          "fraction of light that enters the surface; above 0 it is glass");
    visit("ior", o.ior, Range{1, 10}, "index of refraction");
    visit("thickness", o.thickness, Range{0, 1e6},
          "thickness of the volume, metres in mesh space; 0: thin-walled");
    visit("attenuationColor", o.attenuationColor, Range{0, 1},
          "colour of white light after attenuationDistance in the material");
    visit("attenuationDistance", o.attenuationDistance, Range{0, 1e9}, "metres; 0: no absorption");
    visit("dispersion", o.dispersion, Range{0, 20}, "dispersion of solid glass: 20 / Abbe number");
    visit("clearcoat", o.clearcoat, Range{0, 1}, "share of the surface with a clear coat");
    visit("clearcoatRoughness", o.clearcoatRoughness, Range{0, 1}, "perceptual");
    visit("sheenColor", o.sheenColor, Range{0, 1}, "linear RGB of fibres on the surface; 0: none");
    visit("sheenRoughness", o.sheenRoughness, Range{0, 1}, "perceptual");
    visit("iridescence", o.iridescence, Range{0, 1}, "share of the surface with a thin film");
    visit("iridescenceIor", o.iridescenceIor, Range{1, 10}, "index of refraction of the film");
    visit("iridescenceThickness", o.iridescenceThickness, Range{0, 1e5},
          "thickness of the film, nanometres; with a texture, where the texture is 1");
    visit("anisotropy", o.anisotropy, Range{0, 1}, "strength of the anisotropy; 0: isotropic");
    visit("anisotropyRotation", o.anisotropyRotation, Range{-1e6, 1e6},
          "direction of the anisotropy, radians counter-clockwise from the tangent");
    visit("diffuseTransmission", o.diffuseTransmission, Range{0, 1},
          "share of diffuse light that leaves on the other side");
    visit("diffuseTransmissionColor", o.diffuseTransmissionColor, Range{0, 1}, "linear RGB");
    visit("reflection", o.reflection, reflectionChoice(),
          "whether it reflects the scene; automatic: by metallic and roughness");
    visit("probe", o.probe, Text{128}, "a probe of the scene that it reflects; empty: its own");
    visit("environmentMap", o.environmentMap, Text{128},
          "a loaded environment map that it reflects instead of the scene; empty: none");
    visit(
        "environmentRotation", o.environmentRotation, Rotation{},
        "world from that map: quaternion x y z w, matrix of 9 (column-major), or radians about X, "
        "then Y, then Z");
    visit("mapBlur", o.mapBlur, Nested{},
          "Gaussian blur of the map that it reflects, stored or captured");
}

// Sets all fields of `from` that have a value. Removes the textures that would scale them; the mean
// of another factor in such a texture is multiplied into that factor.
void apply(const Scene& scene, const MaterialOverride& from, Material& to);

// Checks across fields: that something is selected, that names exist in the scene, that rotations
// are rotations. `pointer` is the JSON Pointer of the list.
std::vector<FieldError> problems(const Scene& scene, const std::vector<MaterialOverride>& overrides,
                                 const std::string& pointer = "/overrides");

// The variant's materials as the pose has them, then the overrides in order. Instances with the
// same material and the same overrides share one modified material. An override that selects
// nothing is no error, nor is a variant that the scene does not have.
MaterialBindings bindMaterials(const Scene& scene, const Pose& pose,
                               const std::vector<MaterialOverride>& overrides,
                               const std::optional<std::string>& variant = {});

// Applies the overrides to the scene itself.
void applyOverrides(Scene& scene, const std::vector<MaterialOverride>& overrides);

}  // namespace clerestory
