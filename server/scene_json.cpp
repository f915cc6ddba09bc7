#include "server/scene_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

// The double with the same shortest text, so that 0.9f is written 0.9.
double shortest(float value) {
    char text[32];
    const auto written = std::to_chars(text, text + sizeof text, value);
    double read = value;
    std::from_chars(text, written.ptr, read);
    return read;
}

ordered_json vector3(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}
ordered_json vector3(const glm::vec3& v) {
    return {shortest(v.x), shortest(v.y), shortest(v.z)};
}

// Where a material is used: surfaces (instances) and triangles as drawn.
struct Use {
    std::uint64_t surfaces = 0, triangles = 0;
};

std::vector<Use> usesOf(const Scene& scene) {
    std::vector<Use> uses(scene.materials.size());
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        uses[instance.material].surfaces += 1;
        uses[instance.material].triangles += mesh.triangles;
    }
    return uses;
}

bool emits(const Material& m) {
    const glm::vec3 radiance = emittedRadiance(m);
    return std::max({radiance.x, radiance.y, radiance.z}) > 0.0f;
}

// The surfaces of each material that `belongs`, with the words of `reason`.
template <class Belongs, class Describe>
ordered_json surfacesWhere(const Scene& scene, Belongs belongs, Describe describe) {
    ordered_json list = ordered_json::array();
    const std::vector<Use> uses = usesOf(scene);
    for (std::size_t i = 0; i < uses.size(); ++i) {
        const Material& m = scene.materials[i];
        if (uses[i].surfaces == 0 || !belongs(m)) continue;
        ordered_json entry = {
            {"material", m.name}, {"surfaces", uses[i].surfaces}, {"triangles", uses[i].triangles}};
        describe(m, entry);
        list.push_back(std::move(entry));
    }
    return list;
}

ordered_json emitters(const Scene& scene) {
    return surfacesWhere(scene, emits, [](const Material& m, ordered_json& entry) {
        const bool textured = m.emissiveTexture.present();
        entry["radiance"] = vector3(emittedRadiance(m));
        entry["reason"] = "emissive x emissiveStrength is above zero" +
                          std::string(textured ? "; its texture scales it" : "");
    });
}

ordered_json glass(const Scene& scene) {
    return surfacesWhere(
        scene, [](const Material& m) { return m.transmission > 0.0f; },
        [](const Material& m, ordered_json& entry) {
            entry["transmission"] = shortest(m.transmission);
            entry["ior"] = shortest(m.ior);
            entry["reason"] = "transmission is above zero";
            entry["drawnAs"] = "a plain surface; this version does not refract";
        });
}

ordered_json cameras(const Scene& scene, const Pose& pose) {
    ordered_json list = ordered_json::array();
    for (const Camera& camera : scene.cameras) {
        const glm::dmat4 world =
            camera.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[camera.node];
        ordered_json entry = {{"name", camera.name},
                              {"position", vector3(glm::dvec3(world[3]))},
                              {"direction", vector3(-glm::dvec3(world[2]))},
                              {"orthographic", camera.orthographic}};
        if (camera.orthographic) {
            entry["yHalfHeight"] = camera.yHalfHeight;
        } else {
            entry["yfov"] = camera.yfov;
        }
        if (camera.znear > 0.0) entry["znear"] = camera.znear;
        if (camera.zfar > 0.0) entry["zfar"] = camera.zfar;
        list.push_back(std::move(entry));
    }
    return list;
}

ordered_json lights(const Scene& scene, const Pose& pose) {
    const auto kindName = [](LightKind kind) {
        return kind == LightKind::point  ? "point"
               : kind == LightKind::spot ? "spot"
                                         : "directional";
    };
    ordered_json list = ordered_json::array();
    for (const Light& light : scene.lights) {
        const glm::dmat4 world =
            light.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[light.node];
        ordered_json entry = {{"name", light.name},
                              {"kind", kindName(light.kind)},
                              {"intensity", vector3(light.intensity)}};
        if (light.kind != LightKind::directional) {
            entry["position"] = vector3(glm::dvec3(world[3]));
            if (light.range > 0.0f) entry["range"] = shortest(light.range);
        }
        if (light.kind != LightKind::point) entry["direction"] = vector3(-glm::dvec3(world[2]));
        if (light.kind == LightKind::spot) {
            entry["innerConeAngle"] = shortest(light.innerConeAngle);
            entry["outerConeAngle"] = shortest(light.outerConeAngle);
        }
        list.push_back(std::move(entry));
    }
    return list;
}

ordered_json boundsJson(const Bounds& box) {
    if (box.empty()) return nullptr;
    return {{"min", vector3(box.min)}, {"max", vector3(box.max)}};
}

}  // namespace

ordered_json sceneSummary(const SceneStatus& status, bool isDefault) {
    ordered_json json = {{"id", status.id},
                         {"title", status.title},
                         {"default", isDefault},
                         {"state", nameOf(status.state)}};
    if (status.state == SceneState::loading) {
        json["stage"] = status.progress.stage;
        json["progress"] = status.progress.progress;
    }
    if (status.state == SceneState::failed) json["failure"] = status.failure;
    if (!status.scene) return json;
    const Scene& scene = *status.scene;
    json["triangles"] = triangleCount(scene);
    json["bounds"] = boundsJson(worldBounds(scene, poseAt(scene, 0.0)));
    auto& effects = json["effects"] = ordered_json::array();
    if (!emitters(scene).empty()) effects.push_back("emission");
    if (!glass(scene).empty()) effects.push_back("refraction");
    return json;
}

ordered_json sceneDetails(const SceneStatus& status, bool isDefault) {
    ordered_json json = sceneSummary(status, isDefault);
    if (!status.scene) return json;
    const Scene& scene = *status.scene;
    const Pose pose = poseAt(scene, 0.0);
    const DefaultView view = defaultView(scene);
    json["defaultView"] = {{"position", vector3(view.position)},
                           {"target", vector3(view.target)},
                           {"yfov", view.yfov}};
    json["environment"] = scene.environment;
    json["counts"] = {{"meshes", scene.meshes.size()},       {"materials", scene.materials.size()},
                      {"textures", scene.textures.size()},   {"images", scene.images.size()},
                      {"instances", scene.instances.size()}, {"clusters", scene.clusters.size()},
                      {"vertices", scene.vertices.size()}};
    json["cameras"] = cameras(scene, pose);
    json["lights"] = lights(scene, pose);
    json["emitters"] = emitters(scene);
    json["glass"] = glass(scene);
    auto& warnings = json["warnings"] = ordered_json::array();
    for (const ImportWarning& w : scene.warnings) {
        warnings.push_back(
            {{"code", w.code}, {"subject", w.subject}, {"message", w.message}, {"count", w.count}});
    }
    return json;
}

}  // namespace clerestory
