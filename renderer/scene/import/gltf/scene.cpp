// The node tree with its meshes, lights and cameras.
#include "scene/import/gltf/scene.h"

#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"
#include "scene/import/base/sidecar.h"
#include "scene/import/base/types.h"
#include "scene/import/gltf/parts.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

constexpr double kPi = std::numbers::pi;

glm::dmat4 composed(const glm::dvec3& translation, const glm::dvec4& xyzw,
                    const glm::dvec3& scale) {
    const double length = glm::length(xyzw);
    const glm::dvec4 q = length > 0.0 ? xyzw / length : glm::dvec4(0.0, 0.0, 0.0, 1.0);
    glm::dmat4 matrix = glm::mat4_cast(glm::dquat(q.w, q.x, q.y, q.z));
    for (int column = 0; column < 3; ++column) {
        matrix[column] *= scale[column];
    }
    matrix[3] = glm::dvec4(translation, 1.0);
    return matrix;
}

glm::dmat4 parentFromLocal(const Json& node) {
    const Json& list = array(node, "matrix");
    if (list.empty()) {
        return composed(numbers<3>(node, "translation", glm::dvec3(0.0)),
                        numbers<4>(node, "rotation", glm::dvec4(0.0, 0.0, 0.0, 1.0)),
                        numbers<3>(node, "scale", glm::dvec3(1.0)));
    }
    glm::dmat4 matrix(0.0);
    for (int i = 0; i < 16; ++i) {
        const auto index = static_cast<std::size_t>(i);
        if (list.size() != 16 || !list[index].is_number()) {
            malformed("\"matrix\" is not a list of 16 numbers");
        }
        matrix[i / 4][i % 4] = list[index].get<double>();
    }
    matrix[0].w = matrix[1].w = matrix[2].w = 0.0;  // glTF allows no perspective here
    matrix[3].w = 1.0;
    return matrix;
}

constexpr std::size_t kMaxVariants = 1024;
constexpr std::size_t kMaxScenes = 1024;

class GltfReader {
public:
    GltfReader(std::string file, const SceneFolder& folder, const ImportLimits& limits)
        : limits_(limits), document_(std::move(file), folder, limits), textures_(folder, limits) {}

    Scene run(const std::string& wanted, const ProgressCallback& progress) {
        checkVersionAndExtensions();
        chooseScene(wanted);
        GltfMaterials(document_, textures_, scene_).read();
        readVariants();
        report(progress, "meshes", 0.1);
        readNodes();
        animations_.readClips();
        findHiddenNodes();
        pose_ = restPose(scene_);
        GltfMeshes meshes(document_, scene_, limits_);
        for (const auto& [gltfNode, node] : visited_) {
            addContent(gltfNode, node, meshes);
        }
        animations_.placeTracks(lights_, cameras_);
        finishMotion(scene_);
        report(progress, "textures", 0.3);
        textures_.finish(scene_, progress);
        return std::move(scene_);
    }

private:
    static void report(const ProgressCallback& progress, const char* stage, double done) {
        if (progress) {
            progress({stage, done});
        }
    }

    void checkVersionAndExtensions() {
        const Json& asset = object(document_.json(), "asset");
        const std::string version = text(asset, "version"), least = text(asset, "minVersion");
        if (!version.empty() && !version.starts_with("2.")) {
            throw ImportError(Reason::unsupported,
                              "glTF " + cleanText(version) + " is not supported, only 2.0");
        }
        if (!least.empty() && least != "2.0") {
            throw ImportError(Reason::unsupported,
                              "the file requires glTF " + cleanText(least) + "; supported is 2.0");
        }
        const auto named = [&](const char* list, auto&& each) {
            for (const Json& name : array(document_.json(), list)) {
                if (name.is_string()) each(name.get<std::string>());
            }
        };
        named("extensionsRequired", [&](const std::string& name) {
            if (gltfSupport(name) == Support::refused) {
                throw ImportError(Reason::unsupported,
                                  "the file requires the glTF extension " + cleanText(name));
            }
        });
        named("extensionsUsed", [&](const std::string& name) {
            const Support support = gltfSupport(name);
            if (support == Support::ignored || support == Support::refused) {
                scene_.warnings.push_back(
                    {"unsupportedExtension", name, "this glTF extension is not supported"});
            }
        });
    }

    void readVariants() {
        const Json* list = extension(document_.json(), "KHR_materials_variants");
        if (!list) return;
        std::set<std::string> names;
        for (const Json& variant : array(*list, "variants")) {
            if (scene_.variants.size() >= kMaxVariants) {
                throw ImportError(Reason::limit, "the file has more than " +
                                                     std::to_string(kMaxVariants) + " variants");
            }
            const std::string name =
                uniqueName(names, text(variant, "name"), "variant", scene_.variants.size());
            scene_.variants.push_back({.name = name, .choices = {}});
        }
    }

