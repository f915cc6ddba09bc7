#include "server/api/scene_json.h"

#include "scene/classification.h"
#include "scene/default_view.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace clerestory {
namespace {

using nlohmann::ordered_json;

// The double with the same shortest decimal text, so that 0.9f is written as 0.9.
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

// Classifies all instances once; areas are in world space.
class Surfaces {
public:
    Surfaces(const Scene& scene, const Pose& pose)
        : scene_(scene), pose_(pose), all_(surfacesOf(scene)) {}

    // One entry for each emitter or glass instance, and one for each mirror.
    ordered_json emitters() const {
        return perInstance([](const Surface& s) { return s.emitter; },
                           [&](const Surface& s, ordered_json& entry) {
                               entry["radiance"] = vector3(emittedRadiance(material(s)));
                               entry["reason"] = emitterReason(scene_, {}, s);
                           });
    }
    ordered_json glass() const {
        return perInstance([](const Surface& s) { return s.glass != Glass::none; },
                           [&](const Surface& s, ordered_json& entry) {
                               entry["kind"] = s.glass == Glass::pane ? "pane" : "solid";
                               entry["transmission"] = shortest(material(s).transmission);
                               entry["ior"] = shortest(material(s).ior);
                               entry["reason"] = glassReason(scene_, {}, s);
                           });
    }
    ordered_json mirrors(Reflector kind) const {
        ordered_json list = ordered_json::array();
        for (const Surface& s : all_) {
            if (s.reflector != kind || list.size() == kMaxListed) continue;
            ordered_json entry = named(s, worldArea(s));
            if (s.flatPart != kNone) {
                const auto plane = transformed(scene_.flatParts[s.flatPart].plane(), world(s));
                if (plane) entry["normal"] = vector3(plane->normal);
            }
            entry["roughness"] = shortest(s.roughness);
            entry["reflectance"] = shortest(s.reflectance);
            entry["reason"] = reflectorReason(scene_, {}, s);
            list.push_back(std::move(entry));
        }
        return list;
    }
    ordered_json counts() const {
        std::uint64_t flat = 0, curved = 0, glowing = 0, clear = 0;
        Index last = kNone;
        for (const Surface& s : all_) {
            flat += s.reflector == Reflector::flat;
            curved += s.reflector == Reflector::curved;
            if (s.instance != last) {
                glowing += s.emitter;
                clear += s.glass != Glass::none;
            }
            last = s.instance;
        }
        return {{"emitters", glowing},
                {"glass", clear},
                {"flatMirrors", flat},
                {"curvedMirrors", curved}};
    }
    ordered_json effects() const {
        const auto any = [&](auto&& holds) { return std::any_of(all_.begin(), all_.end(), holds); };
        ordered_json list = ordered_json::array();
        if (any([](const Surface& s) { return s.emitter; })) list.push_back("emission");
        if (any([](const Surface& s) { return s.glass != Glass::none; })) {
            list.push_back("refraction");
        }
        if (any([](const Surface& s) { return s.reflector == Reflector::flat; })) {
            list.push_back("planarReflection");
        }
        if (any([](const Surface& s) { return s.reflector == Reflector::curved; })) {
            list.push_back("environmentReflection");
        }
        if (any([&](const Surface& s) { return hasLayers(material(s)); })) {
            list.push_back("materialLayers");
        }
        return list;
    }

private:
    static constexpr std::size_t kMaxListed = 500;  // of each kind; `counts` has the total

    const Material& material(const Surface& s) const { return scene_.materials[s.material]; }
    const glm::dmat4& world(const Surface& s) const {
        return pose_.worldFromNode[scene_.instances[s.instance].node];
    }

    // The area of a plane scales by the length of the cofactors times its normal; that of other
    // surfaces by the square of the mean scale, which is exact for uniform scaling.
    double worldArea(const Surface& s) const {
        const glm::dmat3 m(world(s));
        if (s.flatPart == kNone) {
            return s.area * std::cbrt(std::pow(std::abs(glm::determinant(m)), 2.0));
        }
        const glm::dvec3& n = scene_.flatParts[s.flatPart].normal;
        return s.area * glm::length(n.x * glm::cross(m[1], m[2]) + n.y * glm::cross(m[2], m[0]) +
                                    n.z * glm::cross(m[0], m[1]));
    }

    ordered_json named(const Surface& s, double area) const {
        const Instance& instance = scene_.instances[s.instance];
        return {{"objectId", s.instance + 1},
                {"node", scene_.nodes[instance.node].name},
                {"mesh", scene_.meshes[instance.mesh].name},
                {"material", material(s).name},
                {"area", area}};
    }

    // All surfaces of an instance have the same emission and transmission.
    template <class Belongs, class Describe>
    ordered_json perInstance(Belongs belongs, Describe describe) const {
        ordered_json list = ordered_json::array();
        for (std::size_t i = 0; i < all_.size() && list.size() < kMaxListed;) {
            const Surface& first = all_[i];
            double area = 0.0;
            for (; i < all_.size() && all_[i].instance == first.instance; ++i) {
                area += worldArea(all_[i]);
            }
            if (!belongs(first)) continue;
            ordered_json entry = named(first, area);
            describe(first, entry);
            list.push_back(std::move(entry));
        }
        return list;
    }

