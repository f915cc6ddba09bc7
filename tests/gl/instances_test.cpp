// Boxes and pixel counts of instances, compared with arithmetic and with identifiers.
#include "scene/builtin/builtin_scenes.h"
#include "support.h"

namespace clerestory::test {
namespace {

class Instances : public GlTest {};

std::vector<LabelledInstance> instancesOf(FrameRequest r) {
    r.output.channel = Channel::instances;
    r.output.format = OutputFormat::json;
    return renderer().render(r).instances;
}

TEST_F(Instances, VisibleAndAmodalBoxesAreArithmetic) {
    Scene scene;
    Material left, right;
    left.name = "left";
    const Index a = addMaterial(scene, left), b = addMaterial(scene, right);
    place(scene, quad(1.0f, a));                      // pixels 16 to 47
    place(scene, quad(0.5f, b), moved(-0.5, 0, 1));   // 0 to 31, 16 to 47
    place(scene, quad(0.1f, b), moved(0, 0, -1));     // behind the first one
    place(scene, quad(0.5f, b), moved(2.0, 0.5, 0));  // 56 to 71 of 64, 16 to 31
    place(scene, quad(0.5f, b), moved(9.0, 0.0, 0));  // outside
    scene.nodes[0].name = "wall";
    FrameRequest r = request(std::move(scene), "boxes");
    r.output.classes = {{"building", "wall"}};
    const auto found = instancesOf(r);
    ASSERT_EQ(found.size(), 4u);

    EXPECT_EQ(found[0].node, "wall");
    EXPECT_EQ(found[0].materialId, 1u);
    EXPECT_EQ(found[0].classId, 1u);
    EXPECT_EQ(found[0].extent.pixels, 16u * 32u);
    EXPECT_EQ(found[0].extent.pixelsAlone, 32u * 32u);
    EXPECT_EQ(found[0].extent.box, (PixelBox{32, 16, 16, 32}));
    EXPECT_EQ(found[0].extent.boxAlone, (PixelBox{16, 16, 32, 32}));

    EXPECT_EQ(found[1].materialId, 2u);
    EXPECT_EQ(found[1].classId, 0u);
    EXPECT_EQ(found[1].extent.pixels, 32u * 32u);
    EXPECT_EQ(found[1].extent.box, (PixelBox{0, 16, 32, 32}));
    EXPECT_EQ(found[1].extent.boxAlone, found[1].extent.box);

    EXPECT_EQ(found[2].extent.instance, 2u);
    EXPECT_EQ(found[2].extent.pixels, 0u) << "hidden";
    EXPECT_EQ(found[2].extent.box, PixelBox{});
    EXPECT_GT(found[2].extent.pixelsAlone, 0u);

    EXPECT_EQ(found[3].extent.pixels, 8u * 16u) << "the part in the frame";
    EXPECT_EQ(found[3].extent.box, (PixelBox{56, 16, 8, 16}));
}

TEST_F(Instances, AreThoseOfTheIdentifiers) {
    FrameRequest r;
    r.scene = "teapots";
    if (!renderer().hasScene(r.scene)) renderer().addScene(*makeBuiltinScene(r.scene));
    r.width = 160;
    r.height = 90;
    const auto found = instancesOf(r);
    r.output = {.format = OutputFormat::npy, .channel = Channel::objectId};
    const Image ids = renderer().render(r).image;
    std::map<Index, std::uint32_t> counts;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const float id = number(ids, x, y);
            if (id > 0.0f) ++counts[static_cast<Index>(id) - 1];
        }
    }
    EXPECT_GT(counts.size(), 3u);
    std::size_t partly = 0;
    for (const LabelledInstance& each : found) {
        const InstanceExtent& e = each.extent;
        EXPECT_EQ(e.pixels, counts[e.instance]) << each.node;
        EXPECT_LE(e.pixels, e.pixelsAlone);
        EXPECT_LE(e.boxAlone.x, e.box.width > 0 ? e.box.x : e.boxAlone.x);
        partly += e.pixels > 0 && e.pixels < e.pixelsAlone;
        counts.erase(e.instance);
    }
    for (const auto& [instance, count] : counts) EXPECT_EQ(count, 0u) << instance;
    EXPECT_GT(partly, 0u);
}

// Alone in the scene, an instance has the pixels that it has in the frame of all others.
TEST_F(Instances, AmodalPixelsAreThoseOfTheSceneWithoutTheOthers) {
    const auto sceneOf = [](bool alone) {
        Scene scene;
        const Index m = addMaterial(scene, {});
        place(scene, sphere(0.7f, 12, m));
        if (!alone) place(scene, quad(0.6f, m), moved(0.4, 0.2, 0.8));
        return scene;
    };
    const FrameRequest all = request(sceneOf(false), "sphere and quad");
    const auto both = instancesOf(all);
    const auto single = instancesOf(request(sceneOf(true), "sphere alone"));
    ASSERT_EQ(both.size(), 2u);
    ASSERT_EQ(single.size(), 1u);
    EXPECT_LT(both[0].extent.pixels, both[0].extent.pixelsAlone);
    EXPECT_EQ(both[0].extent.pixelsAlone, single[0].extent.pixels);
    EXPECT_EQ(both[0].extent.boxAlone, single[0].extent.box);
}

TEST_F(Instances, HolesOfMasksAreNotCounted) {
    Scene scene;
    Material m;
    m.alphaMode = AlphaMode::mask;
    m.baseColorTexture.texture =
        addTexture2x2(scene, {glm::u8vec4(0), glm::u8vec4(255), glm::u8vec4(255), glm::u8vec4(255)},
                      Wrap::clampToEdge);
    place(scene, quad(1.0f, addMaterial(scene, m)));
    const auto found = instancesOf(request(std::move(scene), "a quarter less"));
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].extent.pixels, 3u * 16u * 16u);
    EXPECT_EQ(found[0].extent.pixelsAlone, 3u * 16u * 16u);
}

TEST_F(Instances, LensesWithoutAMatrixAreRefused) {
    Scene scene;
    place(scene, quad(1.0f, addMaterial(scene, {})));
    FrameRequest r = request(std::move(scene), "lens of instances");
    r.camera.yfov.reset();
    r.camera.lens = EquirectangularLens{};
    try {
        instancesOf(r);
        FAIL();
    } catch (const InvalidRequest& error) {
        ASSERT_EQ(error.errors().size(), 1u);
        EXPECT_EQ(error.errors()[0].pointer, "/camera/lens");
    }
    r.camera.lens = OrthographicLens{4.0};
    ASSERT_EQ(instancesOf(r).size(), 1u);
    EXPECT_EQ(instancesOf(r)[0].extent.pixels, 32u * 32u);
}

}  // namespace
}  // namespace clerestory::test