    void chooseScene(const std::string& wanted) {
        const Json& json = document_.json();
        const Json& list = array(json, "scenes");
        if (list.size() > kMaxScenes) {
            throw ImportError(Reason::limit,
                              "the file has more than " + std::to_string(kMaxScenes) + " scenes");
        }
        std::set<std::string> names;
        std::vector<std::string> scenes;
        for (std::size_t i = 0; i < list.size(); ++i) {
            scenes.push_back(
                uniqueName(names, text(element(list, i, "scenes"), "name"), "scene", i));
        }
        std::size_t chosen = json.contains("scene") ? indexAt(json, "scene") : 0;
        if (!wanted.empty()) {
            chosen = scenes.size();
            for (std::size_t i = scenes.size(); i-- > 0;) {
                if (std::to_string(i) == wanted) chosen = i;
            }
            const auto named = std::find(scenes.begin(), scenes.end(), wanted);
            if (named != scenes.end()) chosen = static_cast<std::size_t>(named - scenes.begin());
            if (chosen == scenes.size()) throw noScene(wanted, scenes);
        }
        chosenScene_ = static_cast<Index>(chosen);
        if (scenes.size() < 2) return;
        scene_.scenesOfFile = std::move(scenes);
        scene_.sceneOfFile = chosenScene_;
    }

    static ImportError noScene(const std::string& wanted, const std::vector<std::string>& scenes) {
        std::string names;
        for (const std::string& name : scenes) names += (names.empty() ? "" : ", ") + name;
        return {Reason::notFound, cleanText("the file has no scene '" + wanted + "', but " +
                                            (names.empty() ? "one without a name" : names))};
    }

    // The root nodes of the scene; without a scene, all nodes without a parent.
    std::vector<Index> roots() const {
        const Json& json = document_.json();
        std::vector<Index> roots;
        if (array(json, "scenes").empty()) {
            const Json& nodes = array(json, "nodes");
            std::vector<bool> isChild(nodes.size(), false);
            for (std::size_t i = 0; i < nodes.size(); ++i) {
                for (const Index child : indexList(element(nodes, i, "nodes"), "children")) {
                    if (child < isChild.size()) isChild[child] = true;
                }
            }
            for (std::size_t i = 0; i < nodes.size(); ++i) {
                if (!isChild[i]) roots.push_back(static_cast<Index>(i));
            }
            return roots;
        }
        return indexList(document_.item("scenes", chosenScene_), "nodes");
    }

    // Depth first, parents before children. glTF nodes form trees: a node that is reached twice is
    // an error, which also rejects cycles and exponential graphs.
    void readNodes() {
        struct Visit {
            Index gltfNode;
            Index parent;
        };
        std::vector<Visit> pending;
        const auto push = [&](const std::vector<Index>& list, Index parent) {
            for (auto i = list.rbegin(); i != list.rend(); ++i) pending.push_back({*i, parent});
        };
        nodeOf_.assign(array(document_.json(), "nodes").size(), kNone);
        push(roots(), kNone);
        while (!pending.empty()) {
            const Visit visit = pending.back();
            pending.pop_back();
            const Json& json = document_.item("nodes", visit.gltfNode);
            if (nodeOf_[visit.gltfNode] != kNone) {
                malformed("node " + std::to_string(visit.gltfNode) +
                          " is reached twice; nodes must form a tree");
            }
            const Index node =
                addCheckedNode(text(json, "name"), parentFromLocal(json), visit.parent);
            nodeOf_[visit.gltfNode] = node;
            if (const Json* e = extension(json, "KHR_node_visibility")) {
                scene_.nodes[node].visible = flag(*e, "visible", true);
            }
            visited_.emplace_back(visit.gltfNode, node);
            push(indexList(json, "children"), node);
        }
    }

    // Nodes that are never visible: their meshes and lights are not read.
    void findHiddenNodes() {
        const std::vector<bool> changes = animations_.nodesThatHide();
        for (std::size_t i = 0; i < scene_.nodes.size(); ++i) {
            const Node& node = scene_.nodes[i];
            const bool shown = node.visible && (node.parent == kNone || shown_[node.parent]);
            shown_.push_back(shown);
            hidden_.push_back(!shown && !changes[i]);
        }
    }

    Index addCheckedNode(std::string name, const glm::dmat4& local, Index parent) {
        if (scene_.nodes.size() >= limits_.maxNodes) {
            throw ImportError(Reason::limit, "the scene has more than " +
                                                 std::to_string(limits_.maxNodes) + " nodes");
        }
        return addNode(scene_, std::move(name), local, parent);
    }

