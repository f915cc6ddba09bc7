// Whatever happens in the import process, the caller receives a Scene or an ImportError.
#include "scene/import/sandbox/process.h"
#include "tests/unit/import_support.h"

#include <assimp/version.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <algorithm>
#include <chrono>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

// A stand-in for the importing program.
ImportOptions script(const TemporaryFolder& folder, const std::string& lines) {
    const auto file = folder.write("importer", "#!/bin/sh\n" + lines + "\n");
    chmod(file.c_str(), 0700);
    ImportOptions options;
    options.importer = file;
    options.limits.wallClock = std::chrono::seconds(20);
    return options;
}

TEST(ImportProcess, GivesTheSameSceneAsInProcess) {
    const Scene here = importSceneInProcess(ownScene("everything.gltf"));
    const Scene there = importScene(ownScene("everything.gltf"));
    EXPECT_NE(there.contentHash, 0u);
    EXPECT_EQ(there.contentHash, here.contentHash);
    EXPECT_EQ(there.title, "everything");
    EXPECT_EQ(there.warnings.size(), here.warnings.size());
    EXPECT_TRUE(sceneProblems(there).empty());
}

TEST(ImportProcess, ProgressIncreases) {
    std::vector<ImportProgress> steps;
    importScene(ownScene("everything.gltf"), {},
                [&](const ImportProgress& step) { steps.push_back(step); });
    ASSERT_GE(steps.size(), 4u);
    EXPECT_EQ(steps.front().stage, "reading");
    EXPECT_EQ(steps.back().progress, 1.0);
    EXPECT_TRUE(std::is_sorted(steps.begin(), steps.end(), [](const auto& a, const auto& b) {
        return a.progress < b.progress;
    }));
}

TEST(ImportProcess, RejectionsKeepTheirReason) {
    EXPECT_EQ(refusal(ownScene("nothing.gltf")).reason(), Reason::notFound);
    EXPECT_EQ(refusal(ownScene("nothing.obj")).reason(), Reason::notFound);
    EXPECT_EQ(refusal(ownScene("no folder/nothing.obj")).reason(), Reason::notFound);
    EXPECT_EQ(refusal(ownScene("four colours.png")).reason(), Reason::unsupported);
    const TemporaryFolder folder;
    const ImportError error = refusal(folder.write("bad.obj", "v 0 0 0\nf 1 2 3\n"));
    EXPECT_EQ(error.reason(), Reason::malformed);
    EXPECT_EQ(std::string(error.what()).find("/tmp"), std::string::npos) << error.what();
}

TEST(ImportProcess, ACrashIsAnError) {
    const TemporaryFolder folder;
    for (const char* end : {"kill -SEGV $$", "kill -ABRT $$", "exit 1", "exit 0", "exit 3",
                            "echo garbage >&3; exit 0", "echo garbage >&4; exit 3"}) {
        EXPECT_EQ(refusal(ownScene("everything.gltf"), script(folder, end)).reason(),
                  Reason::crashed)
            << end;
    }
}

// Assimp 5.2.5 dereferences a null pointer here; later ones read the file.
TEST(ImportProcess, ACrashInALibraryIsAnError) {
    if (aiGetVersionMajor() > 5 || aiGetVersionMinor() > 2) {
        GTEST_SKIP() << "this Assimp reads what ended 5.2.5";
    }
    const TemporaryFolder folder;
    folder.write("crash.mtl", "map_Kd a.png\n");
    const ImportError error = refusal(
        folder.write("crash.obj", "mtllib crash.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
    EXPECT_EQ(error.reason(), Reason::crashed);
}

// They take a day: the import returns because it stops them.
TEST(ImportProcess, AnEndlessImportIsStopped) {
    const TemporaryFolder folder;
    for (const char* hang : {"exec sleep 86400", "exec 4>&-; exec sleep 86400",
                             "while :; do echo progress 1 x >&4; done"}) {
        ImportOptions options = script(folder, hang);
        options.limits.wallClock = std::chrono::milliseconds(300);
        EXPECT_EQ(refusal(ownScene("everything.gltf"), options).reason(), Reason::timedOut) << hang;
    }
    EXPECT_LT(waitpid(-1, nullptr, WNOHANG), 0) << "no child is left behind";
}

TEST(ImportProcess, ExcessiveMemoryIsAnError) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    GTEST_SKIP() << "a sanitizer's process cannot have its address space limited";
#endif
    const TemporaryFolder folder;
    const auto file = folder.write("zeros.gltf", R"({"asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"componentType": 5126, "count": 8000000, "type": "VEC3"}]})");
    ImportOptions options;
    options.limits.addressSpaceBytes = 300u << 20;
    EXPECT_EQ(refusal(file, options).reason(), Reason::memory);
}

TEST(ImportProcess, AMissingImporterIsReportedAsSuch) {
    ImportOptions options;
    options.importer = "/nowhere/importer";
    EXPECT_THROW(importScene(ownScene("everything.gltf"), options), std::runtime_error);
}

TEST(ImportWire, LinesRoundTripOrAreIgnored) {
    const auto step = readProgress("progress 250 transferring");
    ASSERT_TRUE(step);
    EXPECT_EQ(step->stage, "transferring");
    EXPECT_EQ(step->progress, 0.25);
    for (const char* line : {"", "progress", "progress x", "progress 2000 a", "progress -1 a",
                             "error", "error what ever", "progress 1"}) {
        EXPECT_FALSE(readProgress(line)) << line;
        EXPECT_FALSE(readError(line)) << line;
    }
    const std::string line = errorLine(Reason::limit, "two\nlines");
    const auto error = readError(line.substr(0, line.size() - 1));
    ASSERT_TRUE(error);
    EXPECT_EQ(error->reason(), Reason::limit);
    EXPECT_STREQ(error->what(), "two?lines");

    ImportLimits limits;
    limits.cpu = std::chrono::seconds(7);
    limits.maxImagePixels = 99;
    EXPECT_EQ(decodedLimits(encoded(limits)).cpu.count(), 7);
    EXPECT_EQ(decodedLimits(encoded(limits)).maxImagePixels, 99u);
    EXPECT_EQ(decodedLimits("").maxTriangles, ImportLimits{}.maxTriangles);
}

}  // namespace
}  // namespace clerestory
