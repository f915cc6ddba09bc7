// Uploads: from the body to the frame, rejections and their reasons, what is stored.
#include "tests/http/uploads_support.h"
#include "tests/support/raw_client.h"
#include "tests/support/soon.h"
#include "tests/support/temporary_folder.h"

#include <assimp/version.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <future>
#include <set>

namespace clerestory::test {
namespace {

using testing::HasSubstr;

TEST(Uploads, AreDisabledByDefault) {
    auto client = sharedServer().client();
    const json problem = problemOf(send(client, triangleGlb()), 403);
    EXPECT_THAT(problem["detail"].get<std::string>(), HasSubstr("--uploads"));
    EXPECT_EQ(problemOf(client.Delete("/v1/scenes/six-walls"), 403)["status"], 403);
    EXPECT_EQ(json::parse(client.Get("/v1/renderer")->body)["limits"]["uploadBytes"], 0);
    const auto long_ = send(client, std::string(70'000, 'x'));
    EXPECT_EQ(long_->status, 413) << "the body is not sent needlessly";
    EXPECT_EQ(client.Options("/v1/scenes")->get_header_value("Allow"), "GET, HEAD, POST");
}

TEST(Uploads, AnUploadedSceneIsImportedOnce) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const auto made = send(client, triangleGlb(), "model/gltf-binary", "?title=My%20triangle");
    ASSERT_TRUE(made);
    ASSERT_EQ(made->status, 201) << made->body;
    const std::string id = idOf(made);
    const json scene = json::parse(made->body);
    EXPECT_EQ(scene["id"], id);
    EXPECT_EQ(scene["title"], "My triangle");
    EXPECT_EQ(scene["state"], "ready");
    EXPECT_EQ(scene["uploaded"], true);
    EXPECT_EQ(scene["triangles"], 1);
    const std::string picture = pictureOf(client, id);

    const auto again = send(client, triangleGlb());
    EXPECT_EQ(again->status, 200) << again->body;
    EXPECT_EQ(idOf(again), id);
    EXPECT_EQ(json::parse(again->body)["title"], "My triangle");
    EXPECT_EQ(idOf(send(client, triangleGlb(1))).compare(id) == 0, false);
    EXPECT_EQ(json::parse(client.Get("/v1/renderer")->body)["limits"]["uploadBytes"], 64 << 20);

    // The same triangle in every other dress.
    const std::vector<PackedFile> files = {{"m/scene.gltf", triangleGltf("points.bin")},
                                           {"m/points.bin", triangleBuffer()}};
    for (const auto& [content, type] :
         {std::pair{triangleGltf(), "model/gltf+json"},
          std::pair{packed(Packing::zip, files), "application/zip"},
          std::pair{packed(Packing::tar, files), "application/x-tar"},
          std::pair{packed(Packing::tgz, files), "application/gzip"}}) {
        const auto other = send(client, content, type);
        ASSERT_EQ(other->status, 201) << type << ": " << other->body;
        EXPECT_EQ(pictureOf(client, idOf(other)), picture) << type;
    }
}

TEST(Uploads, DeletedUploadsAreRemovedFromListDiskAndMemory) {
    const Config config = uploadConfig();
    TestServer server(config);
    auto client = server.client();
    const std::string id = idOf(send(client, triangleGlb()));
    EXPECT_THAT(client.Get("/v1/scenes")->body, HasSubstr(id));
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 404);
    problemOf(client.Get("/v1/scenes/" + id), 404);
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    EXPECT_THAT(client.Get("/v1/scenes")->body, testing::Not(HasSubstr(id)));
    EXPECT_EQ(kept(config.scenes.uploads.folder), 0u);
    problemOf(client.Delete("/v1/scenes/six-walls"), 403);
    EXPECT_EQ(send(client, triangleGlb())->status, 201) << "and may come again";
}

// Frames of a deleted, evicted or reloaded scene are not answered from the frame cache.
TEST(Uploads, StoredFramesEndWithTheirScene) {
    // Memory for the default scene and one more.
    std::uint64_t memory = 0;
    {
        TestServer server(uploadConfig());
        server.awaitReady();
        auto client = server.client();
        const auto used = [&] { return server.backend().library().totals().bytes.total(); };
        const std::uint64_t first = used();
        pictureOf(client, idOf(send(client, triangleGlb())));
        const std::uint64_t upload = used() - first;
        pictureOf(client, "orbiting-cubes");
        const std::uint64_t other = used() - first - upload;
        memory = first + std::max(upload, other) + std::min(upload, other) / 2;
    }
    Config config = uploadConfig();
    config.frameCacheBytes = 64 << 20;
    config.scenes.memoryBytes = memory;
    TestServer server(config);
    auto client = server.client();
    const auto isStored = [&](const std::string& id) {
        pictureOf(client, id);  // waits for the scene if it is not loaded
        const auto answer = postJson(client, "/v1/frames", frameOf(id));
        EXPECT_TRUE(answer) << httplib::to_string(answer.error());
        if (!answer) return false;
        EXPECT_EQ(answer->status, 200) << answer->body;
        return answer->has_header("Age");
    };
    const auto entries = [&] {
        const auto answer = client.Get("/metrics");
        EXPECT_TRUE(answer) << httplib::to_string(answer.error());
        if (!answer) return -1;
        const std::string& text = answer->body;
        const std::string name = "\nclerestory_frame_cache_entries ";
        return std::stoi(text.substr(text.find(name) + name.size()));
    };
    const std::string id = idOf(send(client, triangleGlb()));
    const std::string picture = pictureOf(client, id);
    EXPECT_TRUE(isStored(id));
    EXPECT_EQ(entries(), 1);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    EXPECT_EQ(entries(), 0);
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);

