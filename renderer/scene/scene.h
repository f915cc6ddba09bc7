// What exists: meshes, materials, lights, cameras. A plain value of indices, fixed after loading;
// poseAt(scene, time) gives a moment of it. Metres, radians, seconds, linear colours; right-handed,
// +Y up, cameras and lights look down their own -Z (glTF 2.0).
//
// Does not: read files (scene/import), decide what is drawn (plan), know OpenGL.
#pragma once

#include "scene/bounds.h"
#include "scene/material.h"
#include "scene/plane.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

// Every vertex is complete: what a file lacks was made or set to a neutral value by addMesh().
struct Vertex {
    glm::vec3 position{0.0f};
    glm::vec3 normal{0.0f, 0.0f, 1.0f};         // unit
    glm::vec4 tangent{1.0f, 0.0f, 0.0f, 1.0f};  // unit; w is the sign of the bitangent
    glm::vec2 texCoord0{0.0f};
    glm::vec2 texCoord1{0.0f};
    glm::vec4 color{1.0f};  // linear, multiplies baseColor
};
static_assert(sizeof(Vertex) == 72);

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
    double area = 0.0;       // mesh space, square metres
    Index material = 0;      // what its instances have unless they are given another
    Bounds bounds;           // mesh space
    bool hasColors = false;  // some vertex colour is not white
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
    std::optional<DefaultView> defaultView;
    std::string environment = "sky";  // the map used when a request names none
    std::vector<ImportWarning> warnings;
};

// Where everything is at one moment.
struct Pose {
    std::vector<glm::dmat4> worldFromNode;
};
Pose poseAt(const Scene& scene, double time);

// World box of all instances; empty for an empty scene.
Bounds worldBounds(const Scene& scene, const Pose& pose);

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