    const Scene& scene_;
    const Pose& pose_;
    std::vector<Surface> all_;
};

ordered_json probes(const Scene& scene, const Pose& pose) {
    ordered_json list = ordered_json::array();
    for (const Probe& probe : scene.probes) {
        const glm::dmat4 world =
            probe.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[probe.node];
        ordered_json entry = {
            {"name", probe.name},
            {"position", vector3(glm::dvec3(world * glm::dvec4(probe.position, 1.0)))},
            {"size", probe.size}};
        if (probe.node != kNone) entry["node"] = scene.nodes[probe.node].name;
        if (probe.resolution > 0) entry["resolution"] = probe.resolution;
        if (probe.zfar > 0.0) entry["zfar"] = probe.zfar;
        if (probe.blur.changes()) {
            entry["blur"] = {{"size", probe.blur.size}, {"stdev", probe.blur.stdev}};
        }
        list.push_back(std::move(entry));
    }
    return list;
}

ordered_json animations(const Scene& scene) {
    const std::vector<Index> playing = defaultClips(scene);
    ordered_json list = ordered_json::array();
    for (Index i = 0; i < scene.clips.size(); ++i) {
        const bool plays = std::find(playing.begin(), playing.end(), i) != playing.end();
        list.push_back({{"name", scene.clips[i].name},
                        {"duration", scene.clips[i].duration},
                        {"default", plays}});
    }
    return list;
}

// Of a camera or a light, which look along -Z: unit, whatever the scale of its node.
glm::dvec3 directionOf(const glm::dmat4& world) {
    const glm::dvec3 back(world[2]);
    const double length = glm::length(back);
    return length > 0.0 ? back / -length : glm::dvec3(0, 0, -1);
}

ordered_json cameras(const Scene& scene, const Pose& pose) {
    ordered_json list = ordered_json::array();
    for (const Camera& camera : scene.cameras) {
        const glm::dmat4 world =
            camera.node == kNone ? glm::dmat4(1.0) : pose.worldFromNode[camera.node];
        ordered_json entry = {{"name", camera.name},
                              {"position", vector3(glm::dvec3(world[3]))},
                              {"direction", vector3(directionOf(world))},
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
        if (light.kind != LightKind::point) entry["direction"] = vector3(directionOf(world));
        if (light.kind == LightKind::spot) {
            entry["innerConeAngle"] = shortest(light.innerConeAngle);
            entry["outerConeAngle"] = shortest(light.outerConeAngle);
        }
        if (light.radius > 0.0f) entry["radius"] = shortest(light.radius);
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
    if (status.uploaded) json["uploaded"] = true;
    if (status.state == SceneState::failed) {
        json["failure"] = status.failure;
        json["reason"] = status.reason;
    }
    if (!status.scene) return json;
    const Scene& scene = *status.scene;
    json["triangles"] = triangleCount(scene);
    json["lines"] = primitiveCount(scene, Primitive::lines);
    json["points"] = primitiveCount(scene, Primitive::points);
    const Pose pose = poseAt(scene, 0.0);
    json["bounds"] = boundsJson(lastingBounds(scene, pose));
    json["effects"] = Surfaces(scene, pose).effects();
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
    const glm::dquat& turn = scene.environmentRotation;
    json["environmentRotation"] = {turn.x, turn.y, turn.z, turn.w};
    json["counts"] = {{"meshes", scene.meshes.size()},       {"materials", scene.materials.size()},
                      {"textures", scene.textures.size()},   {"images", scene.images.size()},
                      {"instances", scene.instances.size()}, {"clusters", scene.clusters.size()},
                      {"vertices", status.vertices}};
    json["memory"] = {{"meshes", status.bytes.meshes},
                      {"textures", status.bytes.textures},
                      {"maps", status.bytes.maps},
                      {"total", status.bytes.total()}};
    json["animations"] = animations(scene);
    auto& scenes = json["scenes"] = ordered_json::array();
    if (status.scenesOfFile) {
        for (const SceneOfFile& each : *status.scenesOfFile) {
            scenes.push_back({{"id", each.id}, {"name", each.name}});
        }
    }
    auto& materials = json["materials"] = ordered_json::array();
    for (const Material& material : scene.materials) materials.push_back(material.name);
    auto& variants = json["variants"] = ordered_json::array();
    for (const Variant& variant : scene.variants) variants.push_back(variant.name);
    json["cameras"] = cameras(scene, pose);
    json["lights"] = lights(scene, pose);
    const Surfaces surfaces(scene, pose);
    json["counts"].update(surfaces.counts());
    json["emitters"] = surfaces.emitters();
    json["glass"] = surfaces.glass();
    json["flatMirrors"] = surfaces.mirrors(Reflector::flat);
    json["curvedMirrors"] = surfaces.mirrors(Reflector::curved);
    json["probes"] = probes(scene, pose);
    auto& warnings = json["warnings"] = ordered_json::array();
    for (const ImportWarning& w : scene.warnings) {
        warnings.push_back(
            {{"code", w.code}, {"subject", w.subject}, {"message", w.message}, {"count", w.count}});
    }
    return json;
}

}  // namespace clerestory
