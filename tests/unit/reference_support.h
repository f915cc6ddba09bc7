// Small scenes for the reference path tracer, and means of its images.
#pragma once

#include "plan_scenes.h"
#include "reference/reference.h"
#include "scene/builtin/modelling.h"

#include <gtest/gtest.h>

namespace clerestory::test {

inline Index addFineBall(Scene& scene, Index material, int segments = 96, float radius = 1.0f) {
    MeshDraft draft = shapes::draft("ball", material);
    shapes::addSphere(draft, glm::vec3(0.0f), radius, segments);
    return addMesh(scene, std::move(draft));
}

inline Scene ballScene(Material material, int segments = 96) {
    Scene scene;
    scene.id = "ball";
    placeAt(scene, addFineBall(scene, addMaterial(scene, std::move(material)), segments),
            glm::dmat4(1.0));
    return scene;
}

// A few pixels, all of which see about the same.
inline FrameRequest narrow(const glm::dvec3& position, const glm::dvec3& target, double yfov = 0.02,
                           std::uint32_t edge = 2) {
    FrameRequest request = lookingFrom(position, target);
    request.width = request.height = edge;
    request.camera.yfov = yfov;
    return request;
}

inline ReferenceImage traced(const Scene& scene, const FrameRequest& frame,
                             const EnvironmentMap& environment, ReferenceMode mode,
                             std::uint32_t samples, std::uint32_t threads = 1,
                             std::uint64_t seed = 1) {
    const auto image = traceReference({.scene = scene,
                                       .frame = frame,
                                       .environment = environment,
                                       .mode = mode,
                                       .samples = samples,
                                       .seed = seed,
                                       .threads = threads});
    EXPECT_TRUE(image.has_value());
    EXPECT_EQ(image->nonFinite, 0u);
    return *image;
}

inline glm::dvec3 meanColor(const ReferenceImage& image) {
    glm::dvec3 sum(0.0);
    const std::size_t pixels = image.objectId.size();
    for (std::size_t i = 0; i < 3 * pixels; ++i) {
        sum[static_cast<int>(i % 3)] += image.color.floats()[i];
    }
    return sum / double(pixels);
}

inline EnvironmentMap uniformMap(float radiance) {
    return constantEnvironment("uniform", glm::vec3(radiance));
}

// Reflects diffusely and in no other way.
inline Material chalk(float albedo) {
    return {.name = "chalk",
            .baseColor = glm::vec4(glm::vec3(albedo), 1.0f),
            .metallic = 0.0f,
            .roughness = 1.0f,
            .specular = 0.0f};
}

inline Material lamp(float radiance) {
    Material m = chalk(0.0f);
    m.emissive = glm::vec3(radiance);
    return m;
}

}  // namespace clerestory::test
