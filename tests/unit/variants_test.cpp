// Material variants: the file's choices, by name, before overrides.
#include "import_support.h"
#include "tests/support/scene_files.h"

#include "scene/material_override.h"

#include <nlohmann/json.hpp>

namespace clerestory::test {
namespace {

using nlohmann::json;

// Two meshes and three materials: "day" changes the first mesh, "night" both.
json document() {
    json file = json::parse(triangleGltf());
    json one = file["meshes"][0]["primitives"][0];
    one["material"] = 0;
    json other = one;
    const auto mapping = [](int material, std::vector<int> variants) {
        return json{{"material", material}, {"variants", variants}};
    };
    one["extensions"]["KHR_materials_variants"]["mappings"] = {mapping(1, {0}), mapping(2, {1})};
    other["extensions"]["KHR_materials_variants"]["mappings"] = {mapping(1, {1})};
    file["meshes"] = {{{"primitives", {one, other}}}};
    file["nodes"] = {{{"mesh", 0}}};
    file["scenes"] = {{{"nodes", {0}}}};
    file["materials"] = {{{"name", "plain"}}, {{"name", "red"}}, {{"name", "blue"}}};
    file["extensionsUsed"] = {"KHR_materials_variants"};
    file["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "day"}},
                                                                {{"name", "night"}}};
    return file;
}

std::vector<std::string> namesIn(const Scene& scene, const MaterialBindings& materials) {
    std::vector<std::string> names;
    for (Index i = 0; i < scene.instances.size(); ++i) {
        names.push_back(materials.material(scene, materials.materialOf(scene, i)).name);
    }
    return names;
}

TEST(Variants, SelectTheMaterialsOfTheFile) {
    const TemporaryFolder folder;
    const Scene scene = importScene(folder.write("scene.gltf", document().dump()));
    EXPECT_FALSE(warning(scene, "unsupportedExtension"));
    ASSERT_EQ(scene.variants.size(), 2u);
    EXPECT_EQ(scene.variants[0].name, "day");
    using Names = std::vector<std::string>;
    const auto names = [&](const std::optional<std::string>& variant,
                           const std::vector<MaterialOverride>& overrides = {}) {
        return namesIn(scene, bindMaterials(scene, {}, overrides, variant));
    };
    EXPECT_EQ(names({}), (Names{"plain", "plain"}));
    EXPECT_EQ(names("day"), (Names{"red", "plain"}));
    EXPECT_EQ(names("night"), (Names{"blue", "red"}));
    EXPECT_EQ(names("unknown"), (Names{"plain", "plain"}));
    EXPECT_TRUE(bindMaterials(scene, {}, {}, "unknown").materialOfInstance.empty());
    // Overrides select by the name of the variant's material.
    MaterialOverride rough;
    rough.material = "red";
    rough.roughness = 0.25;
    const MaterialBindings both = bindMaterials(scene, {}, {rough}, "night");
    EXPECT_EQ(both.own.size(), 1u);
    EXPECT_EQ(both.material(scene, both.materialOf(scene, 1)).roughness, 0.25f);
    EXPECT_EQ(both.material(scene, both.materialOf(scene, 0)).name, "blue");
}

TEST(Variants, NamesAreUniqueAndIndicesAreChecked) {
    const TemporaryFolder folder;
    const auto write = [&](const json& file) { return folder.write("scene.gltf", file.dump()); };
    json file = document();
    auto& names = file["extensions"]["KHR_materials_variants"]["variants"];
    names = {{{"name", "day"}}, {{"name", "day"}}, json::object()};
    const Scene scene = importScene(write(file));
    ASSERT_EQ(scene.variants.size(), 3u);
    EXPECT_EQ(scene.variants[1].name, "day 2");
    EXPECT_EQ(scene.variants[2].name, "variant 3");
    auto& mapping =
        file["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"][0];
    mapping["material"] = 9;
    EXPECT_EQ(refusal(write(file)).reason(), ImportError::Reason::malformed);
    mapping["material"] = 1;
    mapping["variants"] = {3};
    EXPECT_EQ(refusal(write(file)).reason(), ImportError::Reason::malformed);
}

}  // namespace
}  // namespace clerestory::test
