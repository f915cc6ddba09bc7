// Third-party files: each loads or is rejected with a reason, and none harms this process.
#include "tests/unit/import_support.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <set>

namespace clerestory {
namespace {

// Resident memory in MiB.
double residentMegabytes() {
    std::ifstream statm("/proc/self/statm");
    double pages = 0.0;
    double resident = 0.0;
    statm >> pages >> resident;
    return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

std::vector<std::filesystem::path> sceneFiles() {
    const std::set<std::string> models{".gltf", ".glb", ".obj", ".dae", ".fbx",     ".3ds",
                                       ".ply",  ".stl", ".off", ".x",   ".md5mesh", ".raw"};
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(sharedScene(""))) {
        std::string extension = entry.path().extension().string();
        std::transform(extension.begin(), extension.end(), extension.begin(), ::tolower);
        if (entry.is_regular_file() && models.contains(extension)) {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

TEST(SharedScenes, LoadOrAreRejected) {
    CLERESTORY_NEEDS(sharedScene(""));
    std::size_t loaded = 0;
    for (const auto& file : sceneFiles()) {
        SCOPED_TRACE(file.filename().string());
        const bool malformed = file.string().find("Malformed") != std::string::npos;
        try {
            const Scene scene = importScene(file);
            EXPECT_TRUE(sceneProblems(scene).empty());
            EXPECT_FALSE(scene.instances.empty());
            EXPECT_FALSE(worldBounds(scene, poseAt(scene, 0.0)).empty());
            loaded += malformed ? 0 : 1;
        } catch (const ImportError& error) {
            const std::set<std::string> expected{
                "Cube.off",             // not one of our formats
                "box_UTF16BE.obj",      // not ASCII
                "cameras.dae",          // without meshes
                "lights.dae",           // the same
                "number_formats.obj"};  // its one triangle has no area
            EXPECT_TRUE(malformed || expected.contains(file.filename().string())) << error.what();
            EXPECT_EQ(std::string(error.what()).find(sharedScene("").string()), std::string::npos);
        }
    }
    EXPECT_GE(loaded, 80u);
    std::cout << "loaded " << loaded << " scenes, " << residentMegabytes() << " MiB resident\n";
}

TEST(SharedScenes, MalformedFilesDoNotHarmThisProcess) {
    CLERESTORY_NEEDS(sharedScene("MalformedAssimp"));
    const double before = residentMegabytes();
    for (const auto& file : sceneFiles()) {
        if (file.string().find("Malformed") != std::string::npos) {
            try {
                importScene(file);
            } catch (const ImportError&) {  // the usual case
            }
        }
    }
    EXPECT_LT(residentMegabytes() - before, 32.0);
}

TEST(SharedScenes, EmissiveStrengthIsKept) {
    const auto file = sharedScene("EmissiveStrengthTest/EmissiveStrengthTest.glb");
    CLERESTORY_NEEDS(file);
    std::multiset<float> strengths;
    for (const Material& m : importScene(file).materials) {
        if (glm::length(m.emissive) > 0.0f) strengths.insert(m.emissiveStrength);
    }
    EXPECT_EQ(strengths, (std::multiset<float>{1, 2, 4, 8, 16}));
}

TEST(SharedScenes, CameraAnglesAreVertical) {
    const auto file = sharedScene("TransmissionTest/TransmissionTest.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    ASSERT_EQ(scene.cameras.size(), 1u);
    // The file's own number; with its aspect ratio of 4:3 that is 45 degrees across.
    EXPECT_DOUBLE_EQ(scene.cameras[0].yfov, 0.6024156808853149);
    const double across = 2.0 * std::atan(std::tan(scene.cameras[0].yfov / 2.0) * 4.0 / 3.0);
    EXPECT_NEAR(across, 0.785, 0.001);
}

TEST(SharedScenes, NamesWithSpacesAndSymbols) {
    const auto spaces = sharedScene("Box With Spaces/Box With Spaces.gltf");
    CLERESTORY_NEEDS(spaces);
    const Scene spaced = importScene(spaces);
    EXPECT_EQ(spaced.images.size(), 2u) << "three files, of which one joined the normal map";
    EXPECT_TRUE(spaced.images[0].packedNormal || spaced.images[1].packedNormal);
    EXPECT_EQ(importScene(spaces).title, "Box With Spaces");
    const Scene symbols = importScene(sharedScene("Unicode❤♻Test/Unicode❤♻Test.gltf"));
    EXPECT_EQ(symbols.images.size(), 1u);
    EXPECT_EQ(symbols.title, "Unicode❤♻Test");
}

TEST(SharedScenes, MirroredNodesStayMirrored) {
    const auto file = sharedScene("NegativeScaleTest/NegativeScaleTest.glb");
    CLERESTORY_NEEDS(file);
    const Scene scene = importScene(file);
    const Pose pose = poseAt(scene, 0.0);
    const auto mirrored =
        std::count_if(scene.instances.begin(), scene.instances.end(), [&](const Instance& i) {
            return glm::determinant(glm::dmat3(pose.worldFromNode[i.node])) < 0.0;
        });
    EXPECT_EQ(mirrored, 4) << "six nodes have negative scales; two of them undo their parents'";
}

TEST(SharedScenes, EverySkinOfASharedMeshIsShown) {
    const auto file = sharedScene("RecursiveSkeletons/RecursiveSkeletons.glb");
    CLERESTORY_NEEDS(file);
    EXPECT_EQ(importScene(file).instances.size(), 84u);
}

TEST(SharedScenes, SponzaLoadsWhole) {
    const auto file = sharedScene("Sponza/Sponza.gltf");
    CLERESTORY_NEEDS(file);
    const auto start = std::chrono::steady_clock::now();
    const Scene scene = importScene(file);
    const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - start;
    std::cout << "Sponza: " << took.count() << " ms\n";
    EXPECT_EQ(scene.images.size(), 49u) << "69, of which 20 joined normal maps";
    EXPECT_GT(triangleCount(scene), 261'000u);
    const auto masked =
        std::count_if(scene.materials.begin(), scene.materials.end(),
                      [](const Material& m) { return m.alphaMode == AlphaMode::mask; });
    EXPECT_GE(masked, 3) << "plants and chain";
}

TEST(SharedEnvironments, EquirectangularAndSixImages) {
    const auto hdr = sharedScene("env/venice_sunset_1k.hdr");
    CLERESTORY_NEEDS(hdr);
    const EnvironmentMap sunset = loadEnvironment(hdr);
    EXPECT_EQ(sunset.name, "venice_sunset_1k");
    ASSERT_EQ(sunset.texels.size(), std::size_t{6} * sunset.faceSize * sunset.faceSize);
    const EnvironmentMap garden = loadEnvironment(sharedScene("env/studio_garden"));
    EXPECT_EQ(garden.faceSize, 1024u);
    ASSERT_EQ(garden.texels.size(), std::size_t{6} * 1024 * 1024);
    const auto finite = [](const glm::vec3& t) {
        return std::isfinite(t.x + t.y + t.z) && t.x >= 0.0f && t.y >= 0.0f && t.z >= 0.0f;
    };
    EXPECT_TRUE(std::all_of(sunset.texels.begin(), sunset.texels.end(), finite));
    EXPECT_TRUE(std::all_of(garden.texels.begin(), garden.texels.end(), finite));
    EXPECT_THROW(loadEnvironment(sharedScene("env")), ImportError);
    const EnvironmentMap sky = loadEnvironment(sharedScene("env/sky_skybox.ktx2"));
    EXPECT_EQ(sky.faceSize, 128u);
    EXPECT_TRUE(std::all_of(sky.texels.begin(), sky.texels.end(), finite));
    EXPECT_EQ(loadEnvironment(sharedScene("env/lebombo_specular_256.ktx2")).faceSize, 256u);
    EXPECT_THROW(loadEnvironment(sharedScene("env/none.hdr")), ImportError);
}

}  // namespace
}  // namespace clerestory
