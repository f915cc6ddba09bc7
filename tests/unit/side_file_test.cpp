// Side files and extras of a model: applied permanently, and harmless if invalid.
#include "tests/unit/import_support.h"

#include "scene/classification.h"
#include "scene/import/base/sidecar.h"

#include <gmock/gmock.h>

namespace clerestory {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

// A floor and a wall of one material each, at nodes of a hall.
constexpr const char* kHall = R"({
  "asset": {"version": "2.0"}, LIGHTS "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"name": "hall", "children": [1, 2]},
            {"name": "ground", "mesh": 0, "extras": {"probe": {"size": 0.5, "resolution": 64}}},
            {"name": "side", "mesh": 1, "translation": [0, 1, 0]}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "material": 0}]},
             {"primitives": [{"attributes": {"POSITION": 0}, "material": 1}]}],
  "materials": [
    {"name": "stone", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.9}},
    {"name": "paint", "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0.8},
     "extras": EXTRAS}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 6, "type": "VEC3"}],
  "bufferViews": [{"buffer": 0, "byteLength": 72}],
  "buffers": [{"byteLength": 72, "uri": "hall.bin"}]})";

class SideFile : public testing::Test {
protected:
    // lights: members of the file; two nodes have its lights 0 and 1.
    Scene load(const std::string& sideFile, const std::string& extras = "{}",
               const std::string& lights = "") {
        const float corners[] = {0, 0, 0, 1, 0, 0, 1, 0, -1, 0, 0, 0, 1, 0, -1, 0, 0, -1};
        folder_.write("hall.bin", {reinterpret_cast<const char*>(corners), sizeof corners});
        std::string model = kHall;
        model.replace(model.find("EXTRAS"), 6, extras);
        model.replace(model.find("LIGHTS"), 6, lights);
        for (int node = 0; node < 2 && !lights.empty(); ++node) {
            const std::string number = std::to_string(node), mesh = "\"mesh\": " + number;
            model.insert(model.find(mesh),
                         R"("extensions": {"KHR_lights_punctual": {"light": )" + number + "}}, ");
        }
        if (!sideFile.empty()) folder_.write("hall.clerestory.json", sideFile);
        return importSceneInProcess(folder_.write("hall.gltf", model));
    }
    static const Material& of(const Scene& scene, std::size_t instance) {
        return scene.materials.at(scene.instances.at(instance).material);
    }

    TemporaryFolder folder_;
};

TEST_F(SideFile, ChangesMaterialsPermanently) {
    const Scene plain = load("");
    const Scene scene = load(R"({"overrides": [
        {"material": "stone", "roughness": 0.1, "baseColor": [0.2, 0.3, 0.4]},
        {"node": "hall", "ior": 1.3},
        {"node": "hall", "material": "paint", "reflection": "mirror"}]})");
    EXPECT_EQ(of(scene, 0).roughness, 0.1f);
    EXPECT_EQ(of(scene, 0).baseColor, glm::vec4(0.2f, 0.3f, 0.4f, 1.0f));
    EXPECT_EQ(of(scene, 0).ior, 1.3f) << "a node's name selects its subtree";
    EXPECT_EQ(of(scene, 0).reflection, Reflection::automatic);
    EXPECT_EQ(of(scene, 1).roughness, 0.8f);
    EXPECT_EQ(of(scene, 1).reflection, Reflection::mirror);
    EXPECT_NE(scene.contentHash, plain.contentHash);
    EXPECT_EQ(warning(scene, "sideFile"), nullptr);
    EXPECT_EQ(surfacesOf(scene)[0].reason, ReflectorReason::gloss);
    EXPECT_EQ(surfacesOf(scene)[1].reason, ReflectorReason::requested);
    EXPECT_EQ(surfacesOf(plain)[0].reason, ReflectorReason::roughDielectric);
}

TEST_F(SideFile, AByteOrderMarkIsNotContent) {
    const Scene scene = load(
        "\xEF\xBB\xBF"
        R"({"overrides": [{"material": "stone", "metallic": 1}]})");
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(of(scene, 0).metallic, 1.0f);
    try {
        importSceneInProcess(folder_.write(
            "marked.gltf", "\xEF\xBB\xBF{\"asset\": {\"version\": \"2.0\"}, \"scenes\": [{}]}"));
        FAIL();
    } catch (const ImportError& error) {
        EXPECT_STREQ(error.what(), "the file has no triangles, lines or points to draw");
    }
}

TEST_F(SideFile, ErrorsNameThePlaceInTheFile) {
    const Scene scene = load(R"({"overrides": ])");
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_THAT(scene.warnings[0].message, HasSubstr("not valid JSON at byte 15"));
}

