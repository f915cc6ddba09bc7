// What exists: meshes, materials, lights, cameras. A plain value of indices, fixed after loading;
// poseAt(scene, ...) gives a moment of it. Metres, radians, seconds, linear colours; right-handed,
// +Y up, cameras and lights look down their own -Z (glTF 2.0).
//
// Does not: read files (scene/import), decide what is drawn (plan), know OpenGL.
#pragma once

#include "scene/animation/clip.h"
#include "scene/animation/deformation.h"
#include "scene/bounds.h"
#include "scene/material.h"
#include "scene/plane.h"
#include "scene/vertex.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace clerestory {

// At most kClusterTriangles triangles that lie together in space, so that culling and early depth
// tests work on large meshes too. Clusters of one mesh follow each other in Scene::indices.
inline constexpr std::uint32_t kClusterTriangles = 2048;
struct Cluster {
    std::uint32_t firstIndex = 0;
    std::uint32_t indexCount = 0;  // a multiple of 3
    Bounds bounds;                 // mesh space
};

// The triangles of a mesh that lie in one plane and face one way, together large enough to be worth
// a mirror. They need not touch. Their clusters follow each other and hold nothing else, so that
// the part can be drawn, or left out, alone. Found for every mesh: a request may give it any
// material.
struct FlatPart {
    std::uint32_t firstCluster = 0;
    std::uint32_t clusterCount = 0;
    glm::dvec3 normal{0.0, 0.0, 1.0};  // mesh space, unit; the side that sees them wound
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
    std::uint32_t firstFlatPart = 0;  // in Scene::flatParts, largest first; their clusters are the
    std::uint32_t flatPartCount = 0;  // mesh's first, in the same order
    std::uint32_t triangles = 0;
    double area = 0.0;          // mesh space, square metres
    Index material = 0;         // what its instances have unless they are given another
    Bounds bounds;              // mesh space; of a deforming mesh: at rest
    bool hasColors = false;     // some vertex colour is not white
    Index deformation = kNone;  // in Scene::deformations
};

// A node's parent stands before it in Scene::nodes.
struct Node {
    std::string name;
    Index parent = kNone;
    glm::dmat4 parentFromLocal{1.0};
};

// One mesh drawn at one node in one material. Its place in Scene::instances, plus 1, is its
// objectId. Made by addInstance().
struct Instance {
    Index node = 0;
    Index mesh = 0;
    Index material = 0;
};

// A named place to catch the surroundings from, for materials that refer to it (Material::probe):
// an imaginary cube from whose middle six pictures are drawn.
struct Probe {
    std::string name;
    Index node = kNone;            // moves with it
    glm::dvec3 position{0.0};      // the cube's middle, in the node's space, else the world's
    double size = 1.0;             // edge of the cube, metres; half of it is the near distance
    std::uint32_t resolution = 0;  // edge of a face, texels; 0: as the request's accuracy has it
    double zfar = 0.0;             // metres; 0: infinite
    MapBlur blur;                  // unless a material asks for another
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

struct DefaultView {
    glm::dvec3 position{0.0, 0.0, 1.0};
    glm::dvec3 target{0.0};
    double yfov = 0.9;
};

// Something the loader mended or dropped, in words for the person who made the file.
struct ImportWarning {
    std::string code;     // stable, camelCase: "degenerateTriangles", "missingTexture"
    std::string subject;  // the mesh, material, texture or node it is about; may be empty
    std::string message;
    std::uint64_t count = 1;
};

struct Scene {
    std::string id;
    std::string title;
    std::uint64_t contentHash = 0;  // of everything that can change a picture

    std::vector<Vertex> vertices;
    std::vector<std::uint32_t> indices;  // absolute into vertices
    std::vector<Cluster> clusters;
    std::vector<FlatPart> flatParts;
    std::vector<Mesh> meshes;
    std::vector<Material> materials;
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
    std::vector<Skin> skins;
    std::vector<Deformation> deformations;
    Bounds reach;  // world; of everything that moves, wherever clips put it; see finishMotion()
    std::optional<DefaultView> defaultView;
    std::string environment = "sky";                     // the map used when a request names none
    glm::dquat environmentRotation{1.0, 0.0, 0.0, 0.0};  // world from map, likewise; unit
    std::vector<ImportWarning> warnings;
};

// Where everything is at one moment.
struct Pose {
    std::vector<glm::dmat4> worldFromNode;
    // As Scene::deformations; shared, because a pose is copied about. Empty where nothing deforms.
    std::vector<std::shared_ptr<const DeformedMesh>> deformed;
};

// As the file has it: no clip plays.
Pose restPose(const Scene& scene);
// While the clips play, in order, each from its own start; see localTime(). time: seconds. A moment
// at which they take something out of reach is at rest.
Pose poseAt(const Scene& scene, std::span<const Index> clips, double time);
// While defaultClips() play.
Pose poseAt(const Scene& scene, double time);

// The first clip, and of the others those that move nothing which the ones before them move: of
// several ways to walk the first, of a mobile's parts all.
std::vector<Index> defaultClips(const Scene& scene);
// The clip of that name, none for the empty name, the default ones without a name. Nothing when
// the scene has no such clip.
std::optional<std::vector<Index>> clipsNamed(const Scene& scene,
                                             const std::optional<std::string>& name);

// What some clip moves: for each node, and for each instance, that its node moves or its mesh
// deforms.
std::vector<bool> nodesThatMove(const Scene& scene);
std::vector<bool> instancesThatMove(const Scene& scene);

// Puts the vertices, boxes and areas of deforming meshes at rest, and sets Scene::reach from a few
// moments of every clip. Whoever makes a scene with clips calls it at the end.
void finishMotion(Scene& scene);

// A mesh's vertices at one moment, by the numbers that stand in Scene::indices.
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
// Mesh space. `cluster`: of the mesh's, from 0.
const Bounds& boundsOf(const Pose& pose, const Mesh& mesh);
const Bounds& boundsOf(const Scene& scene, const Pose& pose, const Mesh& mesh,
                       std::uint32_t cluster);
// Nothing for a mesh that does not deform.
const DeformedMesh* deformedMesh(const Pose& pose, const Mesh& mesh);

// World box of all instances at this moment; empty for an empty scene.
Bounds worldBounds(const Scene& scene, const Pose& pose);
// The same for any moment: what is measured in shares of the scene does not change with time.
Bounds lastingBounds(const Scene& scene, const Pose& pose);

// Triangles as drawn: each instance counts.
std::uint64_t triangleCount(const Scene& scene);

// The scene's own default view, else that of its first perspective camera, else one that shows its
// bounds from slightly above.
DefaultView defaultView(const Scene& scene);

// Every index in range, every number finite, every count consistent: what the renderer may rely on.
// Returns the problems found, empty when the scene is sound. Never throws, never reads out of
// range.
std::vector<std::string> sceneProblems(const Scene& scene);

// Sets contentHash from everything else.
void updateContentHash(Scene& scene);
// Of everything in a material that can change a picture.
std::uint64_t contentHash(const Material& material);

}  // namespace clerestory
