// The path tracer's intersections compared with a linear search; and threads, seeds, cancellation,
// noise and invalid requests.
#include "reference_support.h"

#include "plan/visibility/view.h"
#include "reference/sampler.h"
#include "reference/scene_geometry.h"

#include <gmock/gmock.h>

#include <cstring>

namespace clerestory::test {
namespace {

using reference::Sampler;

// The least distance beyond 0 at which the ray passes through a triangle on a side that is met
// (Möller and Trumbore 1997), in double.
double nearestByLoop(const reference::SceneGeometry& geometry, const reference::Ray& ray) {
    double nearest = 1e30;
    for (const auto& t : geometry.triangles()) {
        const glm::dvec3 e1 = glm::dvec3(t.b) - glm::dvec3(t.a),
                         e2 = glm::dvec3(t.c) - glm::dvec3(t.a);
        const glm::dvec3 p = glm::cross(ray.direction, e2);
        const double volume = glm::dot(e1, p);  // above 0: counter-clockwise
        if (volume == 0.0 || volume * t.side < 0.0) continue;
        const glm::dvec3 s = ray.origin - glm::dvec3(t.a), q = glm::cross(s, e1);
        const double u = glm::dot(s, p) / volume, v = glm::dot(ray.direction, q) / volume;
        const double distance = glm::dot(e2, q) / volume;
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && distance > 0.0) {
            nearest = std::min(nearest, distance);
        }
    }
    return nearest;
}

Scene rubble(int count) {
    Scene scene;
    Material oneSided = chalk(0.5f), twoSided = chalk(0.5f);
    twoSided.doubleSided = true;
    const Index materials[] = {addMaterial(scene, oneSided), addMaterial(scene, twoSided)};
    for (int m = 0; m < 2; ++m) {
        MeshDraft draft{.name = "rubble", .material = materials[m]};
        for (int i = 0; i < 3 * count; ++i) {
            Sampler sampler(5, std::uint64_t(m), std::uint32_t(i / 3));
            const glm::dvec2 a = sampler.get2D(), b = sampler.get2D();
            Sampler corner(6, std::uint64_t(m), std::uint32_t(i));
            const glm::dvec2 c = corner.get2D(), d = corner.get2D();
            draft.vertices.push_back(
                {.position = glm::vec3(4.0 * glm::dvec3(a, b.x) + glm::dvec3(c, d.x) - 2.5)});
            draft.indices.push_back(std::uint32_t(i));
        }
        placeAt(scene, addMesh(scene, std::move(draft)),
                glm::scale(glm::dmat4(1.0), {m == 0 ? -1.0 : 1.0, 1.0, 1.0}));
    }
    return scene;
}

TEST(ReferenceGeometry, MatchesALinearSearchOverTriangles) {
    const Scene scene = rubble(300);
    const Pose pose = poseAt(scene, 0.0);
    const MaterialBindings materials;
    const reference::SceneGeometry geometry(scene, pose, materials, Effects{});
    ASSERT_EQ(geometry.triangleCount(), 600u);
    int met = 0;
    for (std::uint32_t i = 0; i < 4000; ++i) {
        Sampler sampler(9, 9, i);
        const glm::dvec2 a = sampler.get2D(), b = sampler.get2D(), c = sampler.get2D();
        const reference::Ray ray{
            .origin = 5.0 * glm::dvec3(a, b.x) - 2.5,
            .direction = glm::normalize(glm::dvec3(b.y, c) - 0.5 + glm::dvec3(1e-3))};
        const auto hit = geometry.intersect(ray);
        const double expected = nearestByLoop(geometry, ray);
        EXPECT_EQ(geometry.occluded(ray), expected < 1e30);
        ASSERT_EQ(hit.has_value(), expected < 1e30) << "ray " << i;
        if (!hit) continue;
        EXPECT_NEAR(hit->distance, expected, 1e-5);
        ++met;
    }
    EXPECT_GT(met, 1500);
}

TEST(ReferenceGeometry, DropsTrianglesWithoutArea) {
    Scene scene = rubble(10);
    for (int i = 0; i < 3; ++i) scene.vertices[i].position = glm::vec3(1.0f);
    const MaterialBindings materials;
    EXPECT_EQ(
        reference::SceneGeometry(scene, poseAt(scene, 0.0), materials, Effects{}).triangleCount(),
        19u);
}

Scene mixedScene() {
    Scene scene = ballScene({.metallic = 1.0f, .roughness = 0.3f}, 24);
    const Index box = addBoxMesh(scene, "box", addMaterial(scene, chalk(0.7f)));
    place(scene, box, {2.0, 0.0, -1.0}, 0.7);
    return scene;
}

FrameRequest mixedRequest() {
    FrameRequest frame = lookingFrom({0.5, 1.0, 6.0});
    frame.width = 40;
    frame.height = 24;
    return frame;
}

bool sameBytes(const Image& a, const Image& b) {
    return a.data.size() == b.data.size() &&
           std::memcmp(a.data.data(), b.data.data(), a.data.size()) == 0;
}

TEST(ReferencePicture, IsIndependentOfThreadCount) {
    const Scene scene = mixedScene();
    for (const ReferenceMode mode : {ReferenceMode::effects, ReferenceMode::full}) {
        const auto with = [&](std::uint32_t threads, std::uint64_t seed) {
            return traced(scene, mixedRequest(), skyEnvironment(), mode, 8, threads, seed);
        };
        const ReferenceImage one = with(1, 1), four = with(4, 1), other = with(4, 2);
        EXPECT_TRUE(sameBytes(one.color, four.color));
        EXPECT_TRUE(sameBytes(one.noise, four.noise));
        EXPECT_EQ(one.objectId, four.objectId);
        EXPECT_FALSE(sameBytes(one.color, other.color));
    }
}

TEST(ReferencePicture, FirstHitsAreClassified) {
    const ReferenceImage image =
        traced(mixedScene(), mixedRequest(), skyEnvironment(), ReferenceMode::effects, 2);
    const std::size_t middle = 12 * 40 + 17;
    EXPECT_EQ(image.objectId[middle], 1u);
    EXPECT_EQ(image.firstHit[middle], FirstHit::curvedMirror);
    EXPECT_EQ(image.objectId[0], 0u);
    EXPECT_EQ(image.firstHit[0], FirstHit::nothing);
    EXPECT_THAT(image.objectId, testing::Contains(2u));
    EXPECT_THAT(image.firstHit, testing::Contains(FirstHit::surface));
}

// The claimed noise against the distance from many more samples.
TEST(ReferencePicture, NoiseEstimateMatchesTheError) {
    const Scene scene = mixedScene();
    for (const std::uint32_t samples : {8u, 64u}) {
        const ReferenceImage few =
            traced(scene, mixedRequest(), skyEnvironment(), ReferenceMode::full, samples, 2);
        const ReferenceImage many =
            traced(scene, mixedRequest(), skyEnvironment(), ReferenceMode::full, 1024, 2, 77);
        double sum = 0.0;
        const std::size_t numbers = 3 * few.objectId.size();
        for (std::size_t i = 0; i < numbers; ++i) {
            sum += std::pow(few.color.floats()[i] - many.color.floats()[i], 2.0);
        }
        const double truth = std::sqrt(sum / double(numbers));
        EXPECT_GT(few.noiseFloor, 0.6 * truth);
        EXPECT_LT(few.noiseFloor, 1.7 * truth);
        EXPECT_EQ(few.samples, samples);
    }
}

TEST(ReferencePicture, ReportsAndCanBeCancelled) {
    const Scene scene = mixedScene();
    const FrameRequest frame = mixedRequest();
    const EnvironmentMap map = uniformMap(1.0f);
    ReferenceRequest request{.scene = scene, .frame = frame, .environment = map, .samples = 3};
    std::vector<double> shares;
    const auto image = traceReference(request, [&](double share) {
        shares.push_back(share);
        return true;
    });
    ASSERT_TRUE(image.has_value());
    EXPECT_EQ(image->samples, 4u);
    EXPECT_EQ(shares.front(), 0.0);
    EXPECT_EQ(shares.back(), 1.0);
    EXPECT_TRUE(std::is_sorted(shares.begin(), shares.end()));

    request.samples = kMaxReferenceSamples;  // hours
    int calls = 0;
    EXPECT_FALSE(traceReference(request, [&](double) { return ++calls < 2; }).has_value());
    EXPECT_EQ(calls, 2);
    EXPECT_FALSE(traceReference(request, [](double) { return false; }).has_value());
}

TEST(ReferencePicture, InvalidRequestsAreRejected) {
    Scene scene = mixedScene();
    FrameRequest frame = mixedRequest();
    const EnvironmentMap map = uniformMap(1.0f);
    ReferenceRequest request{.scene = scene, .frame = frame, .environment = map, .samples = 1};
    EXPECT_THROW(traceReference(request), std::invalid_argument);
    request.samples = 2;
    frame.camera = {};
    frame.camera.name = "unknown";
    EXPECT_THROW(traceReference(request), InvalidRequest);
    frame.camera = {};
    scene.images.push_back({.name = "gone", .width = 2, .height = 2, .levels = 2});
    EXPECT_THROW(traceReference(request), std::invalid_argument);
}

TEST(ReferencePicture, EmptyScenesShowTheEnvironment) {
    const ReferenceImage image =
        traced(Scene{}, narrow({0, 0, 5}, {0, 0, 0}), uniformMap(0.5f), ReferenceMode::full, 2);
    EXPECT_FLOAT_EQ(float(meanColor(image).x), 0.5f);
    EXPECT_EQ(image.noiseFloor, 0.0);
}

}  // namespace
}  // namespace clerestory::test