    void addContent(Index gltfNode, Index node, GltfMeshes& meshes) {
        const Json& json = document_.item("nodes", gltfNode);
        if (json.contains("extras")) readNodeExtras(json["extras"], node, scene_);
        if (const Index camera = indexAt(json, "camera"); camera != kNone) {
            addCamera(document_.item("cameras", camera), camera, node);
        }
        if (hidden_[node]) return;
        if (const Index mesh = indexAt(json, "mesh"); mesh != kNone) {
            addInstances(gltfNode, node, mesh, meshes);
        }
        if (const Json* e = extension(json, "KHR_lights_punctual")) {
            const Json* lights = extension(document_.json(), "KHR_lights_punctual");
            const Index light = indexAt(*e, "light");
            addLight(element(array(lights ? *lights : Json::object(), "lights"), light, "lights"),
                     light, node);
        }
    }

    void addInstances(Index gltfNode, Index node, Index mesh, GltfMeshes& meshes) {
        const Json& json = document_.item("nodes", gltfNode);
        const Json& gltfMesh = document_.item("meshes", mesh);
        MeshAnimation animation{.weights = animations_.weightsOf(gltfNode)};
        RestPose pose;
        const Json& weights =
            json.contains("weights") ? array(json, "weights") : array(gltfMesh, "weights");
        for (const Json& weight : weights) {
            if (animation.weights != kNone) break;
            pose.morphWeights.push_back(weight.is_number() ? weight.get<double>() : 0.0);
        }
        const bool morphed = std::any_of(pose.morphWeights.begin(), pose.morphWeights.end(),
                                         [](double weight) { return weight != 0.0; });
        const Index skin = indexAt(json, "skin");
        if (skin != kNone) {
            // A skinned mesh is placed by its joints and not by its node.
            const Json& skinJson = document_.item("skins", skin);
            const glm::dvec3 origin = originOf(json, skinJson);
            if (animations_.moves(skinJson) || animation.any())
                animation.skin = animations_.addSkin(skinJson);
            else
                pose.fromBind = fromBind(skinJson, origin);
            const bool shown = shown_[node];
            node = addCheckedNode(text(json, "name") + " (skinned)",
                                  glm::translate(glm::dmat4(1.0), origin), kNone);
            scene_.nodes[node].visible = shown;
        }
        const std::vector<Index> parts = animation.any()
                                             ? meshes.deformingMeshes(mesh, pose, animation)
                                         : skin != kNone || morphed ? meshes.posedMeshes(mesh, pose)
                                                                    : meshes.meshes(mesh);
        for (const Index copy : copies(json, node)) {
            for (const Index part : parts) {
                if (scene_.instances.size() >= 4 * limits_.maxNodes) {
                    throw ImportError(Reason::limit, "the scene has too many instances");
                }
                addInstance(scene_, copy, part);
            }
        }
    }

    // The nodes at which a mesh is drawn: its own, or those of EXT_mesh_gpu_instancing.
    std::vector<Index> copies(const Json& json, Index node) {
        const Json* instancing = extension(json, "EXT_mesh_gpu_instancing");
        if (!instancing) {
            return {node};
        }
        const Json& attributes = object(*instancing, "attributes");
        const auto read = [&](const char* key, std::size_t components) {
            const Index accessor = indexAt(attributes, key);
            Numbers numbers = accessor == kNone ? Numbers{} : document_.floats(accessor);
            if (accessor != kNone && numbers.components != components) {
                malformed("instancing attributes have the wrong type");
            }
            return numbers;
        };
        const Numbers translations = read("TRANSLATION", 3);
        const Numbers rotations = read("ROTATION", 4);
        const Numbers scales = read("SCALE", 3);
        std::vector<Index> nodes;
        const std::size_t count =
            std::max({translations.count(), rotations.count(), scales.count()});
        for (std::size_t i = 0; i < count; ++i) {
            const auto three = [&](const Numbers& from, double fallback) {
                return i < from.count() ? glm::dvec3(from.at(i)[0], from.at(i)[1], from.at(i)[2])
                                        : glm::dvec3(fallback);
            };
            const glm::dvec4 rotation = i < rotations.count()
                                            ? glm::dvec4(rotations.at(i)[0], rotations.at(i)[1],
                                                         rotations.at(i)[2], rotations.at(i)[3])
                                            : glm::dvec4(0.0, 0.0, 0.0, 1.0);
            nodes.push_back(addCheckedNode(
                "", composed(three(translations, 0.0), rotation, three(scales, 1.0)), node));
        }
        return nodes;
    }

