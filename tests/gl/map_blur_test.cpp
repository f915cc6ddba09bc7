// The Gaussian blur of cubes: kernel, energy, edges, and the materials and probes that request it.
#include "support.h"

#include "passes/cube_samples.h"
#include "passes/passes.h"

#include <gmock/gmock.h>

#include <random>

namespace clerestory::test {
namespace {

class MapBlurs : public GlTest {
protected:
    // Makes the renderer's context the current one.
    void SetUp() override { renderer().render(request(Scene{}, "empty")); }
};

constexpr std::uint32_t kSize = 32;
constexpr double kTexel = 2.0 / kSize;  // radians, in the middle of a face

EnvironmentMap darkness() {
    EnvironmentMap map;
    map.name = "blurred";
    map.faceSize = kSize;
    map.texels.assign(std::size_t{6} * kSize * kSize, glm::vec3(0.0f));
    return map;
}

std::size_t indexOf(std::uint32_t face, std::uint32_t x, std::uint32_t y) {
    return (std::size_t{face} * kSize + y) * kSize + x;
}

glm::dvec3 directionOf(std::size_t i) {
    const auto face = static_cast<std::uint32_t>(i / (kSize * kSize));
    const auto at = static_cast<std::uint32_t>(i % (kSize * kSize));
    return glm::normalize(glm::dvec3(cubeTexelDirection(face, at % kSize, at / kSize, kSize)));
}

// Times a constant.
double solidAngleOf(std::size_t i) {
    const auto face = static_cast<std::uint32_t>(i / (kSize * kSize));
    const auto at = static_cast<std::uint32_t>(i % (kSize * kSize));
    const double length =
        glm::length(glm::dvec3(cubeTexelDirection(face, at % kSize, at / kSize, kSize)));
    return 1.0 / (length * length * length);
}

// Red of every texel after the three passes.
std::vector<double> blurred(const EnvironmentMap& map, const MapBlur& blur) {
    PassResources resources;
    const GpuEnvironment source(map);
    const TargetSpec spec{.name = "blur",
                          .kind = TargetKind::cube,
                          .format = Format::rgba32f,
                          .width = map.faceSize,
                          .height = map.faceSize};
    Target result(spec), between(spec);
    const FramePlan plan;
    const Pose pose;
    const std::vector<Target*> targets{&result, &between};
    for (std::uint32_t axis = 0; axis < 3; ++axis) {
        const BlurCube work{.source = axis == 0   ? kNoTarget
                                      : axis == 1 ? 0u
                                                  : 1u,
                            .blur = blur,
                            .axis = axis};
        const Pass pass{.target = axis == 1 ? 1u : 0u, .work = work};
        execute(
            resources,
            {.plan = plan, .pass = pass, .targets = targets, .pose = pose, .environment = &source},
            work);
    }
    std::vector<double> red;
    std::vector<float> rgba(std::size_t{4} * map.faceSize * map.faceSize);
    for (std::uint32_t face = 0; face < 6; ++face) {
        result.face(0, face).readFloats(rgba);
        for (std::size_t i = 0; i < rgba.size(); i += 4) red.push_back(rgba[i]);
    }
    return red;
}

// A Gaussian of the angle between texels, times the second's solid angle.
double weightBetween(const glm::dvec3& to, const glm::dvec3& from, double fromAngle, double stdev) {
    const double angle = std::acos(std::clamp(glm::dot(to, from), -1.0, 1.0));
    const double far = angle / (stdev * kTexel);
    return far > 5.0 ? 0.0 : fromAngle * std::exp(-0.5 * far * far);
}

// The divisor for every texel's sum.
std::vector<double> weightsAround(double stdev) {
    std::vector<glm::dvec3> directions;
    for (std::size_t i = 0; i < std::size_t{6} * kSize * kSize; ++i) {
        directions.push_back(directionOf(i));
    }
    std::vector<double> sums(directions.size());
    for (std::size_t from = 0; from < sums.size(); ++from) {
        const double angle = solidAngleOf(from), nearest = std::cos(5.0 * stdev * kTexel);
        for (std::size_t to = 0; to < sums.size(); ++to) {
            if (glm::dot(directions[to], directions[from]) < nearest) continue;
            sums[to] += weightBetween(directions[to], directions[from], angle, stdev);
        }
    }
    return sums;
}

TEST(BlurTurns, AreANormalisedGaussian) {
    for (const auto& [size, stdev] : {std::pair(1u, 0.5), std::pair(4u, 2.0), std::pair(64u, 21.0),
                                      std::pair(3u, 64.0), std::pair(2u, 0.01)}) {
        const auto turns = blurRotations({size, stdev}, 256);
        EXPECT_EQ(turns.size(), 4 * size + 1);
        double sum = 0.0, least = 1.0;
        for (const glm::vec4& t : turns) {
            sum += t.z;
            least = std::min<double>(least, t.z);
            EXPECT_NEAR(t.x * t.x + t.y * t.y, 1.0, 1e-6);
        }
        EXPECT_NEAR(sum, 1.0, 1e-5);
        EXPECT_GE(least, 0.0);
        EXPECT_NEAR(turns.front().y, -turns.back().y, 1e-7);
        EXPECT_NEAR(turns.back().y, std::sin(size * 2.0 / 256), 1e-6) << "2 size + 1 texels wide";
    }
}

TEST_F(MapBlurs, ImpulsesBecomeTheKernel) {
    for (const double stdev : {1.0, 2.0}) {
        EnvironmentMap map = darkness();
        map.texels[indexOf(4, 16, 16)] = glm::vec3(1000.0f);
        const std::uint32_t size = static_cast<std::uint32_t>(3 * stdev);
        const std::vector<double> seen = blurred(map, {size, stdev});
        double weights = 0.0;
        for (int d = -8; d <= 8; ++d) weights += std::exp(-0.5 * d * d / (stdev * stdev));
        const double peak = 1000.0 / (weights * weights);
        for (int y = -5; y <= 5; ++y) {
            for (int x = -5; x <= 5; ++x) {
                const double expected = peak * std::exp(-0.5 * (x * x + y * y) / (stdev * stdev));
                EXPECT_NEAR(seen[indexOf(4, static_cast<std::uint32_t>(16 + x),
                                         static_cast<std::uint32_t>(16 + y))],
                            expected, 0.05 * peak)
                    << stdev << ": " << x << " " << y;
            }
        }
    }
}

TEST_F(MapBlurs, UniformLightIsUnchangedAndEnergyConserved) {
    EnvironmentMap even = darkness();
    for (glm::vec3& t : even.texels) t = glm::vec3(3.0f);
    for (const double seen : blurred(even, {6, 2.0})) EXPECT_NEAR(seen, 3.0, 3e-3);

    EnvironmentMap lamps = darkness();
    std::mt19937 random(1);
    double before = 0.0;
    for (int i = 0; i < 60; ++i) {
        const std::size_t at = random() % lamps.texels.size();
        lamps.texels[at] = glm::vec3(100.0f);
    }
    for (std::size_t i = 0; i < lamps.texels.size(); ++i) {
        before += solidAngleOf(i) * lamps.texels[i].x;
    }
    const std::vector<double> seen = blurred(lamps, {6, 2.0});
    double after = 0.0;
    for (std::size_t i = 0; i < seen.size(); ++i) after += solidAngleOf(i) * seen[i];
    EXPECT_NEAR(after / before, 1.0, 0.02);
}

// An impulse in the middle of a face, at an edge, at a corner: as on a sphere without faces.
TEST_F(MapBlurs, IsIsotropicOnTheSphere) {
    const double stdev = 2.5;
    const std::vector<double> around = weightsAround(stdev);
    for (const auto& [x, y] : {std::pair(16u, 16u), std::pair(31u, 16u), std::pair(31u, 31u),
                               std::pair(0u, 0u), std::pair(9u, 0u)}) {
        for (const std::uint32_t face : {0u, 3u, 4u}) {
            EnvironmentMap map = darkness();
            const std::size_t from = indexOf(face, x, y);
            map.texels[from] = glm::vec3(1000.0f);
            const std::vector<double> seen = blurred(map, {8, stdev});
            const glm::dvec3 impulse = directionOf(from);
            double worst = 0.0, peak = 0.0;
            for (std::size_t to = 0; to < seen.size(); ++to) {
                const double truth =
                    1000.0 * weightBetween(directionOf(to), impulse, solidAngleOf(from), stdev) /
                    around[to];
                worst = std::max(worst, std::abs(seen[to] - truth));
                peak = std::max(peak, truth);
            }
            EXPECT_LT(worst, 0.1 * peak) << face << ": " << x << " " << y;
        }
    }
}

// Across every edge and corner, no step is larger than 1.2 times the largest within a face.
TEST_F(MapBlurs, HasNoSeams) {
    EnvironmentMap map = darkness();
    std::mt19937 random(3);
    for (glm::vec3& t : map.texels) t = glm::vec3(static_cast<float>(random() % 1000));
    const std::vector<double> seen = blurred(map, {6, 2.0});
    double within = 0.0, across = 0.0;
    for (std::size_t i = 0; i < seen.size(); ++i) {
        const std::size_t x = i % kSize, y = i / kSize % kSize;
        if (x + 1 < kSize) within = std::max(within, std::abs(seen[i] - seen[i + 1]));
        if (y + 1 < kSize) within = std::max(within, std::abs(seen[i] - seen[i + kSize]));
        if (x > 0 && y > 0 && x + 1 < kSize && y + 1 < kSize) continue;
        // Its nearest neighbour on another face.
        double nearest = -1.0;
        std::size_t neighbour = i;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            const bool border = k % kSize == 0 || k % kSize == kSize - 1 ||
                                k / kSize % kSize == 0 || k / kSize % kSize == kSize - 1;
            if (!border || k / (kSize * kSize) == i / (kSize * kSize)) continue;
            const double cosine = glm::dot(directionOf(i), directionOf(k));
            if (cosine > nearest) {
                nearest = cosine;
                neighbour = k;
            }
        }
        across = std::max(across, std::abs(seen[i] - seen[neighbour]));
    }
    EXPECT_GT(across, 0.0);
    EXPECT_LE(across, 1.2 * within);
}

// ---- requested by materials and probes
// -------------------------------------------------------------

std::size_t blurPasses(const Frame& frame) {
    return static_cast<std::size_t>(
        std::count_if(frame.plan.passes.begin(), frame.plan.passes.end(),
                      [](const Pass& p) { return p.kind() == "gaussian"; }));
}

// Shows only the ball.
FrameRequest closely(FrameRequest r) {
    r.camera.yfov = 0.2;
    return r;
}

// A ball before a wall of stripes, all of which it mirrors by its own cube.
FrameRequest ballAmongStripes(const MapBlur& ofMaterial, const MapBlur& ofProbe = {},
                              const std::string& probe = "") {
    Scene scene;
    Material mirror = mirrorMetal();
    mirror.mapBlur = ofMaterial;
    mirror.probe = probe;
    place(scene, sphere(0.5f, 48, addMaterial(scene, mirror)));
    for (int i = -8; i <= 8; ++i) {
        glm::dmat4 tall = moved(0.5 * i, 0, 3.0);
        tall[1][1] = 20.0;
        place(scene, quad(0.25f, addMaterial(scene, glowing(glm::vec3(i % 2 ? 1.0f : 0.1f)))),
              tall);
    }
    scene.probes.push_back({.name = "placed", .size = 0.2, .resolution = 64, .blur = ofProbe});
    FrameRequest r = request(std::move(scene), "stripes", {0, 0, 2.0});
    r.accuracy.curved = CurvedMethod::probe;
    r.accuracy.generations = 1;
    r.accuracy.probeSize = 64;
    r.accuracy.parallax = Parallax::none;
    return closely(r);
}

// Between the brightest and the darkest pixel of the ball's middle.
double contrast(const Image& image) {
    float least = 1e9f, most = 0.0f;
    for (std::uint32_t x = 0; x < image.width; ++x) {
        const float here = color(image, x, image.height / 2).x;
        least = std::min(least, here);
        most = std::max(most, here);
    }
    return most - least;
}

TEST_F(MapBlurs, CapturedCubesUseTheBlurOfMaterialOrProbe) {
    const double sharp = contrast(renderer().render(ballAmongStripes({})).image);
    double before = sharp;
    for (const double stdev : {1.0, 2.0, 4.0}) {
        const Frame frame =
            renderer().render(ballAmongStripes({static_cast<std::uint32_t>(3 * stdev), stdev}));
        EXPECT_EQ(blurPasses(frame), 3u);
        EXPECT_LT(contrast(frame.image), before) << stdev;
        before = contrast(frame.image);
    }
    EXPECT_LT(before, 0.5 * sharp);
    const Frame placed = renderer().render(ballAmongStripes({}, {6, 2.0}, "placed"));
    EXPECT_EQ(blurPasses(placed), 3u);
    EXPECT_LT(contrast(placed.image),
              contrast(renderer().render(ballAmongStripes({}, {}, "placed")).image));
    EXPECT_EQ(blurPasses(renderer().render(ballAmongStripes({}, {6, 2.0}, "placed"))), 0u)
        << "resident";
}

TEST_F(MapBlurs, NoneLeavesEveryByte) {
    const Frame plain = renderer().render(ballAmongStripes({}));
    for (const MapBlur& none : {MapBlur{0, 3.0}, MapBlur{3, 0.0}}) {
        const Frame frame = renderer().render(ballAmongStripes(none));
        EXPECT_EQ(frame.image.data, plain.image.data);
        EXPECT_EQ(blurPasses(frame), 0u);
    }
}

TEST_F(MapBlurs, StoredMapsAreBlurredPerMaterial) {
    auto map = std::make_shared<EnvironmentMap>(darkness());
    map->name = "stored stripes";
    for (std::size_t i = 0; i < map->texels.size(); ++i) {
        map->texels[i] = glm::vec3(i / 2 % 2 ? 1.0f : 0.0f);
    }
    completeMap(*map);
    renderer().addEnvironment(map);
    const auto frameWith = [](const MapBlur& blur) {
        Scene scene;
        Material mirror = mirrorMetal();
        mirror.environmentMap = "stored stripes";
        place(scene, sphere(0.5f, 48, addMaterial(scene, mirror)));
        FrameRequest r = request(std::move(scene), "stored");
        MaterialOverride o{.material = "mirror"};
        o.mapBlur = blur;
        r.overrides = {o};
        return renderer().render(closely(r));
    };
    const Frame sharp = frameWith({}), soft = frameWith({6, 2.0});
    EXPECT_EQ(blurPasses(sharp), 0u);
    EXPECT_EQ(blurPasses(soft), 3u);
    EXPECT_LT(contrast(soft.image), 0.3 * contrast(sharp.image));
    EXPECT_NEAR(centerColor(soft.image).x, 0.5f, 0.1f);
    EXPECT_EQ(frameWith({}).image.data, sharp.image.data);
    EXPECT_EQ(blurPasses(frameWith({6, 2.0})), 0u) << "resident";
}

}  // namespace
}  // namespace clerestory::test
