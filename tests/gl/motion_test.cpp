// Animated scenes: a moment equals the same static scene, independent of earlier frames, for every
// technique; only meshes that moved are uploaded.
#include "reference/reference.h"
#include "scene/builtin/builtin_scenes.h"
#include "support.h"

#include <glm/gtc/matrix_transform.hpp>

namespace clerestory::test {
namespace {

class AnimatedFrames : public GlTest {};

// The moment as a scene in which nothing moves.
Scene frozen(Scene scene, double time) {
    const Pose pose = poseAt(scene, time);
    for (const Deformation& d : scene.deformations) {
        Mesh& mesh = scene.meshes[d.mesh];
        const DeformedMesh& deformed = *deformedMesh(pose, mesh);
        std::copy(deformed.vertices.begin(), deformed.vertices.end(),
                  scene.vertices.begin() + d.firstVertex);
        mesh.bounds = deformed.bounds;
        for (std::uint32_t c = 0; c < mesh.clusterCount; ++c) {
            scene.clusters[mesh.firstCluster + c].bounds = deformed.clusters[c];
        }
        mesh.deformation = kNone;
    }
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
        scene.nodes[i] = {scene.nodes[i].name, kNone, pose.worldFromNode[i]};
    }
    scene.clips.clear();
    scene.movingNodes.clear();
    scene.deformations.clear();
    scene.skins.clear();
    scene.morphWeights.clear();
    updateContentHash(scene);
    return scene;
}

FrameRequest small(const std::string& scene, double time = 0.0) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.scene = scene;
    r.time = time;
    r.width = 160;
    r.height = 90;
    r.output.format = OutputFormat::npy;
    return r;
}

Scene meadowAs(const std::string& id) {
    Scene scene = *makeBuiltinScene("meadow");
    scene.id = id;
    return scene;
}

TEST_F(AnimatedFrames, AMomentEqualsTheStaticScene) {
    renderer().addScene(meadowAs("moving"));
    renderer().addScene(frozen(meadowAs("frozen"), 0.7));
    FrameRequest r = small("moving", 0.7);
    const auto same = [&](const char* how) {
        r.scene = "moving";
        r.time = 3.1;
        renderer().render(r);  // what the buffers hold is of another moment
        r.time = 0.7;
        const Image moving = renderer().render(r).image;
        r.scene = "frozen";
        r.time = 0.0;
        EXPECT_EQ(differing(moving, renderer().render(r).image), 0u) << how;
    };
    r.accuracy.planar = PlanarMethod::mirror;
    r.accuracy.curved = CurvedMethod::probe;
    same("a mirrored view and a captured cube");
    r.output.channel = Channel::normal;
    same("normals");
    r.output.channel = Channel::depth;
    same("depth");
    renderer().removeScene("moving");
    renderer().removeScene("frozen");
}

// Rays: the hierarchies of the two are built differently, so edges may fall to either side.
TEST_F(AnimatedFrames, RaysHitMovingObjects) {
    renderer().addScene(meadowAs("moving"));
    renderer().addScene(frozen(meadowAs("frozen"), 0.7));
    FrameRequest r = small("moving", 3.1);
    r.accuracy.planar = PlanarMethod::traced;
    r.accuracy.curved = CurvedMethod::traced;
    r.accuracy.bounces = 2;
    const Image other = renderer().render(r).image;
    r.time = 0.7;
    const Image moving = renderer().render(r).image;
    EXPECT_GT(differing(moving, other), 100u);
    r.scene = "frozen";
    r.time = 0.0;
    EXPECT_LT(differing(moving, renderer().render(r).image), 15u) << "of 14400";
    renderer().removeScene("moving");
    renderer().removeScene("frozen");
}