    // The root position of a skinned mesh; 0 for an instanced mesh, whose instances are relative to
    // it.
    glm::dvec3 originOf(const Json& node, const Json& skin) {
        const std::vector<Index> joints = indexList(skin, "joints");
        if (extension(node, "EXT_mesh_gpu_instancing") || joints.empty()) return glm::dvec3(0.0);
        const Index first = joints.front();
        return skinOrigin(scene_, first < nodeOf_.size() ? nodeOf_[first] : kNone);
    }

    // The transform of every joint from the bind pose, relative to `origin`.
    std::vector<glm::dmat4> fromBind(const Json& json, const glm::dvec3& origin) {
        const GltfSkin skin = gltfSkin(document_, json, nodeOf_);
        std::vector<glm::dmat4> matrices;
        for (std::size_t i = 0; i < skin.joints.size(); ++i) {
            const Index node = skin.joints[i];
            glm::dmat4 world = node != kNone ? pose_.worldFromNode[node] : glm::dmat4(1.0);
            world[3] -= glm::dvec4(origin, 0.0);
            matrices.push_back(world * skin.jointFromMesh[i]);
        }
        return matrices;
    }

    void addCamera(const Json& json, Index gltfCamera, Index node) {
        Camera camera;
        camera.name = text(json, "name");
        if (camera.name.empty()) camera.name = scene_.nodes[node].name;
        camera.node = node;
        camera.orthographic = text(json, "type") == "orthographic";
        const Json& lens = object(json, camera.orthographic ? "orthographic" : "perspective");
        camera.znear = number(lens, "znear", 0.0);
        camera.zfar = number(lens, "zfar", 0.0);  // absent is infinite, and so is 0 here
        camera.yfov = number(lens, "yfov", camera.yfov);
        camera.yHalfHeight = std::abs(number(lens, "ymag", 1.0));
        const bool valid = camera.znear >= 0.0 &&
                           (camera.zfar == 0.0 || camera.zfar > camera.znear) &&
                           camera.yfov > 0.0 && camera.yfov < kPi && camera.yHalfHeight > 0.0;
        if (!valid) {
            scene_.warnings.push_back(
                {"badCamera", camera.name, "a camera with an empty view was ignored"});
            return;
        }
        cameras_.push_back({gltfCamera, static_cast<Index>(scene_.cameras.size())});
        scene_.cameras.push_back(camera);
    }

    void addLight(const Json& json, Index gltfLight, Index node) {
        Light light;
        light.name = text(json, "name");
        light.node = node;
        const std::string type = text(json, "type");
        light.kind = type == "directional" ? LightKind::directional
                     : type == "spot"      ? LightKind::spot
                                           : LightKind::point;
        const glm::vec3 color(numbers<3>(json, "color", glm::dvec3(1.0)));
        const float intensity = real(json, "intensity", 1.0f);
        light.intensity = glm::clamp(color * intensity, 0.0f, kMaxLightIntensity);
        light.range = std::max(real(json, "range", 0.0f), 0.0f);
        const Json& spot = object(json, "spot");
        light.outerConeAngle = std::clamp(real(spot, "outerConeAngle", light.outerConeAngle), 1e-3f,
                                          static_cast<float>(kPi / 2.0));
        light.innerConeAngle =
            std::clamp(real(spot, "innerConeAngle", 0.0f), 0.0f, light.outerConeAngle);
        if (json.contains("extras")) readLightExtras(json["extras"], light, scene_);
        const auto inRange = [](float v) { return std::clamp(v, 0.0f, kMaxLightIntensity); };
        lights_.push_back({gltfLight,
                           static_cast<Index>(scene_.lights.size()),
                           {.color = glm::clamp(color, 0.0f, kMaxLightIntensity),
                            .intensity = inRange(intensity),
                            .range = inRange(light.range),
                            .innerConeAngle = light.innerConeAngle,
                            .outerConeAngle = light.outerConeAngle}});
        scene_.lights.push_back(light);
    }

    ImportLimits limits_;
    GltfDocument document_;
    Index chosenScene_ = 0;
    TextureStore textures_;
    Scene scene_;
    std::vector<Index> nodeOf_;                     // by glTF node
    std::vector<std::pair<Index, Index>> visited_;  // glTF node, scene node
    GltfAnimations animations_{document_, scene_, nodeOf_};
    std::vector<bool> shown_, hidden_;  // by scene node: at rest; always
    std::vector<GltfAnimations::PlacedPart> lights_, cameras_;
    Pose pose_;
};

}  // namespace

Scene gltfScene(std::string file, const std::string& wanted, const SceneFolder& folder,
                const ImportLimits& limits, const ProgressCallback& progress) {
    return GltfReader(std::move(file), folder, limits).run(wanted, progress);
}

}  // namespace clerestory
