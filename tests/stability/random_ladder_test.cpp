// Random scenes compared with the path tracer: a more expensive technique is not farther from the
// truth than a cheaper one. CLERESTORY_LADDER="N SEED" sets the number of scenes
// (scripts/fuzz-requests); a failure names the seed that shows it alone.
//
// Comparisons that are not made, and why:
//  - Flat mirrors: a picture against rays. Neither is above the other: a picture shows the three
//    strongest mirrors in it; rays show all, but none that returns less than 5 %.
//  - Solid glass: the environment map compared with a backdrop. Neither represents where
//    the bent ray leaves, and the planner expects the same of both.
//  - Rays on rough surfaces: one ray represents a lobe, and the error is the variation within it.
//  - Mirrors and glass in one scene, and lamps above 1 about glass: where a ray meets glass it goes
//    the way of the greater share and takes the environment for the other, which may be half.
//  - Scenes that randomPlainScene() leaves out, for the reasons given there.
#include "tests/gl/sight.h"
#include "tests/stability/frames.h"
#include "tests/stability/random_scenes.h"
#include "tests/stability/table.h"

#include "image/image.h"
#include "measures/errors.h"
#include "reference/reference.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

namespace clerestory::test {
namespace {

constexpr std::uint32_t kSquare = 8;     // pixels of a frame along one of the truth
constexpr std::uint32_t kSamples = 256;  // paths a pixel
// Noise of the reference: a small ball shows a small scene, where rays sample and a cube averages.
constexpr std::uint32_t kMinPixels = 40;
// 8 x 8 samples resolve an edge's coverage of a pixel to a sixteenth: its square, of a picture that
// is all edges.
constexpr double kEdges = 1.0 / 256.0;
// A cube captures a thin object in the open from one side only: one pixel in a hundred is wrong.
constexpr double kThinThings = 0.01;

// Two ways of serving one effect, the cheaper one first.
struct TechniquePair {
    const char* name;
    Effect effect;
    bool smoothOnly, panesOnly;
    double indistinct;  // errors below are in no order
    void (*lower)(Accuracy&);
    void (*higher)(Accuracy&);
};

void flatByEnvironment(Accuracy& a) {
    a.planar = PlanarMethod::environment;
}
void flatByPicture(Accuracy& a) {
    a.planar = PlanarMethod::mirror;
}
void flatByRays(Accuracy& a) {
    a.planar = PlanarMethod::traced;
}
void curvedByEnvironment(Accuracy& a) {
    a.curved = CurvedMethod::environment;
}
void curvedByCube(Accuracy& a) {
    a.curved = CurvedMethod::probe;
    // Box parallax shifts small objects in open scenes, which counts twice.
    a.parallax = Parallax::depth;
}
void curvedByRays(Accuracy& a) {
    a.curved = CurvedMethod::traced;
}
void glassByEnvironment(Accuracy& a) {
    a.glass = GlassMethod::environment;
}
void glassByBackdrop(Accuracy& a) {
    a.glass = GlassMethod::backdrop;
}
void glassByRays(Accuracy& a) {
    a.glass = GlassMethod::traced;
}

constexpr TechniquePair kRungs[] = {
    {"flat, map to picture", Effect::planarReflection, false, false, kEdges, flatByEnvironment,
     flatByPicture},
    {"flat, map to rays", Effect::planarReflection, true, false, kEdges, flatByEnvironment,
     flatByRays},
    {"curved, map to cube", Effect::environmentReflection, false, false, kThinThings,
     curvedByEnvironment, curvedByCube},
    {"curved, cube to rays", Effect::environmentReflection, true, false, kEdges, curvedByCube,
     curvedByRays},
    {"panes, map to backdrop", Effect::refraction, false, true, kEdges, glassByEnvironment,
     glassByBackdrop},
    {"glass, map to rays", Effect::refraction, true, false, kEdges, glassByEnvironment,
     glassByRays},
    {"glass, backdrop to rays", Effect::refraction, true, false, kEdges, glassByBackdrop,
     glassByRays},
};

// Mean of |x - r|^2 / (|x|^2 + |r|^2 + e^2) over the mask, where e is a hundredth of the mean of
// |r|. A pixel counts at most 1, so that no lamp of a pixel's size outvotes a picture (relMSE has
// no such bound).
double errorOn(const Mask& mask, const Image& picture, const Image& truth) {
    const auto overMask = [&](const auto& value) {
        double sum = 0.0;
        for (std::uint32_t i = 0; i < truth.width * truth.height; ++i) {
            const std::uint32_t x = i % truth.width, y = i / truth.width;
            if (mask.inside[i]) sum += value(color(picture, x, y), color(truth, x, y));
        }
        return sum / static_cast<double>(mask.pixels());
    };
    const double mean =
        overMask([](const glm::dvec3&, const glm::dvec3& r) { return glm::length(r); });
    return overMask([&](const glm::dvec3& x, const glm::dvec3& r) {
        const double least = 1e-4 * mean * mean + 1e-30;
        return glm::dot(x - r, x - r) / (glm::dot(x, x) + glm::dot(r, r) + least);
    });
}

// A frame from within the room that looks at one of its things. Whatever its effect is not asked
// about is served by rays.
FrameRequest randomLook(RandomSource& chance, const Scene& scene) {
    FrameRequest r;
    r.effects.shadows = r.effects.indirectLight = false;
    r.scene = scene.id;
    r.width = 24 * kSquare;
    r.height = 18 * kSquare;
    r.camera.position = chance.inBox(1.9);
    const Instance& at = scene.instances[chance.below(std::uint32_t(scene.instances.size()))];
    const glm::dvec3 middle(scene.nodes[at.node].parentFromLocal[3]);
    r.camera.target = middle + chance.inBox(0.2);
    r.camera.yfov = chance.real(0.5, 1.2);
    r.output.format = OutputFormat::npy;
    r.accuracy.edgeFilter = false;
    r.accuracy.generations = r.accuracy.bounces = 4;
    flatByRays(r.accuracy);
    curvedByRays(r.accuracy);
    glassByRays(r.accuracy);
    return r;
}

bool anySolid(const Scene& scene) {
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& m) { return m.thickness > 0.0f; });
}

