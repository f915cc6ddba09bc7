// Small scenes for plan tests: boxes of given materials at given positions.
#pragma once

#include "plan/planner.h"
#include "scene/mesh_builder.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace clerestory::test {

inline Index addBoxMesh(Scene& scene, const std::string& name, Index material) {
    MeshDraft draft{.name = name, .material = material};
    for (int axis = 0; axis < 3; ++axis) {
        for (int side = -1; side <= 1; side += 2) {
            const auto first = static_cast<std::uint32_t>(draft.vertices.size());
            for (int i = 0; i < 4; ++i) {
                Vertex v;
                v.position[axis] = static_cast<float>(side);
                v.position[(axis + 1) % 3] = (i == 1 || i == 2) ? 1.0f : -1.0f;
                v.position[(axis + 2) % 3] = i >= 2 ? 1.0f : -1.0f;
                v.normal = glm::vec3(0.0f);
                v.normal[axis] = static_cast<float>(side);
                draft.vertices.push_back(v);
            }
            for (const std::uint32_t i : side > 0 ? std::array{0u, 1u, 2u, 0u, 2u, 3u}
                                                  : std::array{0u, 2u, 1u, 0u, 3u, 2u}) {
                draft.indices.push_back(first + i);
            }
        }
    }
    draft.hasNormals = true;
    return addMesh(scene, std::move(draft));
}

// From -1 to 1 in the plane z = 0, facing +Z.
inline Index addSquareMesh(Scene& scene, const std::string& name, Index material) {
    MeshDraft draft{.name = name, .material = material, .hasNormals = true};
    for (const glm::vec2 at :
         {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
        draft.vertices.push_back({.position = glm::vec3(at, 0.0f), .normal = {0, 0, 1}});
    }
    draft.indices = {0, 1, 2, 0, 2, 3};
    return addMesh(scene, std::move(draft));
}

// Of radius 1 around the origin.
inline Index addBallMesh(Scene& scene, const std::string& name, Index material) {
    constexpr std::uint32_t kRows = 12, kColumns = 24;
    MeshDraft draft{.name = name, .material = material, .hasNormals = true};
    for (std::uint32_t j = 0; j <= kRows; ++j) {
        for (std::uint32_t i = 0; i <= kColumns; ++i) {
            const float theta = glm::pi<float>() * float(j) / float(kRows);
            const float phi = glm::two_pi<float>() * float(i) / float(kColumns);
            const glm::vec3 n(std::sin(theta) * std::sin(phi), std::cos(theta),
                              std::sin(theta) * std::cos(phi));
            draft.vertices.push_back({.position = n, .normal = n});
        }
    }
    for (std::uint32_t j = 0; j < kRows; ++j) {
        for (std::uint32_t i = 0; i < kColumns; ++i) {
            const std::uint32_t a = j * (kColumns + 1) + i, b = a + kColumns + 1;
            if (j > 0) draft.indices.insert(draft.indices.end(), {a, b, a + 1});
            if (j + 1 < kRows) draft.indices.insert(draft.indices.end(), {a + 1, b, b + 1});
        }
    }
    return addMesh(scene, std::move(draft));
}

inline Index addMaterial(Scene& scene, Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

inline Index place(Scene& scene, Index mesh, const glm::dvec3& position, double halfSize = 1.0) {
    const Index node = addNode(
        scene, "node", glm::scale(glm::translate(glm::dmat4(1.0), position), glm::dvec3(halfSize)));
    addInstance(scene, node, mesh);
    return static_cast<Index>(scene.instances.size() - 1);
}

inline Index placeAt(Scene& scene, Index mesh, const glm::dmat4& worldFromMesh,
                     const std::string& name = "node") {
    addInstance(scene, addNode(scene, name, worldFromMesh), mesh);
    return static_cast<Index>(scene.instances.size() - 1);
}

// One grey box of half size 1 at the origin.
inline Scene boxScene(Material material = {}) {
    Scene scene;
    scene.id = "box";
    place(scene, addBoxMesh(scene, "box", addMaterial(scene, std::move(material))),
          glm::dvec3(0.0));
    return scene;
}

// Without shadows and light between surfaces, which have their own tests.
inline FrameRequest lookingFrom(const glm::dvec3& position,
                                const glm::dvec3& target = glm::dvec3(0.0)) {
    FrameRequest request;
    request.camera.position = position;
    request.camera.target = target;
    request.width = 160;
    request.height = 90;
    request.effects.shadows = request.effects.indirectLight = false;
    return request;
}

// A map without a sun, so that tests count only the lights they place.
inline EnvironmentMap plainMap() {
    EnvironmentMap map;
    map.name = "plain";
    map.faceSize = 1;
    map.texels.assign(6, glm::vec3(1.0f));
    map.contentHash = 1;
    return map;
}

inline FramePlan planOf(const Scene& scene, const Pose& pose, const FrameRequest& request,
                        const ResidentMaps& resident = {}, const EnvironmentMap& map = plainMap()) {
    return planFrame({.scene = scene,
                      .pose = pose,
                      .environment = map,
                      .maps = {},
                      .resident = resident,
                      .limits = {}},
                     request);
}
inline FramePlan planOf(const Scene& scene, const FrameRequest& request,
                        const ResidentMaps& resident = {}, const EnvironmentMap& map = plainMap()) {
    return planOf(scene, poseAt(scene, request.time), request, resident, map);
}

}  // namespace clerestory::test