TEST_F(AnimatedFrames, EarlierRequestsDoNotMatter) {
    renderer().addScene(meadowAs("moving"));
    FrameRequest r = small("moving");
    const auto at = [&](double time) {
        r.time = time;
        return renderer().render(r).image;
    };
    const Image first = at(0.0);
    const Image later = at(1.0);
    EXPECT_GT(differing(first, later), 100u);
    EXPECT_EQ(differing(first, at(0.0)), 0u);
    renderer().forgetMaps();
    EXPECT_EQ(differing(later, at(1.0)), 0u) << "with redrawn maps";
    EXPECT_EQ(differing(first, at(0.0)), 0u);
    r.clip = "";
    EXPECT_EQ(differing(at(0.0), at(5.0)), 0u) << "without a clip nothing moves";
    renderer().removeScene("moving");
}

// No shadows, no light from one to another: what stands still keeps its very bits.
TEST_F(AnimatedFrames, OnlyMovedObjectsAndTheirReflectionsChange) {
    renderer().addScene(meadowAs("moving"));
    FrameRequest r = small("moving");
    r.clip = "lanterns";
    r.accuracy.curved = CurvedMethod::probe;
    const auto at = [&](double time, Channel channel) {
        r.time = time;
        r.output.channel = channel;
        return renderer().render(r).image;
    };
    const Image a = at(0.0, Channel::color), b = at(1.3, Channel::color);
    const Image idA = at(0.0, Channel::objectId), idB = at(1.3, Channel::objectId);
    const Image seenAs = at(0.0, Channel::through);
    const Scene scene = meadowAs("meadow");
    const auto isLantern = [&](float id) {
        const auto instance = static_cast<std::size_t>(id) - 1;
        return id >= 1 && scene.nodes[scene.instances[instance].node].name.starts_with("lantern");
    };
    std::size_t direct = 0, mirrored = 0, elsewhere = 0;
    for (std::uint32_t y = 0; y < a.height; ++y) {
        for (std::uint32_t x = 0; x < a.width; ++x) {
            if (color(a, x, y) == color(b, x, y)) continue;
            const bool moved = isLantern(number(idA, x, y)) || isLantern(number(idB, x, y));
            const bool mirror = number(seenAs, x, y) >= 3;
            ++(moved ? direct : mirror ? mirrored : elsewhere);
        }
    }
    EXPECT_GT(direct, 50u);
    EXPECT_GT(mirrored, 20u) << "in the ball, in the tall mirror";
    EXPECT_EQ(elsewhere, 0u);
    renderer().removeScene("moving");
}

TEST_F(AnimatedFrames, TheMirrorBallShowsAllEightCubesAtAnyTime) {
    Scene scene = *makeBuiltinScene("orbiting-cubes");
    scene.id = "cubes";
    float ball = 0.0f;
    for (std::size_t i = 0; i < scene.instances.size(); ++i) {
        const std::string& name = scene.nodes[scene.instances[i].node].name;
        if (name == "mirrored ball") ball = static_cast<float>(i + 1);
    }
    renderer().addScene(std::move(scene));
    // From above no cube stands before the ball, nor so far behind it that its image is thinner
    // than a pixel.
    FrameRequest r = small("cubes");
    r.width = 320;
    r.height = 180;
    r.camera.position = glm::dvec3(0.0, 9.0, 0.0);
    r.camera.target = glm::dvec3(0.0, 1.25, 0.0);
    for (const double time : {0.0, 0.6, 5.3}) {
        r.time = time;
        r.output.channel = Channel::objectId;
        const Image ids = renderer().render(r).image;
        r.output.channel = Channel::color;
        const Image plain = renderer().render(r).image;
        for (int i = 1; i <= 8; ++i) {
            // That cube glows: where the ball turns brighter, the ball shows it.
            FrameRequest lit = r;
            lit.overrides = {{.material = "cube " + std::to_string(i),
                              .emissive = glm::dvec3(1.0),
                              .emissiveStrength = 50.0}};
            const Image glowing = renderer().render(lit).image;
            std::size_t shown = 0;
            for (std::uint32_t y = 0; y < r.height; ++y) {
                for (std::uint32_t x = 0; x < r.width; ++x) {
                    const bool onBall = number(ids, x, y) == ball;
                    shown += onBall && color(glowing, x, y).g > color(plain, x, y).g + 10.0f;
                }
            }
            EXPECT_GE(shown, 8u) << "cube " << i << " at " << time << " s";
        }
    }
    renderer().removeScene("cubes");
}

