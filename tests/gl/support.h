// Small scenes, requests and readback for the gl tests. At its end every fixture asserts that the
// driver reported no messages.
#pragma once

#include "renderer.h"
#include "scene/mesh_builder.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>

namespace clerestory::test {

// One renderer with debug output for all tests of a program; made at first use.
Renderer& renderer();

class GlTest : public ::testing::Test {
protected:
    void TearDown() override;
};

// A square in the plane z = 0, facing +Z, from -half to half, with texture coordinates 0..1 (v = 0
// on top).
MeshDraft quad(float half, Index material);
// Around the origin, normals outwards, `rows` by 2 `rows` patches.
MeshDraft sphere(float radius, std::uint32_t rows, Index material);

// A smooth or rough metal of this reflectance.
Material mirrorMetal(float reflectance = 1.0f, float roughness = 0.0f);
// Lambert alone: reflects nothing from its surface.
Material lambert(float albedo, float emitted = 0.0f);
Material lambertBothSides(float albedo);
// Clear, thin-walled until it is given a thickness.
Material clearGlass(float ior = 1.5f, float roughness = 0.0f);
// Its own colour, independent of lighting.
Material unlit(const glm::vec4& color);
// Glows from both sides and reflects nothing.
Material glowing(const glm::vec3& radiance);

Index addMaterial(Scene& scene, Material material);
void place(Scene& scene, MeshDraft draft, const glm::dmat4& worldFromModel = glm::dmat4(1.0));
glm::dmat4 moved(double x, double y, double z);
Index addLight(Scene& scene, Light light, const glm::dmat4& worldFromLocal);
// A picture of two rows and two columns, first row on top, as a texture without levels.
Index addTexture2x2(Scene& scene, const std::array<glm::u8vec4, 4>& texels, Wrap wrap,
                    Filter filter = Filter::nearest);

// Makes the node that was placed last move from `from` to `to` (x, y, z; metres) in two seconds.
void moveLast(Scene& scene, const glm::vec3& from, const glm::vec3& to);

// Finishes the scene, hands it to renderer() under `id` and returns a request for it: 64x64, black
// environment, camera at `eye` looking down -Z with a vertical angle of 90 degrees, linear float
// colour, nothing filtered, without shadows and light between surfaces, which have their own tests.
FrameRequest request(Scene scene, const std::string& id, const glm::dvec3& eye = {0.0, 0.0, 2.0});

// Pixels of two images of one size whose bytes differ.
std::size_t differing(const Image& a, const Image& b);

glm::vec3 color(const Image& image, std::uint32_t x, std::uint32_t y);
bool sameBytes(const Image& a, const Image& b);
float number(const Image& image, std::uint32_t x, std::uint32_t y);
glm::vec3 centerColor(const Image& image);

}  // namespace clerestory::test