    EXPECT_EQ(idOf(send(client, triangleGlb())), id);
    const auto drawn = postJson(client, "/v1/frames", frameOf(id));
    EXPECT_EQ(drawn->status, 200) << drawn->body;
    EXPECT_FALSE(drawn->has_header("Age"));
    EXPECT_EQ(drawn->body, picture);
    EXPECT_TRUE(isStored(id));

    EXPECT_TRUE(isStored("orbiting-cubes"));
    EXPECT_EQ(sceneAt(client, id)["state"], "waiting") << "evicted";
    EXPECT_EQ(entries(), 1);
    EXPECT_EQ(pictureOf(client, id), picture);
    EXPECT_TRUE(isStored(id));
    EXPECT_EQ(entries(), 1);
}

TEST(Uploads, ADeletedSceneStaysUntilItsFrameIsDrawn) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, triangleGlb()));
    auto held = server.holdRenderer();
    std::thread frame([&] {
        auto other = server.client();
        const auto answer = postJson(other, "/v1/frames", frameOf(id));
        ASSERT_TRUE(answer);
        EXPECT_EQ(answer->status, 200) << answer->body;
    });
    EXPECT_TRUE(soon([&] { return server.backend().queue().depth() != 0; }));
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    problemOf(postJson(client, "/v1/frames", frameOf(id)), 404);
    held.reset();
    frame.join();
}

TEST(Uploads, FormatsAreDetectedByContent) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string glb = triangleGlb(), gltf = triangleGltf();
    problemOf(send(client, "v 0 0 0\n"), 415);
    problemOf(send(client, ""), 415);
    problemOf(send(client, glb, "application/zip"), 415);
    problemOf(send(client, gltf, "model/gltf-binary"), 415);
    problemOf(send(client, glb, "text/plain"), 415);
    // A page elsewhere could send these unasked.
    problemOf(send(client, glb, "multipart/form-data; boundary=x"), 415);
    problemOf(send(client, gltf, "application/x-www-form-urlencoded"), 415);
    problemOf(send(client, glb, kAny, "?name=x"), 422);
    EXPECT_EQ(statusOf(ask(server.server().port(),
                           "POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: " +
                               std::to_string((64 << 20) + 1) + "\r\n\r\n")),
              413);
}

