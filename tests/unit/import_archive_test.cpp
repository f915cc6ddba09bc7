// A scene and its files in one archive: what is read, and what is rejected and why.
#include "tests/support/scene_files.h"
#include "tests/unit/import_support.h"

#include <gmock/gmock.h>

namespace clerestory::test {
namespace {

using testing::HasSubstr;
using Reason = ImportError::Reason;

std::vector<PackedFile> twoFiles() {
    return {{"model/scene.gltf", triangleGltf("data/points.bin")},
            {"model/data/points.bin", triangleBuffer()},
            {"model/readme.txt", "words"}};
}

TEST(ImportArchive, ZipTarAndTgzEqualTheFolder) {
    const TemporaryFolder folder;
    for (const PackedFile& file : twoFiles()) folder.write("plain/" + file.name, file.content);
    const Scene plain = importScene(folder / "plain/model/scene.gltf");
    for (const auto& [name, packing] :
         {std::pair{"a.zip", Packing::zip}, std::pair{"a.tar", Packing::tar},
          std::pair{"a.tgz", Packing::tgz}}) {
        const Scene scene = importScene(folder.write(name, packed(packing, twoFiles())));
        EXPECT_EQ(triangleCount(scene), 1u) << name;
        EXPECT_EQ(scene.contentHash, plain.contentHash) << name;
        EXPECT_EQ(scene.title, "scene");
    }
}

TEST(ImportArchive, SideFilesAndOtherFiles) {
    const TemporaryFolder folder;
    auto files = twoFiles();
    files.push_back({"__MACOSX/model/._scene.gltf", "what a Mac adds"});
    files.push_back({"model/._scene.gltf", "what a Mac adds"});
    files.push_back({"model/scene.clerestory.json",
                     R"({"probes": [{"name": "middle", "position": [0, 0, 1], "size": 0.5}]})"});
    const Scene scene = importScene(folder.write("a.zip", packed(Packing::zip, files)));
    ASSERT_EQ(scene.probes.size(), 1u);
    EXPECT_EQ(scene.probes[0].name, "middle");
}

TEST(ImportArchive, TheSceneAtTheLeastDepthIsUsed) {
    const TemporaryFolder folder;
    const Scene scene =
        importScene(folder.write("a.zip", packed(Packing::zip, {{"deep/er/other.glb", "no glTF"},
                                                                {"top.glb", triangleGlb()},
                                                                {"top.obj", "no glTF either"}})));
    EXPECT_EQ(scene.title, "top");
}

struct Refused {
    const char* name;
    std::vector<PackedFile> files;
    Reason reason;
    const char* words;
};

TEST(ImportArchive, UnsupportedArchivesAreRejected) {
    const TemporaryFolder folder;
    folder.write("outside.bin", triangleBuffer());
    const std::string gltf = triangleGltf(), longName = std::string(1100, 'n').append(".gltf");
    const Refused rows[] = {
        {"nothing", {{"readme.txt", "words"}}, Reason::unsupported, "no scene file (.gltf"},
        {"two", {{"a.glb", "x"}, {"b.glb", "y"}}, Reason::unsupported, "more than one"},
        {"up", {{"../scene.gltf", gltf}}, Reason::malformed, "leads out"},
        {"up inside", {{"a/../../scene.gltf", gltf}}, Reason::malformed, "leads out"},
        {"absolute", {{"/etc/scene.gltf", gltf}}, Reason::malformed, "relative"},
        {"backslash", {{"a\\..\\scene.gltf", gltf}}, Reason::malformed, "backslash"},
        {"drive", {{"C:scene.gltf", gltf}}, Reason::malformed, "colon"},
        {"twice", {{"s.gltf", gltf}, {"./s.gltf", gltf}}, Reason::malformed, "twice"},
        {"link", {{"s.gltf", gltf}, {"l", "/etc/passwd", true}}, Reason::malformed, "link"},
        {"long name", {{longName, gltf}}, Reason::malformed, "too long"},
        {"uri leads out",
         {{"s.gltf", triangleGltf("../outside.bin")}},
         Reason::malformed,
         "outside.bin"},
        {"uri is absolute",
         {{"s.gltf", triangleGltf((folder / "outside.bin").string())}},
         Reason::malformed,
         ""},
    };
    for (const Refused& row : rows) {
        // A tar keeps names as they are, where a zip's writer mends some.
        const ImportError error = refusal(folder.write("a.tar", packed(Packing::tar, row.files)));
        EXPECT_EQ(nameOf(error.reason()), nameOf(row.reason)) << row.name << ": " << error.what();
        EXPECT_THAT(error.what(), HasSubstr(row.words)) << row.name;
    }
}

TEST(ImportArchive, TruncatedArchivesDoNotCrashTheReader) {
    const TemporaryFolder folder;
    for (const Packing packing : {Packing::zip, Packing::tgz}) {
        const std::string whole = packed(packing, twoFiles());
        const char* name = packing == Packing::zip ? "a.zip" : "a.tgz";
        for (std::size_t size = 0; size < whole.size(); size += whole.size() / 12 + 1) {
            const ImportError error = refusal(folder.write(name, whole.substr(0, size)));
            EXPECT_EQ(nameOf(error.reason()), "malformed") << size << ": " << error.what();
        }
    }
}

TEST(ImportArchive, ArchiveBombsAreLimitedBeforeUnpacking) {
    const TemporaryFolder folder;
    ImportOptions options;
    options.limits.fileBytes = 1 << 20;
    options.limits.maxFiles = 16;
    const auto limited = [&](const std::vector<PackedFile>& files) {
        const std::string bytes = packed(Packing::zip, files);
        EXPECT_LT(bytes.size(), 64u << 10) << "small responses";
        return std::string(nameOf(refusal(folder.write("a.zip", bytes), options).reason()));
    };
    const PackedFile scene{"s.gltf", triangleGltf()};
    EXPECT_EQ(limited({scene, {"zeros", std::string(16 << 20, '\0')}}), "limit");
    std::vector<PackedFile> many{scene}, large{scene};
    for (int i = 0; i < 20; ++i) many.push_back({"f" + std::to_string(i), ""});
    for (int i = 0; i < 6; ++i) {
        large.push_back({"z" + std::to_string(i), std::string(1 << 20, '\0')});
    }
    EXPECT_EQ(limited(many), "limit");
    EXPECT_EQ(limited(large), "limit");
}

}  // namespace
}  // namespace clerestory::test