TEST_F(AnimatedFrames, OnlyMovedMeshesAreUploaded) {
    renderer().addScene(meadowAs("moving"));
    const auto uploadsOf = [&](const FrameRequest& r) {
        const std::uint64_t before = renderer().counters().meshesMoved;
        renderer().render(r);
        return renderer().counters().meshesMoved - before;
    };
    FrameRequest r = small("moving", 0.3);
    EXPECT_EQ(uploadsOf(r), 2u) << "the flag and the fox";
    EXPECT_EQ(uploadsOf(r), 0u) << "the same moment";
    r.camera.position = glm::dvec3(1, 2, 6);
    r.camera.target = glm::dvec3(0, 1, 0);
    EXPECT_EQ(uploadsOf(r), 0u) << "from elsewhere";
    r.time = 0.3 + 1.2 * 2.0;  // the fox's legs as before, the flag not
    r.clip = "walk";
    uploadsOf(r);
    r.clip = "flag";
    EXPECT_EQ(uploadsOf(r), 2u) << "the fox goes to rest";
    r.time += 0.1;
    EXPECT_EQ(uploadsOf(r), 1u) << "the flag alone";
    r.clip = "lanterns";
    uploadsOf(r);
    r.time += 0.1;
    EXPECT_EQ(uploadsOf(r), 0u) << "rigid things move by their nodes";
    renderer().removeScene("moving");

    Scene still = *makeBuiltinScene("teapots");
    still.id = "still";
    renderer().addScene(std::move(still));
    const RendererCounters before = renderer().counters();
    renderer().render(small("still", 0.0));
    const RendererCounters between = renderer().counters();
    renderer().render(small("still", 4.0));
    const RendererCounters after = renderer().counters();
    EXPECT_EQ(after.meshesMoved, before.meshesMoved);
    EXPECT_LE(after.drawCalls - between.drawCalls, between.drawCalls - before.drawCalls);
    renderer().removeScene("still");
}

TEST_F(AnimatedFrames, TheReferenceSeesTheSameMoment) {
    const Scene scene = meadowAs("moving");
    renderer().addScene(meadowAs("moving"));
    FrameRequest r = small("moving", 2.3);
    r.width = 96;
    r.height = 54;
    r.output.channel = Channel::objectId;
    const Image ids = renderer().render(r).image;
    r.output.channel = Channel::color;
    const std::optional<EnvironmentMap> map = builtinEnvironment("sky");
    const auto truth = traceReference(
        {.scene = scene, .frame = r, .environment = *map, .samples = 2, .threads = 2}, {});
    ASSERT_TRUE(truth);
    std::size_t others = 0;
    for (std::uint32_t y = 0; y < r.height; ++y) {
        for (std::uint32_t x = 0; x < r.width; ++x) {
            const auto id = static_cast<std::uint32_t>(number(ids, x, y));
            others += truth->objectId[std::size_t{y} * r.width + x] != id ? 1 : 0;
        }
    }
    EXPECT_LT(others, 12u) << "of 5184: edges";
    renderer().removeScene("moving");
}

TEST_F(AnimatedFrames, UnknownClipsListTheExistingOnes) {
    renderer().addScene(meadowAs("moving"));
    FrameRequest r = small("moving");
    r.clip = "gallop";
    try {
        renderer().render(r);
        FAIL();
    } catch (const InvalidRequest& error) {
        ASSERT_EQ(error.errors().size(), 1u);
        EXPECT_EQ(error.errors()[0].pointer, "/clip");
        EXPECT_EQ(error.errors()[0].allowed, "one of: flag, walk, round, lanterns");
    }
    renderer().removeScene("moving");
}

}  // namespace
}  // namespace clerestory::test