// KHR_materials_variants: the triangle glows red in one variant.
TEST(Uploads, VariantsAreSelectedByRequestsAndLinks) {
    json file = json::parse(triangleGltf());
    file["materials"] = {{{"name", "dark"}},
                         {{"name", "red"}, {"emissiveFactor", {1.0, 0.0, 0.0}}}};
    json& primitive = file["meshes"][0]["primitives"][0];
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] = {
        {{"material", 1}, {"variants", {0}}}};
    file["extensions"]["KHR_materials_variants"]["variants"] = {{{"name", "at night"}}};
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, file.dump()));
    const json scene = json::parse(client.Get("/v1/scenes/" + id)->body);
    EXPECT_EQ(scene["variants"], json({"at night"}));
    const auto frame = [&](const std::string& more) {
        return postJson(client, "/v1/frames",
                        R"({"scene": ")" + id + R"(", "width": 24, "height": 24, )" +
                            kPlainEffects + more + "}");
    };
    const auto plain = frame(""), red = frame(R"(, "variant": "at night")");
    ASSERT_EQ(red->status, 200) << red->body;
    EXPECT_NE(red->body, plain->body);
    EXPECT_NE(red->get_header_value("ETag"), plain->get_header_value("ETag"));
    EXPECT_EQ(
        client
            .Get("/v1/frames?scene=" + id + "&width=24&height=24&variant=at%20night" + kPlainLink)
            ->body,
        red->body);
    const json problem = problemOf(frame(R"(, "variant": "night")"), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], "/variant");
    EXPECT_EQ(problem["errors"][0]["allowed"], "one of: at night");
}

// A file with a scene of one triangle and one that is empty but for a second triangle elsewhere.
std::string twoScenes() {
    json file = json::parse(triangleGltf());
    file["nodes"] = {{{"mesh", 0}}, {{"mesh", 0}, {"scale", {1, 3, 1}}}};
    file["scenes"] = {{{"name", "day"}, {"nodes", {0}}}, {{"name", "night"}, {"nodes", {0, 1}}}};
    return file.dump();
}

TEST(Uploads, ScenesOfAFileHaveIds) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, twoScenes())), other = id + ":1";
    const json scene = json::parse(client.Get("/v1/scenes/" + id)->body);
    EXPECT_EQ(scene["triangles"], 1);
    EXPECT_EQ(scene["scenes"],
              json({{{"id", id}, {"name", "day"}}, {{"id", other}, {"name", "night"}}}));
    const auto frame = [&](const std::string& which) {
        return postJson(
            client, "/v1/frames",
            R"({"scene": ")" + which + R"(", "width": 24, "height": 24, )" + kPlainEffects + "}");
    };
    const auto day = frame(id), night = frame(other);
    ASSERT_EQ(night->status, 200) << night->body;
    EXPECT_NE(night->body, day->body);
    EXPECT_EQ(client.Get("/v1/frames?scene=" + other + "&width=24&height=24" + kPlainLink)->body,
              night->body);
    const json described = json::parse(client.Get("/v1/scenes/" + other)->body);
    EXPECT_EQ(described["triangles"], 2);
    EXPECT_EQ(described["scenes"], scene["scenes"]);
    EXPECT_EQ(described["uploaded"], true);
    for (const char* wrong : {":0", ":2", ":", ":01", ":1x"}) problemOf(frame(id + wrong), 404);
    problemOf(client.Delete("/v1/scenes/" + other), 403);
    EXPECT_EQ(client.Delete("/v1/scenes/" + id)->status, 204);
    problemOf(frame(other), 404);
    problemOf(frame(id), 404);
}

