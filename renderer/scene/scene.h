// The scene: meshes, materials, lights, cameras, animations. A plain value whose parts refer to
// each other by index; fixed after loading. poseAt() returns its state at a time. Metres, radians,
// seconds, linear colours; right-handed, +Y up, cameras and lights point along their own -Z
// (glTF 2.0).
//
// Does not: read files (scene/import), decide what is drawn (plan), use OpenGL.
#pragma once

#include "scene/animation.h"
#include "scene/geometry.h"
#include "scene/material.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace clerestory {

// What the indices of a mesh form; the value is their number for each. Lines and points are as wide
// as a request says (FrameRequest::pointSize). They are drawn in views, and rays do not meet them:
// they are neither mirrors nor glass, and cast neither shadows nor light.
enum class Primitive : std::uint8_t { points = 1, lines = 2, triangles = 3 };
constexpr std::uint32_t indicesPer(Primitive primitive) {
    return static_cast<std::uint32_t>(primitive);
}

// At most kClusterPrimitives that are close together, so that culling and early depth tests work on
// large meshes too. The clusters of a mesh are contiguous in Scene::indices.
inline constexpr std::uint32_t kClusterPrimitives = 2048;
struct Cluster {
    std::uint32_t firstIndex = 0;  // of triangles: a multiple of 3, as rays number them
    std::uint32_t indexCount = 0;  // a multiple of indicesPer()
    Bounds bounds;                 // mesh space
};

// Triangles of a mesh that lie in one plane and face the same way, with enough area for a mirror.
// They need not be connected. Their clusters are contiguous and contain no other triangles, so that
// the part can be drawn or skipped alone. Found for every mesh, because a request may assign any
// material.
struct FlatPart {
    std::uint32_t firstCluster = 0;
    std::uint32_t clusterCount = 0;
    glm::dvec3 normal{0.0, 0.0, 1.0};  // mesh space, unit; from its side the triangles are
                                       // counter-clockwise
    double offset = 0.0;               // normal . x + offset = 0
    double area = 0.0;                 // mesh space, square metres
    Bounds bounds;                     // mesh space

    Plane plane() const { return {normal, offset}; }
};

struct Mesh {
    std::string name;
    std::uint32_t firstCluster = 0;
    std::uint32_t clusterCount = 0;
    std::uint32_t firstFlatPart = 0;  // in Scene::flatParts, largest first; the mesh's first
    std::uint32_t flatPartCount = 0;  // clusters are theirs, in the same order
    Primitive primitive = Primitive::triangles;
    bool lit = true;               // false: lines or points without normals
    std::uint32_t primitives = 0;  // their number
    double area = 0.0;             // mesh space, square metres
    Index material = 0;            // of instances that have no material of their own
    Bounds bounds;                 // mesh space; of a deforming mesh: at rest
    bool hasColors = false;        // a vertex colour is not white
    Index deformation = kNone;     // in Scene::deformations
};

// A node's parent precedes it in Scene::nodes.
struct Node {
    std::string name;
    Index parent = kNone;
    glm::dmat4 parentFromLocal{1.0};
    bool visible = true;  // false: its instances and lights, and all below it, are not drawn
};

// One mesh drawn at one node with one material. Its index in Scene::instances, plus 1, is its
// objectId. See addInstance().
struct Instance {
    Index node = 0;
    Index mesh = 0;
    Index material = 0;
};

// A named position from which the surroundings are captured, for materials that refer to it
// (Material::probe). Six images are drawn from the centre of a cube.
struct Probe {
    std::string name;
    Index node = kNone;            // moves with it
    glm::dvec3 position{0.0};      // of the cube's centre, in the node's or world space
    double size = 1.0;             // edge of the cube, metres; half of it is the near distance
    std::uint32_t resolution = 0;  // edge of a face, texels; 0: as the request says
    double zfar = 0.0;             // metres; 0: infinite
    MapBlur blur;                  // unless the material has one
};

enum class LightKind : std::uint32_t { point, spot, directional };

struct Light {
    std::string name;
    Index node = kNone;
    LightKind kind = LightKind::point;
    // point and spot: luminous intensity per steradian; directional: irradiance. Linear RGB.
    glm::vec3 intensity{1.0f};
    float range = 0.0f;           // metres; 0 is unlimited
    float innerConeAngle = 0.0f;  // radians from the axis; spot only
    float outerConeAngle = 0.785398163f;
    // Of the sphere that shines, metres; directional: at a distance of one metre. 0 is a point.
    float radius = 0.0f;
    // Instead of the node's; the direction that its light takes, unit. Of a request's lights only.
    std::optional<glm::dvec3> worldPosition, worldDirection;
};

