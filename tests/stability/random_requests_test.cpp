// Random requests on random scenes: every target is finite, the driver reports nothing, and the
// same request gives the same bytes after any other requests. CLERESTORY_RANDOM="N SEED" sets the
// number of requests (scripts/fuzz-requests); a failure prints the seed that reproduces it.
#include "tests/gl/sight.h"
#include "tests/stability/random_scenes.h"
#include "tests/stability/table.h"

#include <cstdlib>
#include <sstream>

namespace clerestory::test {
namespace {

// Other knobs and switches need other shaders, which take far longer to compile than such a frame
// to draw: most requests differ in their cameras.
constexpr std::uint64_t kRequestsPerScene = 200;
constexpr std::uint64_t kRequestsPerSetting = 50;

class RandomRequests : public GlTest {};

TEST_F(RandomRequests, AreFiniteReproducibleAndRaiseNoGlErrors) {
    std::uint64_t count = 2000, seed = 1;
    if (const char* asked = std::getenv("CLERESTORY_RANDOM")) {
        std::istringstream(asked) >> count >> seed;
    }
    for (std::uint64_t done = 0; done < count; ++seed) {
        RandomSource chance(seed);
        Scene scene = randomScene(chance, "random");
        ASSERT_EQ(sceneProblems(scene), std::vector<std::string>{}) << "seed " << seed;
        renderer().addScene(std::move(scene));
        FrameRequest r, first;
        std::vector<std::byte> firstBytes;
        for (std::uint64_t i = 0; i < kRequestsPerScene && done < count; ++i, ++done) {
            if (i % kRequestsPerSetting == 0) r = randomRequest(chance, "random");
            randomCamera(chance, r);
            ASSERT_TRUE(problems(r).empty()) << "seed " << seed;
            const Frame frame = renderer().render(r, Readback::health);
            std::uint64_t bad = badSamples(frame.image);
            for (const TargetHealth& target : frame.health) {
                bad += target.nonFinite + target.negative;
            }
            EXPECT_TRUE(
                atMost("random requests", "bad texels of a frame's targets", double(bad), 0.0))
                << "seed " << seed << ", request " << i << '\n'
                << toText(frame.plan);
            if (i == 0) {
                first = r;
                firstBytes = frame.image.data;
            }
        }
        // After all the others, with their maps resident; then with none.
        for (const bool forget : {false, true}) {
            if (forget) renderer().forgetMaps();
            EXPECT_TRUE(atMost("random requests", "repeated: bytes differ",
                               renderer().render(first).image.data != firstBytes, 0.0))
                << "seed " << seed << (forget ? ", maps forgotten" : "");
        }
        const auto messages = renderer().driverMessages();
        EXPECT_TRUE(atMost("random requests", "driver messages", double(messages.size()), 0.0))
            << "seed " << seed << ": " << (messages.empty() ? "" : messages.front());
        if (HasFailure()) break;
    }
}

}  // namespace
}  // namespace clerestory::test