TEST_F(SideFile, LightsHaveARadius) {
    const auto lit = [this](const std::string& sideFile, const std::string& radius) {
        std::string lights = R"("extensions": {"KHR_lights_punctual": {"lights": [)"
                             R"({"name": "lamp", "type": "point", "extras": {"radius": RADIUS}},)"
                             R"({"name": "sun", "type": "directional"}]}},)";
        lights.replace(lights.find("RADIUS"), 6, radius);
        return load(sideFile, "{}", lights);
    };
    const Scene own = lit("", "0.25");
    ASSERT_EQ(own.lights.size(), 2u);
    EXPECT_EQ(own.lights[0].radius, 0.25f);
    EXPECT_EQ(own.lights[1].radius, 0.0f);
    EXPECT_EQ(warning(own, "badExtras"), nullptr);
    const Scene wrong = lit("", "-1");
    EXPECT_EQ(wrong.lights[0].radius, 0.0f);
    ASSERT_NE(warning(wrong, "badExtras"), nullptr);
    const Scene changed =
        lit(R"({"lights": [{"radius": 0.1}, {"light": "sun", "radius": 0.005}]})", "0.25");
    EXPECT_EQ(changed.lights[0].radius, 0.1f);
    EXPECT_EQ(changed.lights[1].radius, 0.005f);
    EXPECT_NE(changed.contentHash, own.contentHash);
    const Scene unknown = lit(R"({"lights": [{"light": "son", "radius": 0.1}]})", "0.25");
    EXPECT_EQ(unknown.lights[1].radius, 0.0f);
    ASSERT_NE(warning(unknown, "sideFile"), nullptr);
}

TEST_F(SideFile, ProbesCanBeNamedByMaterials) {
    const Scene scene = load(R"({
        "probes": [{"name": "corner", "position": [1, 2, 3], "size": 0.25, "zfar": 9},
                   {"name": "rider", "node": "side", "position": [0, 0, 1], "resolution": 128}],
        "overrides": [{"material": "stone", "probe": "corner"},
                      {"material": "paint", "probe": "ground"}]})");
    ASSERT_EQ(scene.probes.size(), 3u);
    EXPECT_EQ(scene.probes[0].name, "ground") << "named like its node";
    EXPECT_EQ(scene.probes[0].size, 0.5);
    EXPECT_EQ(scene.nodes[scene.probes[0].node].name, "ground");
    EXPECT_EQ(scene.probes[0].resolution, 64u);
    EXPECT_EQ(scene.probes[1].position, glm::dvec3(1, 2, 3));
    EXPECT_EQ(scene.probes[1].node, kNone);
    EXPECT_EQ(scene.probes[1].zfar, 9.0);
    EXPECT_EQ(scene.nodes[scene.probes[2].node].name, "side");
    EXPECT_EQ(of(scene, 0).probe, "corner");
    EXPECT_EQ(of(scene, 1).probe, "ground");
    EXPECT_EQ(warning(scene, "sideFile"), nullptr);
}

TEST_F(SideFile, ExtrasAreEquivalent) {
    const Scene scene = load("", R"({"reflection": "mirror", "environmentMap": "dusk",
        "environmentRotation": [0, 0.6, 0, 0.8], "roughness": "a foreign note"})");
    EXPECT_EQ(of(scene, 1).reflection, Reflection::mirror);
    EXPECT_EQ(of(scene, 1).environmentMap, "dusk");
    EXPECT_NEAR(of(scene, 1).environmentRotation.y, 0.6, 1e-12);
    EXPECT_NEAR(of(scene, 1).environmentRotation.w, 0.8, 1e-12);
    EXPECT_EQ(of(scene, 1).roughness, 0.8f);
    EXPECT_EQ(warning(scene, "badExtras"), nullptr);
    EXPECT_EQ(of(load("", R"({"probe": "ground"})"), 1).probe, "ground");
}

TEST_F(SideFile, InvalidExtrasAreWarnings) {
    for (const char* extras :
         {R"({"reflection": "chrome"})", R"({"reflection": 1})",
          R"({"environmentRotation": [0, 0, 0, 0]})", R"({"environmentRotation": [0, 1]})",
          R"({"environmentMap": null})"}) {
        const Scene scene = load("", extras);
        EXPECT_NE(warning(scene, "badExtras"), nullptr) << extras;
        EXPECT_EQ(of(scene, 1).reflection, Reflection::automatic);
    }
    for (const char* extras : {"[]", "7", "null", R"("mirror")", "{}"}) {
        EXPECT_EQ(warning(load("", extras), "badExtras"), nullptr) << extras;
    }
    const Scene unknown = load("", R"({"probe": "nowhere"})");
    EXPECT_NE(warning(unknown, "unknownProbe"), nullptr);
    EXPECT_EQ(of(unknown, 1).probe, "");
}

struct InvalidSideFileCase {
    const char* name;
    const char* file;
    const char* place;    // in a warning's subject
    const char* message;  // in its message
};
class InvalidSideFile : public SideFile, public testing::WithParamInterface<InvalidSideFileCase> {};