// A list for each scene would take memory that grows with the square of their number.
TEST(Uploads, ScenesOfAFileShareOneListOfTheirNames) {
    constexpr std::size_t kScenes = 40;
    json file = json::parse(triangleGltf());
    file["scenes"] = json::array();
    for (std::size_t i = 0; i < kScenes; ++i) {
        file["scenes"].push_back({{"name", "scene " + std::to_string(i)}, {"nodes", {0}}});
    }
    TestServer server(uploadConfig());
    auto client = server.client();
    const std::string id = idOf(send(client, file.dump()));
    pictureOf(client, id + ":1");
    SceneLibrary& library = server.backend().library();
    std::set<const ScenesOfFile*> lists;
    std::size_t scenes = 0;
    for (const SceneStatus& status : library.all()) {
        if (!status.id.starts_with(id)) continue;
        ++scenes;
        lists.insert(status.scenesOfFile.get());
    }
    EXPECT_EQ(scenes, kScenes);
    ASSERT_EQ(lists.size(), 1u);
    ASSERT_TRUE(*lists.begin());
    EXPECT_EQ((*lists.begin())->size(), kScenes);
    const auto loaded = library.find(id + ":1").scene;
    ASSERT_TRUE(loaded);
    EXPECT_TRUE(loaded->scenesOfFile.empty()) << "a loaded scene has no copy of the names";
}

// A pipe in the place of a description blocks a thread that reads the folder.
TEST(Uploads, ASlowDiskDelaysNoHeartbeat) {
    TestServer server(uploadConfig());
    server.awaitReady();
    SceneLibrary& library = server.backend().library();
    const fs::path slow = folderOfThisTest() / ("upload-" + std::string(32, '0'));
    const fs::path pipe = slow / "about.json";
    fs::create_directories(slow);
    std::ofstream(slow / "scene.glb") << "any content";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    auto list = std::async(std::launch::async, [&] { return library.all().size(); });
    int writer = -1;
    ASSERT_TRUE(soon([&] {  // fails as long as no thread reads
        writer = open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
        return writer >= 0;
    }));
    auto heartbeat = std::async(std::launch::async, [&] {
        return library.defaultIsWarm() && !library.loadedContents().empty();
    });
    const bool answered = heartbeat.wait_for(10s) == std::future_status::ready;
    EXPECT_EQ(list.wait_for(0s), std::future_status::timeout) << "the folder is still being read";
    fs::remove_all(slow);
    close(writer);
    EXPECT_TRUE(answered) << "the heartbeat waited for the disk";
    EXPECT_TRUE(heartbeat.get());
    EXPECT_GT(list.get(), 0u);
}

// The scenes of a file in a folder are known when its default scene was loaded.
TEST(Uploads, ScenesOfAFileLoadOnRequest) {
    const TemporaryFolder folder;
    folder.write("town.gltf", twoScenes());
    Config config = testConfig();
    config.scenes.folder = folder.path();
    TestServer server(config);
    auto client = server.client();
    problemOf(client.Get("/v1/scenes/town:1"), 409);
    auto answer = client.Get("/v1/scenes/town:1");
    within(60s, [&] {
        answer = client.Get("/v1/scenes/town:1");
        return answer->status != 409;
    });
    ASSERT_EQ(answer->status, 200) << answer->body;
    EXPECT_EQ(json::parse(answer->body)["title"], "town: night");
    problemOf(client.Get("/v1/scenes/chapel:1"), 404);
}

