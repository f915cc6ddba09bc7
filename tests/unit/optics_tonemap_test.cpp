// Tone curves accept any input and return displayable values; sRGB matches the standard in both
// directions.
#include "optics_support.h"

#include <gtest/gtest.h>

#include <random>

namespace clerestory::test {
namespace {

using Curve = glm::vec3 (*)(glm::vec3);
struct NamedCurve {
    const char* name;
    Curve curve;
};
const std::vector<NamedCurve> kCurves{{"linear", glsl::toneMapLinear},
                                      {"neutral", glsl::toneMapNeutral},
                                      {"aces", glsl::toneMapAces}};

TEST(ToneCurves, GiveDisplayLightForAnyInput) {
    const std::vector<float> hard{kNaN,   -kInf, -1e30f,   -1.0f, -0.0f, 0.0f,
                                  1e-40f, 1e-6f, 0.04f,    0.08f, 0.76f, 0.8f,
                                  1.0f,   10.0f, 65504.0f, 1e30f, 3e38f, kInf};
    for (const NamedCurve& c : kCurves) {
        for (const float r : hard) {
            for (const float g : hard) {
                for (const float b : hard) {
                    const glm::vec3 out = c.curve({r, g, b});
                    for (int i = 0; i < 3; ++i) {
                        ASSERT_TRUE(out[i] >= 0.0f && out[i] <= 1.0f)
                            << c.name << '(' << r << ' ' << g << ' ' << b << ") = " << out[i];
                    }
                }
            }
        }
        EXPECT_EQ(c.curve(glm::vec3(0.0f)), glm::vec3(0.0f)) << c.name;
    }
}

TEST(ToneCurves, BrighterGreyIsNeverDarker) {
    for (const NamedCurve& c : kCurves) {
        float before = 0.0f;
        for (double radiance = 1e-5; radiance < 65504.0; radiance *= 1.002) {
            const glm::vec3 out = c.curve(glm::vec3(float(radiance)));
            // Only by what a sum of three floats about 1 rounds.
            EXPECT_GE(out.y, before - 3e-7f) << c.name << " at " << radiance;
            before = out.y;
            // Grey stays grey: the sums of ACES' rounded matrix rows differ by up to 1e-4.
            EXPECT_NEAR(out.x, out.z, 2e-4f) << c.name << " at " << radiance;
        }
        EXPECT_NEAR(before, 1.0f, 1e-3f) << c.name;
    }
}

TEST(ToneCurves, LinearIsTheIdentityUpToOne) {
    EXPECT_EQ(glsl::toneMapLinear({0.1f, 0.5f, 1.0f}), glm::vec3(0.1f, 0.5f, 1.0f));
    EXPECT_EQ(glsl::toneMapLinear({0.1f, 1.5f, kInf}), glm::vec3(0.1f, 1.0f, 0.0f));
}

// The Khronos specification: below 0.8 a colour keeps its hue and loses only the 0.04 that a
// dielectric's surface adds, and less where its least channel is below 0.08.
TEST(ToneCurves, NeutralKeepsColoursBelowItsShoulder) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> channel(0.08f, 0.79f);
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 c(channel(random), channel(random), channel(random));
        const glm::vec3 out = glsl::toneMapNeutral(c);
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(out[k], c[k] - 0.04f, 1e-6f);
    }
    EXPECT_NEAR(glsl::toneMapNeutral(glm::vec3(0.04f)).x, 6.25f * 0.0016f, 1e-7f);
    const glm::vec3 red = glsl::toneMapNeutral({0.5f, 0.0f, 0.0f});
    EXPECT_EQ(red, glm::vec3(0.5f, 0.0f, 0.0f));  // a pure colour is left alone
    EXPECT_NEAR(glsl::toneMapNeutral(glm::vec3(0.8f)).x, 0.76f, 1e-6f);
    // The shoulder: 1 - 0.24^2 / (peak + 0.24 - 0.76), peak = 1.96 for grey 2.
    EXPECT_NEAR(glsl::toneMapNeutral(glm::vec3(2.0f)).x, 1.0 - 0.0576 / 1.44, 1e-6);
}

TEST(ToneCurves, AcesAtMiddleGrey) {
    // (x (x + .0245786) - .000090537) / (x (.983729 x + .432951) + .238081) by hand at 0.18.
    EXPECT_NEAR(glsl::toneMapAces(glm::vec3(0.18f)).y, 0.0367336 / 0.347885, 1e-4);
}

TEST(Srgb, EveryCodeRoundTrips) {
    for (int code = 0; code < 256; ++code) {
        const float linearValue = glsl::linearFromSrgb(float(code) / 255.0f);
        EXPECT_NEAR(glsl::srgbFromLinear(linearValue) * 255.0f, float(code), 1e-3f);
    }
}

TEST(Srgb, MatchesTheStandard) {
    EXPECT_NEAR(glsl::srgbFromLinear(0.5f), 0.7353569, 1e-6);
    EXPECT_NEAR(glsl::linearFromSrgb(0.5f), 0.2140411, 1e-6);
    EXPECT_NEAR(glsl::srgbFromLinear(0.18f), 0.4613561, 1e-6);
    EXPECT_EQ(glsl::srgbFromLinear(0.0f), 0.0f);
    EXPECT_NEAR(glsl::srgbFromLinear(1.0f), 1.0f, 1e-6f);
    // Both pieces meet at the knee, as well as the standard's rounded constants allow.
    EXPECT_NEAR(glsl::srgbFromLinear(0.0031308f), glsl::srgbFromLinear(0.0031309f), 2e-6f);
    for (const float bad : {kNaN, -kInf, -1.0f}) EXPECT_EQ(glsl::srgbFromLinear(bad), 0.0f);
    EXPECT_NEAR(glsl::srgbFromLinear(70000.0f), 1.0f, 1e-6f);
}

}  // namespace
}  // namespace clerestory::test