TEST_P(InvalidSideFile, IsAWarningWithItsLocation) {
    const Scene scene = load(GetParam().file);
    EXPECT_THAT(
        scene.warnings,
        Contains(testing::AllOf(Field(&ImportWarning::code, "sideFile"),
                                Field(&ImportWarning::subject, HasSubstr(GetParam().place)),
                                Field(&ImportWarning::message, HasSubstr(GetParam().message)))));
    for (const ImportWarning& w : scene.warnings) {
        EXPECT_THAT(w.message, Not(HasSubstr((folder_ / "").string())));
    }
    EXPECT_EQ(of(scene, 0).roughness, 0.9f);
    EXPECT_EQ(scene.probes.size(), 1u);
    EXPECT_EQ(of(scene, 0).probe, "");
}

INSTANTIATE_TEST_SUITE_P(
    Files, InvalidSideFile,
    testing::Values(
        InvalidSideFileCase{"binary", "\xff\xfe\x00\x01", "hall.clerestory.json", "JSON"},
        InvalidSideFileCase{"cutShort", R"({"overrides": [{)", "hall.clerestory.json", "JSON"},
        InvalidSideFileCase{"deep",
                            "[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[",
                            "hall.clerestory.json", ""},
        InvalidSideFileCase{"list", "[]", "hall.clerestory.json", ""},
        InvalidSideFileCase{"unknownField", R"({"override": []})", "/override", "did you mean"},
        InvalidSideFileCase{"noList", R"({"overrides": {}})", "/overrides", "is object"},
        InvalidSideFileCase{"noObject", R"({"overrides": [7]})", "/overrides/0", "is number"},
        InvalidSideFileCase{"outOfRange",
                            R"({"overrides": [{"material": "stone", "roughness": 2}]})",
                            "/overrides/0/roughness", "0 to 1"},
        InvalidSideFileCase{"misspelt",
                            R"({"overrides": [{"material": "stone", "roughnes": 0.1}]})",
                            "/overrides/0/roughnes", "did you mean"},
        InvalidSideFileCase{"nothingChosen", R"({"overrides": [{"roughness": 0.1}]})",
                            "/overrides/0", "chooses nothing"},
        InvalidSideFileCase{"noSuchMaterial",
                            R"({"overrides": [{"material": "stome", "roughness": 0.1}]})",
                            "/overrides/0/material", "did you mean \"stone\""},
        InvalidSideFileCase{"noSuchNode", R"({"overrides": [{"node": "attic", "roughness": 0.1}]})",
                            "/overrides/0/node", "ground"},
        InvalidSideFileCase{"noSuchProbe",
                            R"({"overrides": [{"material": "stone", "probe": "attic"}]})",
                            "/overrides/0/probe", "ground"},
        InvalidSideFileCase{
            "badRotation",
            R"({"overrides": [{"material": "stone", "environmentRotation": [0, 0, 0, 0]}]})",
            "/overrides/0/environmentRotation", "unit quaternion"},
        InvalidSideFileCase{"namelessProbe", R"({"probes": [{"size": 1}]})", "/probes/0",
                            "without a name"},
        InvalidSideFileCase{"doubledProbe", R"({"probes": [{"name": "ground"}]})", "/probes/0",
                            "second"},
        InvalidSideFileCase{"probeWithoutNode", R"({"probes": [{"name": "a", "node": "attic"}]})",
                            "/probes/0", "not in the scene"}),
    [](const auto& row) { return row.param.name; });

TEST_F(SideFile, WorksWithOtherFormats) {
    folder_.write("one.clerestory.json",
                  R"({"overrides": [{"node": "one.obj", "transmission": 1, "roughness": 0}]})");
    const Scene scene =
        importSceneInProcess(folder_.write("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    EXPECT_EQ(surfacesOf(scene).at(0).glass, Glass::pane)
        << (scene.warnings.empty() ? "" : scene.warnings[0].message);
}

TEST_F(SideFile, PathsOutsideTheFolderAreNotFollowed) {
    const TemporaryFolder outside;
    outside.write("secret.json", R"({"overrides": [{"material": "stone", "roughness": 0.1}]})");
    std::filesystem::create_symlink(outside / "secret.json", folder_ / "hall.clerestory.json");
    EXPECT_EQ(of(load(""), 0).roughness, 0.9f);
}

TEST(GltfMaterial, GlassWithoutMetallicFactorIsDielectric) {
    const auto file = sharedScene("GlassTable/glass-table.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importSceneInProcess(file);
    EXPECT_EQ(material(scene, "Glass")->metallic, 0.0f);
    EXPECT_NE(warning(scene, "transmissiveMetal"), nullptr);
    int panes = 0;
    for (const Surface& s : surfacesOf(scene)) panes += s.glass == Glass::pane;
    EXPECT_GT(panes, 0);
}

}  // namespace
}  // namespace clerestory
