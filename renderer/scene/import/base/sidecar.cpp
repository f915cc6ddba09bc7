#include "scene/import/base/sidecar.h"

#include "scene/import/base/field_reader.h"
#include "scene/import/base/types.h"
#include "scene/light_override.h"
#include "scene/material_override.h"
#include "scene/mesh_builder.h"

#include <algorithm>
#include <filesystem>

namespace clerestory {
namespace {

struct ProbeFields {
    std::string name;
    std::optional<std::string> node;
    glm::dvec3 position{0.0};
    double size = 1.0;
    std::uint32_t resolution = 0;
    double zfar = 0.0;
    MapBlur blur;
};

template <class V>
void fields(ProbeFields& p, V&& visit) {
    visit("name", p.name, Text{128}, "unique name, for materials");
    visit("node", p.node, Text{256}, "parent node; none: the world");
    visit("position", p.position, Range{-1e9, 1e9},
          "of the cube's centre, in the node's space, metres");
    visit("size", p.size, Range{1e-9, 1e9},
          "edge of the cube, metres; half of it is the near distance");
    visit("resolution", p.resolution, Range{0, 4096},
          "edge of a face, texels; 0: as in the request");
    visit("zfar", p.zfar, Range{0, 1e12}, "far distance, metres; 0: infinite");
    visit("blur", p.blur, Nested{}, "Gaussian blur of the captured map");
}

struct EnvironmentFields {
    std::optional<std::string> map;
    std::optional<Quaternion> rotation;
};

template <class V>
void fields(EnvironmentFields& e, V&& visit) {
    visit("map", e.map, Text{128}, "environment map of requests that name none");
    visit("rotation", e.rotation, Rotation{}, "world from map, unless a request has another");
}

struct Sidecar {
    std::vector<MaterialOverride> overrides;
    std::vector<LightOverride> lights;
    std::vector<ProbeFields> probes;
    EnvironmentFields environment;
};

template <class V>
void fields(Sidecar& s, V&& visit) {
    visit("overrides", s.overrides, NestedList{1000}, "material overrides, as in a request");
    visit("lights", s.lights, NestedList{1000}, "changes of lights, as in a request");
    visit("probes", s.probes, NestedList{100}, "probes");
    visit("environment", s.environment, Nested{}, "default environment");
}

// The fields that are allowed in a glTF material's extras.
struct MaterialExtras {
    MaterialOverride fields;
};

template <class V>
void fields(MaterialExtras& n, V&& visit) {
    fields(n.fields, [&](const char* name, auto& member, const auto& kind, const char* words) {
        const std::string_view word = name;
        if (word == "reflection" || word == "probe" || word == "environmentMap" ||
            word == "environmentRotation" || word == "mapBlur") {
            visit(name, member, kind, words);
        }
    });
}

void warn(Scene& scene, const char* code, const std::string& location,
          const std::vector<FieldError>& errors) {
    for (const FieldError& e : errors) {
        const std::string allowed = e.allowed.empty() ? "" : "; allowed: " + e.allowed;
        scene.warnings.push_back({code, location + e.pointer, e.detail + allowed});
    }
}

void addProbe(Scene& scene, const ProbeFields& from, Index node, const char* code,
              const std::string& location) {
    const auto refuse = [&](const char* what) { scene.warnings.push_back({code, location, what}); };
    if (from.name.empty()) return refuse("a probe without a name was ignored");
    for (const Probe& probe : scene.probes) {
        if (probe.name == from.name) return refuse("a second probe of the same name was ignored");
    }
    if (from.node) {
        const auto found = std::find_if(scene.nodes.begin(), scene.nodes.end(),
                                        [&](const Node& n) { return n.name == *from.node; });
        if (found == scene.nodes.end()) return refuse("its node is not in the scene");
        node = static_cast<Index>(found - scene.nodes.begin());
    }
    scene.probes.push_back({.name = from.name,
                            .node = node,
                            .position = from.position,
                            .size = from.size,
                            .resolution = from.resolution,
                            .zfar = from.zfar,
                            .blur = from.blur});
}

constexpr const char* kSidecarCode = "sideFile";
constexpr const char* kExtrasCode = "badExtras";

}  // namespace

std::string sidecarName(const std::string& modelName) {
    return std::filesystem::path(modelName).stem().string() + ".clerestory.json";
}

bool applySidecar(Scene& scene, const SceneFolder& folder, const std::string& modelName) {
    const std::string name = sidecarName(modelName);
    if (!folder.has(name)) return false;
    Json json;
    try {
        json = parsedFile(folder.read(name));
    } catch (const ImportError& error) {
        scene.warnings.push_back({kSidecarCode, name, error.what()});
        return true;
    }
    Sidecar sidecar;
    std::vector<FieldError> errors;
    FieldReader(errors).object(json, sidecar, "");
    for (std::size_t i = 0; i < sidecar.probes.size(); ++i) {
        addProbe(scene, sidecar.probes[i], kNone, kSidecarCode,
                 name + "/probes/" + std::to_string(i));
    }
    // An override with an unknown name selects nothing; an invalid rotation or probe is removed.
    for (const FieldError& e : problems(scene, sidecar.overrides)) errors.push_back(e);
    for (MaterialOverride& o : sidecar.overrides) {
        const auto wrong = problems(scene, {o}, "");
        const auto names = [&](const char* field) {
            return std::any_of(wrong.begin(), wrong.end(), [&](const FieldError& e) {
                return e.pointer == "/0/" + std::string(field);
            });
        };
        if (names("environmentRotation")) o.environmentRotation.reset();
        if (names("probe")) o.probe.reset();
    }
    if (sidecar.environment.map) scene.environment = *sidecar.environment.map;
    if (const auto& q = sidecar.environment.rotation) {
        scene.environmentRotation = glm::normalize(glm::dquat((*q)[3], (*q)[0], (*q)[1], (*q)[2]));
    }
    for (const FieldError& e : problems(scene, sidecar.lights)) errors.push_back(e);
    warn(scene, kSidecarCode, name, errors);
    applyOverrides(scene, sidecar.overrides);
    scene.lights = lightsWith(scene.lights, sidecar.lights);
    // Lights of a scene have the place of their node.
    for (Light& light : scene.lights) {
        if (!light.worldPosition && !light.worldDirection) continue;
        light.node = addNode(scene, light.name, placeOf(light, restPose(scene)));
        light.worldPosition = light.worldDirection = std::nullopt;
    }
    return true;
}

void readMaterialExtras(const Json& extras, Material& material, Scene& scene) {
    if (!extras.is_object()) return;
    Json known = Json::object();  // other programs use extras, too
    MaterialExtras extrasFields;
    fields(extrasFields, [&](const char* name, auto&, const auto&, const char*) {
        if (const auto found = extras.find(name); found != extras.end()) known[name] = *found;
    });
    std::vector<FieldError> errors;
    FieldReader(errors).object(known, extrasFields, "");
    extrasFields.fields.material = material.name;  // selects this material
    for (const FieldError& e : problems(Scene{}, {extrasFields.fields}, "")) {
        if (e.pointer == "/0/environmentRotation") {
            errors.push_back({"/environmentRotation", e.detail, e.allowed});
            extrasFields.fields.environmentRotation.reset();
        }
    }
    warn(scene, kExtrasCode, material.name, errors);
    apply(scene, extrasFields.fields, material);
}

void readLightExtras(const Json& extras, Light& light, Scene& scene) {
    if (!extras.is_object() || !extras.contains("radius")) return;
    LightOverride radius;
    std::vector<FieldError> errors;
    FieldReader(errors).object(Json{{"radius", extras["radius"]}}, radius, "");
    warn(scene, kExtrasCode, light.name, errors);
    light.radius = static_cast<float>(radius.radius.value_or(0.0));
}

void readNodeExtras(const Json& extras, Index node, Scene& scene) {
    if (!extras.is_object()) return;
    const auto found = extras.find("probe");
    if (found == extras.end() || !found->is_object()) return;
    ProbeFields probe{.name = scene.nodes[node].name};
    std::vector<FieldError> errors;
    FieldReader(errors).object(*found, probe, "/probe");
    const std::string location = scene.nodes[node].name;
    probe.node.reset();  // it is attached to the node that contains it
    warn(scene, kExtrasCode, location, errors);
    addProbe(scene, probe, node, kExtrasCode, location);
}

bool dropUnknownProbes(Scene& scene) {
    bool dropped = false;
    for (Material& m : scene.materials) {
        const bool known =
            m.probe.empty() || std::any_of(scene.probes.begin(), scene.probes.end(),
                                           [&](const Probe& p) { return p.name == m.probe; });
        if (known) continue;
        scene.warnings.push_back({"unknownProbe", m.name, "there is no probe '" + m.probe + "'"});
        m.probe.clear();
        dropped = true;
    }
    return dropped;
}

}  // namespace clerestory