class RandomLadder : public GlTest {
protected:
    ReferenceImage truthOf(const Scene& scene, FrameRequest r) {
        EnvironmentMaps maps;
        maps[scene.environment] =
            std::make_shared<const EnvironmentMap>(*builtinEnvironment(scene.environment));
        r.width /= kSquare;
        r.height /= kSquare;
        return *traceReference({.scene = scene,
                                .frame = r,
                                .environment = *maps[scene.environment],
                                .maps = maps,
                                .samples = kSamples});
    }
    // Writes the reference, the cheaper and the more expensive frame next to each other; returns
    // the path.
    std::string kept(const Scene& scene, const FrameRequest& r, const TechniquePair& rung,
                     std::uint64_t seed) {
        FrameRequest large = r;
        large.width *= kSquare;
        large.height *= kSquare;
        Image lower, higher;
        for (auto [image, way] : {std::pair(&lower, rung.lower), {&higher, rung.higher}}) {
            FrameRequest at = r;
            way(at.accuracy);
            *image = quantised(displayed(drawn(at), r.toneMap));
        }
        const Image truth = quantised(displayed(truthOf(scene, large).color, r.toneMap));
        Image all = makeImage(3 * r.width, r.height, 3, PixelType::srgb8);
        for (std::uint32_t y = 0; y < r.height; ++y) {
            std::byte* to = all.data.data() + std::size_t{y} * all.width * 3;
            for (const Image* image :
                 std::initializer_list<const Image*>{&truth, &lower, &higher}) {
                const std::byte* from = image->data.data() + std::size_t{y} * r.width * 3;
                to = std::copy(from, from + std::size_t{r.width} * 3, to);
            }
        }
        const std::filesystem::path folder = CLERESTORY_TEST_OUTPUT;
        std::filesystem::create_directories(folder);
        const std::string file = folder / ("ladder-" + std::to_string(seed) + ".png");
        const std::string bytes = encodePng(all);
        std::ofstream(file, std::ios::binary) << bytes;
        return file;
    }
    static Image drawnBy(FrameRequest r, void (*way)(Accuracy&)) {
        way(r.accuracy);
        return averaged(drawn(r), kSquare);
    }
};

TEST_F(RandomLadder, MoreExpensiveIsNeverWorse) {
    std::uint64_t count = 100, seed = 1;
    if (const char* asked = std::getenv("CLERESTORY_LADDER")) {
        std::istringstream(asked) >> count >> seed;
    }
    std::map<std::string, int> climbed;
    for (std::uint64_t done = 0; done < count; ++done, ++seed) {
        RandomSource chance(seed);
        const bool smooth = chance.is(0.7);
        const Scene scene = randomPlainScene(chance, "random ladder", smooth);
        const FrameRequest r = randomLook(chance, scene);
        renderer().addScene(scene);
        const Image through = renderer().render(maskRequest(r)).image;
        std::optional<ReferenceImage> truth;
        for (const TechniquePair& rung : kRungs) {
            const Mask mask = whole(maskOf(through, rung.effect), kSquare);
            if (mask.pixels() < kMinPixels) continue;
            if ((rung.smoothOnly && !smooth) || (rung.panesOnly && anySolid(scene))) continue;
            if (!truth) truth = truthOf(scene, r);
            Image noisy = truth->color;
            for (std::size_t k = 0; k < std::size_t{3} * noisy.width * noisy.height; ++k) {
                noisy.floats()[k] += truth->noise.floats()[k];
            }
            const double noise = errorOn(mask, noisy, truth->color);
            const double lower = errorOn(mask, drawnBy(r, rung.lower), truth->color);
            const double higher = errorOn(mask, drawnBy(r, rung.higher), truth->color);
            // The truth's own noise is in both; that of its root is twice that of one half.
            EXPECT_TRUE(atMost("monotone ladder", std::string("random, ") + rung.name,
                               higher / (std::max(lower, rung.indistinct) + 4.0 * noise), 1.05))
                << "seed " << seed << ": " << lower << ", then " << higher << "; noise " << noise
                << ", " << mask.pixels()
                << " pixels; reference, cheaper and more expensive: " << kept(scene, r, rung, seed);
            ++climbed[rung.name];
        }
    }
    for (const TechniquePair& rung : kRungs)
        EXPECT_TRUE(count < 100 || climbed[rung.name] > 1) << rung.name;
}

}  // namespace
}  // namespace clerestory::test