struct Camera {
    std::string name;
    Index node = kNone;
    bool orthographic = false;
    double yfov = 0.9;         // radians, whole vertical angle
    double yHalfHeight = 1.0;  // metres; orthographic only (glTF ymag)
    double znear = 0.0;        // 0: chosen from the scene's bounds
    double zfar = 0.0;         // 0: infinite
};

// The factors of a camera that clips may change.
template <class C, class V>
requires std::same_as<std::remove_const_t<C>, Camera>
void fields(C& c, V&& visit) {
    visit("yfov", c.yfov, FactorRange{1e-6f, 3.14f, 0.9f});
    visit("yHalfHeight", c.yHalfHeight, FactorRange{1e-9f, 1e9f, 1});
    visit("znear", c.znear, FactorRange{0, 1e9f, 0});
    visit("zfar", c.zfar, FactorRange{0, 1e9f, 0});
}

struct DefaultView {
    glm::dvec3 position{0.0, 0.0, 1.0};
    glm::dvec3 target{0.0};
    double yfov = 0.9;
    // Tangents of half the angles, right and up, that the surfaces fill; 0: the view of a camera,
    // whose yfov holds for frames of every shape. See fieldOfView().
    glm::dvec2 fit{0.0};
};

// A named choice of materials for some of the meshes (KHR_materials_variants): requests select one.
struct Variant {
    struct Choice {
        Index mesh = 0;
        Index material = 0;
    };
    std::string name;             // not empty, unique in the scene
    std::vector<Choice> choices;  // at most one for each mesh; the others keep their materials
};

// A repair or an omission by the importer, for the author of the file.
struct ImportWarning {
    std::string code;     // stable, camelCase: "degenerateTriangles", "missingTexture"
    std::string subject;  // the mesh, material, texture or node; may be empty
    std::string message;
    std::uint64_t count = 1;
};

struct Scene {
    std::string id;
    std::string title;
    std::vector<std::string> scenesOfFile;  // names, if its file has several scenes; unique
    Index sceneOfFile = 0;                  // which of them this is
    std::uint64_t contentHash = 0;          // of everything that can change an image

    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;  // absolute into vertices
    std::vector<Cluster> clusters;
    std::vector<FlatPart> flatParts;
    std::vector<Mesh> meshes;
    std::vector<Material> materials;
    std::vector<Variant> variants;
    std::vector<TextureImage> images;
    std::vector<Texture> textures;
    std::vector<Node> nodes;
    std::vector<Instance> instances;
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    std::vector<Probe> probes;
    std::vector<Clip> clips;
    std::vector<MovingNode> movingNodes;
    std::vector<MorphWeights> morphWeights;
    std::vector<AnimatedLight> animatedLights;
    std::vector<Skin> skins;
    std::vector<Deformation> deformations;
    // The instance of a ground plane that a request adds (scene/ground.h); it counts for no bounds.
    Index ground = kNone;
    bool shadowCatcher = false;  // the ground shows only what the scene changes on it
    Bounds reach;        // world; of everything, at any time, if clips move it; see finishMotion()
    Bounds motionReach;  // likewise of the instances that clips move
    std::optional<DefaultView> defaultView;
    std::string environment = "sky";                     // the map of requests that name none
    glm::dquat environmentRotation{1.0, 0.0, 0.0, 0.0};  // world from map, likewise; unit
    std::vector<ImportWarning> warnings;
};

// A material with the factors that a clip gives it.
struct PosedMaterial {
    Index material = 0;  // in Scene::materials
    Material value;
};

// The scene at one time.
struct Pose {
    std::vector<glm::dmat4> worldFromNode;
    // Parallel to Scene::deformations; shared, because poses are copied. Empty if nothing deforms.
    std::vector<std::shared_ptr<const DeformedMesh>> deformed;
    std::vector<bool> hidden;              // instances that are not drawn; empty: none
    std::vector<PosedMaterial> materials;  // ascending; others are those of the scene
    std::vector<Light> lights;             // empty: those of the scene
    std::vector<Camera> cameras;           // likewise
};
inline const std::vector<Light>& lightsOf(const Scene& scene, const Pose& pose) {
    return pose.lights.empty() ? scene.lights : pose.lights;
}
inline const std::vector<Camera>& camerasOf(const Scene& scene, const Pose& pose) {
    return pose.cameras.empty() ? scene.cameras : pose.cameras;
}

// Whether all surfaces are at the same place.
bool haveSameShape(const Pose& a, const Pose& b);

