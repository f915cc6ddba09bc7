// See support.h.
#include "support.h"

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string_view>

namespace clerestory::test {

Renderer& renderer() {
    const char* rays = std::getenv("CLERESTORY_TEST_RAYS");
    static Renderer instance(
        {.rays = rays && std::string_view(rays) == "shader" ? Computation::shader
                                                            : Computation::automatic,
         .light = {.background = false, .addedTriangles = 8000, .places = 8000},
         .debugOutput = true});
    return instance;
}

void GlTest::TearDown() {
    EXPECT_EQ(renderer().driverMessages(), std::vector<std::string>{});
}

MeshDraft quad(float half, Index material) {
    MeshDraft draft;
    draft.name = "quad";
    draft.material = material;
    draft.hasNormals = draft.hasTexCoords = true;
    for (const glm::vec2 corner :
         {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)}) {
        Vertex v;
        v.position = glm::vec3(half * corner, 0.0f);
        v.texCoord0 = glm::vec2(0.5f + 0.5f * corner.x, 0.5f - 0.5f * corner.y);
        draft.vertices.push_back(v);
    }
    draft.indices = {0, 1, 2, 0, 2, 3};
    return draft;
}

MeshDraft sphere(float radius, std::uint32_t rows, Index material) {
    MeshDraft draft;
    draft.name = "sphere";
    draft.material = material;
    draft.hasNormals = true;
    const std::uint32_t columns = 2 * rows;
    for (std::uint32_t j = 0; j <= rows; ++j) {
        for (std::uint32_t i = 0; i <= columns; ++i) {
            const float theta = 3.14159265f * static_cast<float>(j) / static_cast<float>(rows);
            const float phi = 6.28318531f * static_cast<float>(i) / static_cast<float>(columns);
            Vertex v;
            v.normal = {std::sin(theta) * std::sin(phi), std::cos(theta),
                        std::sin(theta) * std::cos(phi)};
            v.position = radius * v.normal;
            draft.vertices.push_back(v);
        }
    }
    for (std::uint32_t j = 0; j < rows; ++j) {
        for (std::uint32_t i = 0; i < columns; ++i) {
            const std::uint32_t a = j * (columns + 1) + i, b = a + columns + 1;
            if (j > 0) draft.indices.insert(draft.indices.end(), {a, b, a + 1});
            if (j + 1 < rows) draft.indices.insert(draft.indices.end(), {a + 1, b, b + 1});
        }
    }
    return draft;
}

Material mirrorMetal(float reflectance, float roughness) {
    return {.name = "mirror",
            .baseColor = glm::vec4(glm::vec3(reflectance), 1.0f),
            .metallic = 1.0f,
            .roughness = roughness};
}

bool sameBytes(const Image& a, const Image& b) {
    return a.width == b.width && a.height == b.height && a.data.size() == b.data.size() &&
           std::memcmp(a.data.data(), b.data.data(), a.data.size()) == 0;
}

Material lambert(float albedo, float emitted) {
    Material m;
    m.baseColor = glm::vec4(glm::vec3(albedo), 1.0f);
    m.metallic = 0.0f;
    m.specular = 0.0f;
    m.emissive = glm::vec3(emitted);
    return m;
}

Material lambertBothSides(float albedo) {
    Material m = lambert(albedo);
    m.doubleSided = true;
    return m;
}

Material clearGlass(float ior, float roughness) {
    return {.name = "glass",
            .metallic = 0.0f,
            .roughness = roughness,
            .ior = ior,
            .transmission = 1.0f};
}

Material unlit(const glm::vec4& color) {
    Material m;
    m.baseColor = color;
    m.unlit = true;
    return m;
}

Material glowing(const glm::vec3& radiance) {
    return {.name = "lamp",
            .baseColor = {0, 0, 0, 1},
            .metallic = 0.0f,
            .emissive = radiance,
            .doubleSided = true,
            .specular = 0.0f};
}

Index addMaterial(Scene& scene, Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

void place(Scene& scene, MeshDraft draft, const glm::dmat4& worldFromModel) {
    const Index mesh = addMesh(scene, std::move(draft));
    const Index node = addNode(scene, "node", worldFromModel);
    addInstance(scene, node, mesh);
}

glm::dmat4 moved(double x, double y, double z) {
    glm::dmat4 m(1.0);
    m[3] = {x, y, z, 1.0};
    return m;
}

Index addLight(Scene& scene, Light light, const glm::dmat4& worldFromLocal) {
    light.node = addNode(scene, "light", worldFromLocal);
    scene.lights.push_back(std::move(light));
    return static_cast<Index>(scene.lights.size() - 1);
}

Index addTexture2x2(Scene& scene, const std::array<glm::u8vec4, 4>& texels, Wrap wrap,
                    Filter filter) {
    TextureImage image{.name = "2x2", .width = 2, .height = 2, .levels = 1};
    for (const glm::u8vec4& t : texels)
        image.texels.insert(image.texels.end(), {t.x, t.y, t.z, t.w});
    scene.images.push_back(std::move(image));
    scene.textures.push_back({.image = static_cast<Index>(scene.images.size() - 1),
                              .wrapU = wrap,
                              .wrapV = wrap,
                              .magnify = filter,
                              .minify = filter,
                              .useLevels = false});
    return static_cast<Index>(scene.textures.size() - 1);
}

void moveLast(Scene& scene, const glm::vec3& from, const glm::vec3& to) {
    scene.movingNodes.push_back({static_cast<Index>(scene.nodes.size() - 1), {}});
    Track track{.target = static_cast<Index>(scene.movingNodes.size() - 1), .times = {0.0f, 2.0f}};
    track.values = {from.x, from.y, from.z, to.x, to.y, to.z};
    scene.clips.push_back({"move", 2.0, {track}});
    finishMotion(scene);
}

FrameRequest request(Scene scene, const std::string& id, const glm::dvec3& eye) {
    scene.id = id;
    scene.environment = "black";
    updateContentHash(scene);
    EXPECT_EQ(sceneProblems(scene), std::vector<std::string>{});
    renderer().addScene(std::move(scene));
    FrameRequest r;
    r.scene = id;
    r.width = r.height = 64;
    r.camera.position = eye;
    r.camera.target = eye - glm::dvec3(0.0, 0.0, 1.0);
    r.camera.yfov = 1.5707963267948966;
    r.camera.znear = 0.01;
    r.output.format = OutputFormat::npy;
    r.accuracy.edgeFilter = false;
    r.effects.shadows = r.effects.indirectLight = false;
    return r;
}

std::size_t differing(const Image& a, const Image& b) {
    EXPECT_EQ(a.data.size(), b.data.size());
    const std::size_t pixel = a.data.size() / (std::size_t{a.width} * a.height);
    std::size_t count = 0;
    for (std::size_t i = 0; i + pixel <= a.data.size(); i += pixel) {
        count += std::memcmp(a.data.data() + i, b.data.data() + i, pixel) != 0 ? 1 : 0;
    }
    return count;
}

glm::vec3 color(const Image& image, std::uint32_t x, std::uint32_t y) {
    const float* p = image.floats() + (std::size_t{y} * image.width + x) * image.channels;
    return {p[0], p[1], p[2]};
}

float number(const Image& image, std::uint32_t x, std::uint32_t y) {
    return image.floats()[std::size_t{y} * image.width + x];
}

glm::vec3 centerColor(const Image& image) {
    return color(image, image.width / 2, image.height / 2);
}

}  // namespace clerestory::test
