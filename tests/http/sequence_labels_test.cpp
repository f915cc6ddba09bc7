// Labels of sequences: each file equals a single response.
#include "tests/http/sequences_support.h"

#include <gmock/gmock.h>

#include <cstring>
#include <map>

namespace clerestory::test {
namespace {

using nlohmann::json;

TEST(SequenceLabels, LabelsAndPositionsAreFilesToo) {
    sharedServer().awaitReady();
    auto client = sharedServer().client();
    const json scene = json::parse(client.Get("/v1/scenes/six-walls")->body);
    EXPECT_EQ(scene["materials"].size(), scene["counts"]["materials"]);
    const json on = {{"color", false},
                     {"position", true},
                     {"albedo", true},
                     {"materialId", true},
                     {"classId", true}};
    const json classes = {{{"name", "everything"}, {"pattern", "*"}}};
    const json body =
        orbit(1, {{"channels", on}, {"common", {{"output", {{"classes", classes}}}}}});
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const Files files = filesOfTar(result->body);
    for (const std::string name : {"position", "albedo", "materialId", "classId"}) {
        json single = body["common"];
        single.update(body["frames"][0]);
        single["output"].update({{"channel", name}, {"format", "npy"}});
        const auto frame = postJson(client, "/v1/frames", single.dump());
        ASSERT_EQ(frame->status, 200) << frame->body;
        EXPECT_EQ(fileOf(files, "000000." + name + ".npy"), frame->body) << name;
        const bool isVector = name == "position" || name == "albedo";
        EXPECT_THAT(frame->body.substr(0, 128),
                    testing::HasSubstr(isVector ? "(48, 64, 3)" : "(48, 64, 1)"));
        if (name == "classId") continue;
        const auto link = client.Get(
            "/v1/frames?scene=six-walls&width=64&height=48&position=0,1,2&"
            "target=0,1,0&format=npy&channel=" +
            name);
        EXPECT_EQ(link->body, frame->body) << name;
    }
}

// What a wall reflects when it is a mirror: the room, behind the wall itself.
TEST(SequenceLabels, LayersAreFilesToo) {
    auto client = sharedServer().client();
    const json mirrors = {{{"material", "wall -Z"}, {"metallic", 1}, {"roughness", 0}}};
    const json body = orbit(1, {{"channels", {{"color", false}, {"depth", true}}},
                                {"layers", {{"reflected", true}, {"refracted", true}}},
                                {"common", {{"overrides", mirrors}}}});
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const Files files = filesOfTar(result->body);
    std::map<std::string, std::string> layers;
    for (const std::string layer : {"direct", "reflected", "refracted"}) {
        json single = body["common"];
        single.update(body["frames"][0]);
        single["output"] = {{"channel", "depth"}, {"format", "npy"}, {"layer", layer}};
        const auto frame = postJson(client, "/v1/frames", single.dump());
        ASSERT_EQ(frame->status, 200) << frame->body;
        layers[layer] = frame->body;
        const std::string name = layer == "direct" ? "" : layer + ".";
        EXPECT_EQ(fileOf(files, "000000." + name + "depth.npy"), frame->body) << layer;
    }
    const Image direct = decodeNpy(layers["direct"]), reflected = decodeNpy(layers["reflected"]);
    const Image refracted = decodeNpy(layers["refracted"]);
    std::size_t deeper = 0;
    for (std::size_t i = 0; i < 64 * 48; ++i) {
        deeper += reflected.floats()[i] > direct.floats()[i];
        EXPECT_EQ(refracted.floats()[i], 0.0f) << "there is no glass";
    }
    EXPECT_GT(deeper, 64u * 48u / 4u);

    const json problem =
        problemOf(client.Get("/v1/frames?channel=through&output.layer=reflected&format=npy"), 422);
    EXPECT_EQ(problem["errors"][0]["pointer"], "/output/layer");
}

TEST(SequenceLabels, LayersHaveFlowAndInstances) {
    auto client = sharedServer().client();
    const json mirrors = {{{"material", "wall -Z"}, {"metallic", 1}, {"roughness", 0}}};
    json body = orbit(2, {{"channels", {{"color", false}, {"flow", true}, {"instances", true}}},
                          {"layers", {{"reflected", true}}},
                          {"common", {{"overrides", mirrors}}}});
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const Files files = filesOfTar(result->body);
    json single = body["common"];
    single.update(body["frames"][0]);
    single["output"] = {{"channel", "flow"},
                        {"format", "npy"},
                        {"layer", "reflected"},
                        {"flow", {{"time", 0}, {"camera", body["frames"][1]["camera"]}}}};
    const auto frame = postJson(client, "/v1/frames", single.dump());
    ASSERT_EQ(frame->status, 200) << frame->body;
    EXPECT_EQ(fileOf(files, "000000.reflected.flow.npy"), frame->body);
    EXPECT_NE(fileOf(files, "000000.flow.npy"), frame->body);
    const json seen = json::parse(fileOf(files, "000000.reflected.instances.json"));
    std::uint32_t pixels = 0;
    for (const json& instance : seen["instances"]) {
        pixels += instance["pixels"].get<std::uint32_t>();
        EXPECT_GE(instance["amodalPixels"], instance["pixels"]) << instance;
    }
    EXPECT_GT(pixels, 64u * 48u / 4u);
    // A panorama has layers of instances, though none of the direct layer.
    single["output"] = {{"channel", "instances"}, {"format", "json"}, {"layer", "reflected"}};
    single["camera"]["lens"] = {{"type", "equirectangular"}};
    const auto panorama = postJson(client, "/v1/frames", single.dump());
    ASSERT_EQ(panorama->status, 200) << panorama->body;
    EXPECT_GT(json::parse(panorama->body)["instances"].size(), 1u);
}

TEST(SequenceLabels, FlowConnectsNeighbours) {
    auto client = sharedServer().client();
    const json body =
        orbit(3, {{"channels", {{"color", false}, {"flow", true}, {"flowBack", true}}}});
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const Files files = filesOfTar(result->body);
    std::vector<std::string> names;
    for (const auto& [name, content] : files) names.push_back(name);
    EXPECT_THAT(names, testing::ElementsAre("000000.flow.npy", "000000.json", "000001.flow.npy",
                                            "000001.flowBack.npy", "000001.json",
                                            "000002.flowBack.npy", "000002.json", "manifest.json"));
    const auto single = [&](int from, int to) {
        json frame = body["common"];
        frame.update(body["frames"][from]);
        frame["output"] = {{"channel", "flow"},
                           {"format", "npy"},
                           {"flow", {{"time", 0}, {"camera", body["frames"][to]["camera"]}}}};
        const auto answer = postJson(client, "/v1/frames", frame.dump());
        EXPECT_EQ(answer->status, 200) << answer->body;
        return answer->body;
    };
    EXPECT_EQ(fileOf(files, "000001.flow.npy"), single(1, 2));
    EXPECT_EQ(fileOf(files, "000001.flowBack.npy"), single(1, 0));
    EXPECT_NE(single(1, 2), single(1, 0));
    EXPECT_THAT(single(0, 1).substr(0, 128), testing::HasSubstr("(48, 64, 3)"));
    const auto link = client.Get(
        "/v1/frames?scene=six-walls&width=64&height=48&position=0,1,2&target=0,1,0&"
        "format=npy&channel=flow&output.flow.time=1");
    EXPECT_EQ(link->status, 200) << link->body;
}

TEST(SequenceLabels, InstancesAreJson) {
    auto client = sharedServer().client();
    json body = orbit(1, {{"channels", {{"objectId", true}, {"instances", true}}}});
    body["common"]["output"]["classes"] = {{{"name", "wall"}, {"pattern", "wall*"}}};
    const auto result = postJson(client, "/v1/sequences", body.dump());
    ASSERT_EQ(result->status, 200) << result->body;
    const Files files = filesOfTar(result->body);
    const std::string text = fileOf(files, "000000.instances.json");
    const json found = json::parse(text);
    EXPECT_EQ(found["width"], 64);
    EXPECT_EQ(found["classes"], json({"wall"}));
    ASSERT_GT(found["instances"].size(), 2u);
    // The counts of the identifiers' file, whose header has 128 bytes.
    const std::string npy = fileOf(files, "000000.objectId.npy");
    std::vector<float> ids(64 * 48);
    std::memcpy(ids.data(), npy.data() + 128, ids.size() * sizeof(float));
    for (const json& each : found["instances"]) {
        const float id = each["objectId"].get<float>();
        EXPECT_EQ(each["pixels"], std::count(ids.begin(), ids.end(), id)) << each;
        EXPECT_EQ(each["worldFromModel"].size(), 16u);
        EXPECT_LE(each["visibleShare"], 1.0);
        const bool wall = each["node"].get<std::string>().starts_with("wall");
        EXPECT_EQ(each.value("class", ""), wall ? "wall" : "") << each;
    }
    json single = body["common"];
    single.update(body["frames"][0]);
    single["output"].update({{"channel", "instances"}, {"format", "json"}});
    const auto frame = postJson(client, "/v1/frames", single.dump());
    EXPECT_EQ(frame->status, 200) << frame->body;
    EXPECT_EQ(frame->get_header_value("Content-Type"), "application/json");
    EXPECT_EQ(frame->body, text);
    single["output"]["format"] = "npy";
    const auto wrong = postJson(client, "/v1/frames", single.dump());
    EXPECT_EQ(wrong->status, 422);
    EXPECT_THAT(wrong->body, testing::HasSubstr("/output/format"));
}

}  // namespace
}  // namespace clerestory::test
