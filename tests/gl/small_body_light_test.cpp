// Light next to a body that is small compared with the scene.
#include "support.h"

#include "light/division.h"
#include "light/refinement.h"

#include <cmath>
#include <numbers>

namespace clerestory::test {
namespace {

constexpr double kRadius = 0.125;  // of a ball, metres

class SmallBodies : public GlTest {
protected:
    // Adds a black ball that rests on a grey floor in y = 0, and compares the floor around it with
    // the form factor of a sphere above the horizon: it hides (R / d)^3 of the light of a white sky
    // from a point at the distance d from its centre.
    void expectDarkened(Scene scene, const std::string& id) {
        place(scene, sphere(static_cast<float>(kRadius), 32, addMaterial(scene, lambert(0.0f))),
              glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, kRadius, 0.0)));
        FrameRequest r = request(std::move(scene), id, {0.0, 4.0, 0.0});
        r.camera.target = glm::dvec3(0.0);
        r.camera.up = glm::dvec3(0.0, 0.0, -1.0);
        r.camera.yfov = 0.25;
        r.environment.map = "white";
        r.effects.indirectLight = true;
        ASSERT_TRUE(renderer().completeLight(r).complete);
        const Image image = renderer().render(r).image;
        double squares = 0.0;
        int compared = 0;
        for (std::uint32_t y = 0; y < 64; ++y) {
            for (std::uint32_t x = 0; x < 64; ++x) {
                const double perPixel = 4.0 * std::tan(0.125) / 32.0;
                const double metres = perPixel * std::hypot(x + 0.5 - 32.0, y + 0.5 - 32.0);
                if (metres < 1.2 * kRadius) continue;  // behind the ball
                const double d = std::hypot(metres, kRadius);
                const double expected = 0.5 * (1.0 - std::pow(kRadius / d, 3.0));
                const double off = double{color(image, x, y).x} - expected;
                squares += off * off;
                ++compared;
            }
        }
        ASSERT_GT(compared, 1000);
        EXPECT_LT(std::sqrt(squares / compared), 0.01);
    }
};

const glm::dmat4 kLying =
    glm::rotate(glm::dmat4(1.0), -0.5 * std::numbers::pi, glm::dvec3(1.0, 0.0, 0.0));

std::uint64_t trianglesOf(const Scene& scene, std::size_t instance) {
    return scene.meshes[scene.instances[instance].mesh].primitives;
}

}  // namespace

TEST_F(SmallBodies, DarkenAWideFloor) {
    Scene scene;
    place(scene, quad(50.0f, addMaterial(scene, lambert(0.5f))), kLying);
    expectDarkened(std::move(scene), "wide floor");
}

// Many instances of one mesh, of which the ball is near to few.
TEST_F(SmallBodies, DarkenAFloorOfTiles) {
    Scene scene;
    const Index tile = addMesh(scene, quad(10.0f, addMaterial(scene, lambert(0.5f))));
    for (int x = -2; x <= 2; ++x) {
        for (int z = -2; z <= 2; ++z) {
            addInstance(scene, addNode(scene, "tile", moved(20.0 * x, 0.0, 20.0 * z) * kLying),
                        tile);
        }
    }
    expectDarkened(std::move(scene), "tiled floor");
}

// A floor, walls and furniture are often one box, scaled.
TEST(EdgesOfInstances, AreMeasuredAtEachSize) {
    Scene scene;
    const Index square = addMesh(scene, quad(0.5f, addMaterial(scene, lambert(0.5f))));
    const auto add = [&](double width, double height, double at) {
        const glm::dmat4 world =
            moved(0.0, 0.0, at) * glm::scale(glm::dmat4(1.0), glm::dvec3(width, height, 1.0));
        addInstance(scene, addNode(scene, "square", world), square);
    };
    add(40.0, 40.0, 0.0);
    add(40.0, 40.0, 40.0);
    add(40.0, 4.0, 20.0);
    add(0.1, 0.1, 10.0);
    Variant variant{.name = "other"};
    variant.choices.push_back({square, addMaterial(scene, lambert(0.2f))});
    scene.variants.push_back(variant);
    const Scene fine = light::refined(scene, restPose(scene), {.addedNearBodies = 0}).scene;
    EXPECT_EQ(fine.instances[0].mesh, fine.instances[1].mesh);
    EXPECT_GT(trianglesOf(fine, 0), 4'000u);
    EXPECT_LT(trianglesOf(fine, 2), trianglesOf(fine, 0) / 2);
    EXPECT_GT(trianglesOf(fine, 2), trianglesOf(fine, 0) / 20);
    EXPECT_EQ(trianglesOf(fine, 3), 2u);
    ASSERT_EQ(fine.meshes.size(), 3u);
    EXPECT_EQ(fine.variants[0].choices.size(), 3u);
    for (const Mesh& mesh : fine.meshes) {
        ASSERT_EQ(mesh.flatPartCount, 1u);
        EXPECT_EQ(fine.flatParts[mesh.firstFlatPart].firstCluster, mesh.firstCluster);
    }
}

// As light that is stored on disk has it done.
TEST(EdgesNearBodies, DivideASceneAgain) {
    Scene scene;
    place(scene, quad(50.0f, addMaterial(scene, lambert(0.5f))));
    place(scene, sphere(0.125f, 32, addMaterial(scene, lambert(0.5f))), moved(1.0, 0.0, 0.125));
    const Pose pose = restPose(scene);
    const light::Refined made = light::refined(scene, pose);
    const Scene again = light::refinedWith(made.edges, scene, pose);
    EXPECT_GT(made.scene.indices.size(), 2 * scene.indices.size());
    EXPECT_TRUE(again.indices == made.scene.indices);
    EXPECT_EQ(again.vertices.size(), made.scene.vertices.size());
    for (const glm::dvec3 point : {glm::dvec3(0.0), {0.9, 0.0, 0.0}, {20.0, -3.0, 0.1}}) {
        const double length = made.edges.at(point);
        EXPECT_TRUE(made.edges.below(1.001 * length, point));
        EXPECT_FALSE(made.edges.below(0.999 * length, point));
    }
}

// A flat lamp covers a part of the ceiling that is as bright as the lamp itself.
TEST(EdgesNearBodies, AreNotShorterNearFlatLamps) {
    Scene scene;
    place(scene, quad(50.0f, addMaterial(scene, lambert(0.5f))));
    place(scene, sphere(0.125f, 32, addMaterial(scene, lambert(0.5f))), moved(1.0, 0.0, 0.125));
    const Index lamp = addMaterial(scene, lambert(0.0f, 100.0f));
    place(scene, quad(0.125f, lamp), moved(-1.0, 0.0, 0.01));
    place(scene, sphere(0.125f, 32, lamp),
          moved(-1.0, 0.5, 0.01) * glm::scale(glm::dmat4(1.0), glm::dvec3(1.0, 1.0, 0.005)));
    const light::EdgeLengths edges = light::refined(scene, restPose(scene)).edges;
    ASSERT_EQ(edges.small.size(), 1u);
    EXPECT_EQ(edges.small[0].instance, 1u);
    EXPECT_LT(edges.at({1.0, 0.0, 0.0}), 0.1 * edges.common);
    EXPECT_GT(edges.at({-1.0, 0.0, 0.0}), 4.0 * edges.at({1.0, 0.0, 0.0}));
}

}  // namespace clerestory::test