std::string fileOf(const std::string& name) {
    std::ifstream in(std::string(CLERESTORY_SHARED_SCENES) + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

// One triangle or more in every format of one file, alone and in an archive.
TEST(Uploads, EverySceneFormatIsAccepted) {
    std::vector<std::pair<std::string, std::string>> files = {
        {"stl",
         "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
         "endloop\nendfacet\nendsolid x\n"},
        {"ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
        {"dae", triangleDae()}};
    std::string binary(80, ' ');  // a header, which may begin as that of a text does
    binary.replace(0, 5, "solid");
    const auto append = [&](auto value) {
        binary.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    append(std::uint32_t{1});
    for (const float number : {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}) append(number);
    append(std::uint16_t{0});
    files.emplace_back("stl", binary);
    for (const char* name : {"FormatsFBX/phong_cube.fbx", "FormatsMisc/fels.3ds",
                             "FormatsMisc/cube_binary.ply", "FormatsMisc/Spider_binary.stl"}) {
        const std::string content = fileOf(name);
        if (content.empty()) {
            std::printf("%s is not here and was not sent\n", name);
            continue;
        }
        files.emplace_back(std::string(name).substr(std::string(name).rfind('.') + 1), content);
    }
    TestServer server(uploadConfig());
    auto client = server.client();
    for (const auto& [extension, content] : files) {
        EXPECT_EQ(UploadStore::kindOf(content), extension);
        const auto alone = send(client, content);
        ASSERT_EQ(alone->status, 201) << extension << ": " << alone->body;
        const auto inArchive =
            send(client, packed(Packing::zip, {{"folder/model." + extension, content}}));
        ASSERT_EQ(inArchive->status, 201) << extension << ": " << inArchive->body;
        EXPECT_EQ(pictureOf(client, idOf(alone)), pictureOf(client, idOf(inArchive))) << extension;
    }
    EXPECT_EQ(send(client, files[0].second, "model/stl")->status, 200);
    problemOf(send(client, files[0].second, "model/gltf-binary"), 415);
    // A scene of several files, sent alone: what is missing, and what to send instead.
    const json problem = problemOf(send(client, triangleGltf("triangle.bin")), 422);
    EXPECT_THAT(problem["detail"].get<std::string>(),
                testing::AllOf(HasSubstr("'triangle.bin' is missing"), HasSubstr(".zip")));
    json pictures = json::parse(triangleGltf("triangle.bin"));
    for (int i = 0; i < 9; ++i) {
        pictures["images"].push_back({{"uri", "wall%20" + std::to_string(i) + ".png"}});
    }
    EXPECT_THAT(problemOf(send(client, pictures.dump()), 422)["detail"].get<std::string>(),
                testing::AllOf(HasSubstr("the files 'triangle.bin', 'wall%200.png', "),
                               HasSubstr(" and 4 more are missing"), HasSubstr(".zip")));
}

// A COLLADA camera of 37.8492 degrees, as its file says, in the list of cameras and in the default
// view.
TEST(Uploads, DescriptionsHaveTheFieldOfViewOfColladaCameras) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const auto answer = send(client, triangleDae("<yfov>37.8492</yfov><znear>1</znear>"
                                                 "<zfar>100</zfar>"));
    ASSERT_EQ(answer->status, 201) << answer->body;
    const json scene = sceneAt(client, idOf(answer));
    constexpr double kRadians = 37.8492 * 3.14159265358979 / 180.0;
    ASSERT_EQ(scene["cameras"].size(), 1u);
    EXPECT_NEAR(scene["cameras"][0]["yfov"].get<double>(), kRadians, 1e-5);
    EXPECT_NEAR(scene["defaultView"]["yfov"].get<double>(), kRadians, 1e-5);
}

TEST(Uploads, FilesWithoutASceneAreRejectedWithTheReason) {
    Config config = uploadConfig();
    config.scenes.uploads.limits.count = 4;
    TestServer server(config);
    auto client = server.client();
    const auto reasonOf = [&](const std::string& content) {
        const json problem = problemOf(send(client, content), 422);
        EXPECT_THAT(problem["detail"].get<std::string>(),
                    testing::Not(HasSubstr(config.scenes.uploads.folder.string())));
        return problem.value("reason", "");
    };
    EXPECT_EQ(reasonOf(triangleGlb().substr(0, 100)), "malformed");
    EXPECT_EQ(reasonOf("glTF\2\0\0\0\x0c\0\0\0"), "malformed");
    EXPECT_EQ(reasonOf("{\"asset\": "), "malformed");
    EXPECT_EQ(reasonOf(packed(Packing::zip, {{"readme.txt", "words"}})), "unsupported");
    // The material library of 13 bytes that ends the reader (reliability.md 2.2).
    const std::string poison =
        packed(Packing::zip, {{"a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
                              {"a.mtl", "map_Kd a.png\n"}});
    unsigned held = 0;
    if (aiGetVersionMajor() == 5 && aiGetVersionMinor() <= 2) {  // later ones read it
        EXPECT_EQ(reasonOf(poison), "crashed");
        EXPECT_EQ(reasonOf(poison), "crashed") << "and the next time";
    } else {
        EXPECT_EQ(send(client, poison)->status, 201);
        held = 1;
    }
    EXPECT_EQ(reasonOf(packed(Packing::zip, {{"a.gltf", triangleGltf("../../about.json")}})),
              "malformed");
    EXPECT_EQ(postJson(client, "/v1/frames", smallFrame())->status, 200);
    // They occupy no space of others.
    for (unsigned i = held; i < 4; ++i) EXPECT_EQ(send(client, triangleGlb(i))->status, 201) << i;
    EXPECT_EQ(json::parse(client.Get("/v1/scenes")->body)["scenes"].back()["state"], "ready");
}

TEST(Uploads, ImportTimeAndCountsAreLimited) {
    Config config = uploadConfig();
    config.scenes.uploads.import.cpu = 1s;
    config.scenes.uploads.import.maxTriangles = 100;
    TestServer server(config);
    auto client = server.client();
    EXPECT_EQ(problemOf(send(client, triangleGlb(0, 200)), 422)["reason"], "limit");
    // Very many objects, which the reader's library handles in the square of their number
    // (reliability.md 2.2).
    std::string objects;
    for (int i = 0; i < 60'000; ++i) {
        objects += "o a" + std::to_string(i) + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -3\n";
    }
    const std::string bomb = packed(Packing::zip, {{"a.obj", objects}});
    EXPECT_EQ(problemOf(send(client, bomb), 422)["reason"], "timedOut");
}

TEST(Uploads, UnauthorisedUploadsAreRejectedBeforeTheBody) {
    Config config = uploadConfig();
    const fs::path token = config.scenes.uploads.folder.string() + ".token";
    std::ofstream(token) << "a-token-of-some-length\n";
    fs::permissions(token, fs::perms::owner_read | fs::perms::owner_write);
    config.http.access.tokenFile = token.string();
    TestServer server(config);
    const auto answerTo = [&](const std::string& more) {
        return ask(server.server().port(),
                   "POST /v1/scenes HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000000\r\n" +
                       more + "\r\n",
                   1.0);
    };
    EXPECT_EQ(statusOf(answerTo("")), 401);
    EXPECT_EQ(statusOf(answerTo("Authorization: Bearer another\r\n")), 401);
    const std::string welcome =
        answerTo("Authorization: Bearer a-token-of-some-length\r\nExpect: 100-continue\r\n");
    EXPECT_EQ(statusOf(welcome), 100);
}

TEST(Uploads, AsynchronousUploadsReturnImmediately) {
    TestServer server(uploadConfig());
    auto client = server.client();
    const httplib::Headers headers = {{"Prefer", "respond-async"}};
    const auto accepted = client.Post("/v1/scenes", headers, triangleGlb(), kAny);
    ASSERT_TRUE(accepted);
    ASSERT_THAT(accepted->status, testing::AnyOf(201, 202)) << accepted->body;
    EXPECT_EQ(accepted->get_header_value("Retry-After"), accepted->status == 202 ? "1" : "");
    EXPECT_FALSE(pictureOf(client, idOf(accepted)).empty());
}

}  // namespace
}  // namespace clerestory::test