// As in the file: no clip is played.
Pose restPose(const Scene& scene);
// With the clips played in order, each from its own start (localTime()). time: seconds. If a clip
// moves something out of range (inReach()), the rest pose.
Pose poseAt(const Scene& scene, std::span<const Index> clips, double time);
// With defaultClips() played.
Pose poseAt(const Scene& scene, double time);

// The first clip, and each later clip that animates no target of an earlier one: the first of
// several walk cycles, but every part of a machine.
std::vector<Index> defaultClips(const Scene& scene);
// The clip with that name, no clip for the empty name, defaultClips() without a name. Nothing if
// the scene has no such clip.
std::optional<std::vector<Index>> clipsNamed(const Scene& scene,
                                             const std::optional<std::string>& name);

// World from light: it is at the origin and points along its own -Z.
glm::dmat4 placeOf(const Light& light, const Pose& pose);

// For each node whether it or an ancestor has the name, which may be a pattern
// (scene/name_pattern.h).
std::vector<bool> nodesAtOrBelow(const Scene& scene, const std::string& name);

// For each node whether a clip moves or hides it; for each instance whether its node does so or its
// mesh deforms.
std::vector<bool> nodesThatMove(const Scene& scene);
std::vector<bool> instancesThatMove(const Scene& scene);
// For each instance whether it moves or a clip changes its material.
std::vector<bool> instancesThatChange(const Scene& scene);

// Sets vertices, bounds and areas of deforming meshes to the rest pose, and Scene::reach from
// samples of every clip. The last step in making a scene with clips.
void finishMotion(Scene& scene);

// A mesh's vertices at one time, indexed by the values in Scene::indices.
class MeshVertices {
public:
    MeshVertices(std::span<const Vertex> vertices, std::uint32_t first)
        : vertices_(vertices), first_(first) {}
    const Vertex& operator[](std::uint32_t index) const { return vertices_[index - first_]; }

private:
    std::span<const Vertex> vertices_;
    std::uint32_t first_;
};
MeshVertices verticesOf(const Scene& scene, const Pose& pose, const Mesh& mesh);
// Mesh space. `cluster` counts from 0 within the mesh.
const Bounds& boundsOf(const Pose& pose, const Mesh& mesh);
const Bounds& boundsOf(const Scene& scene, const Pose& pose, const Mesh& mesh,
                       std::uint32_t cluster);
// Null for a mesh that does not deform.
const DeformedMesh* deformedMesh(const Pose& pose, const Mesh& mesh);

// World bounds of all instances in this pose; empty for an empty scene.
Bounds worldBounds(const Scene& scene, const Pose& pose);
Bounds boundsOfInstance(const Scene& scene, const Pose& pose, Index instance);  // world
// The same over all times and without the ground, for lengths that are relative to the scene and
// must not change with time.
Bounds lastingBounds(const Scene& scene, const Pose& pose);

// Sum over all instances.
std::uint64_t primitiveCount(const Scene& scene, Primitive primitive);
inline std::uint64_t triangleCount(const Scene& scene) {
    return primitiveCount(scene, Primitive::triangles);
}

// Checks that every index is in range, every number is finite and every count is consistent.
// Returns the problems, at most a few dozen; empty for a valid scene. Never throws, never reads out
// of range.
std::vector<std::string> sceneProblems(const Scene& scene);

// Computes contentHash from all other members.
void updateContentHash(Scene& scene);
// Of all fields of the material's table.
std::uint64_t contentHash(const Material& material);

// Whether the instance is a ground that catches shadows.
inline bool isShadowCatcher(const Scene& scene, Index instance) {
    return scene.shadowCatcher && instance == scene.ground;
}

// The material of every instance in one frame: the scene's materials, and modified copies where a
// clip changes them or a request overrides them. A material index below scene.materials.size()
// refers to Scene::materials, others to `own` after subtracting that size. The scene's materials
// are uploaded once, `own` for each frame. Empty lists mean that nothing is changed.
struct MaterialBindings {
    std::vector<Material> own;
    std::vector<Index> materialOfInstance;  // empty: those of the scene
    std::vector<bool> hidden;               // instances that are not drawn; empty: none

    bool draws(Index instance) const { return hidden.empty() || !hidden[instance]; }

    Index materialOf(const Scene& scene, Index instance) const {
        return materialOfInstance.empty() ? scene.instances[instance].material
                                          : materialOfInstance[instance];
    }
    const Material& material(const Scene& scene, Index index) const {
        return index < scene.materials.size() ? scene.materials[index]
                                              : own[index - scene.materials.size()];
    }
};

}  // namespace clerestory
