// Cube maps: texel directions, conversion of panoramas, and irradiance.
#include "scene/environment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

namespace clerestory {
namespace {

constexpr double kPi = std::numbers::pi;

// The map's texel in a direction, by search, without inverting OpenGL's table.
glm::vec3 towards(const EnvironmentMap& map, const glm::vec3& direction) {
    const glm::vec3 wanted = glm::normalize(direction);
    float best = -2.0f;
    glm::vec3 found(0.0f);
    std::size_t i = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x, ++i) {
                const float close =
                    glm::dot(wanted, glm::normalize(cubeTexelDirection(face, x, y, map.faceSize)));
                if (close > best) best = close, found = map.texels[i];
            }
        }
    }
    return found;
}

// A map whose radiance is a function of the unit direction.
template <class F>
EnvironmentMap mapOf(std::uint32_t faceSize, F&& radiance) {
    EnvironmentMap map{.faceSize = faceSize};
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < faceSize; ++y) {
            for (std::uint32_t x = 0; x < faceSize; ++x) {
                map.texels.push_back(
                    glm::vec3(radiance(glm::normalize(cubeTexelDirection(face, x, y, faceSize)))));
            }
        }
    }
    return map;
}

// The basis that environment.h states.
glm::vec3 diffuse(const std::array<glm::vec3, 9>& c, const glm::vec3& n) {
    return c[0] + c[1] * n.y + c[2] * n.z + c[3] * n.x + c[4] * (n.x * n.y) + c[5] * (n.y * n.z) +
           c[6] * (3.0f * n.z * n.z - 1.0f) + c[7] * (n.x * n.z) + c[8] * (n.x * n.x - n.y * n.y);
}

const glm::vec3 kDirections[] = {{1, 0, 0},
                                 {-1, 0, 0},
                                 {0, 1, 0},
                                 {0, -1, 0},
                                 {0, 0, 1},
                                 {0, 0, -1},
                                 {0.6f, 0.64f, 0.48f},
                                 {-0.48f, -0.6f, 0.64f}};

TEST(CubeMap, TexelDirectionsFollowOpenGl) {
    // The table of the OpenGL 4.3 specification, 8.13: (s, t) from the major axis; here one texel a
    // face, then the first texel of a 2 x 2 face.
    const glm::vec3 centres[] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                 {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
    const glm::vec3 first[] = {{1, 0.5f, 0.5f},   {-1, 0.5f, -0.5f}, {-0.5f, 1, -0.5f},
                               {-0.5f, -1, 0.5f}, {-0.5f, 0.5f, 1},  {0.5f, 0.5f, -1}};
    for (std::uint32_t face = 0; face < 6; ++face) {
        EXPECT_EQ(cubeTexelDirection(face, 0, 0, 1), centres[face]) << face;
        EXPECT_EQ(cubeTexelDirection(face, 0, 0, 2), first[face]) << face;
    }
}

TEST(Panorama, TheMiddleColumnIsAheadAndRightIsPlusX) {
    // Eight columns of 45 degrees in four rows; colours by where the compass points.
    constexpr std::uint32_t kWidth = 64, kHeight = 32;
    std::vector<glm::vec3> picture(kWidth * kHeight);
    for (std::uint32_t y = 0; y < kHeight; ++y) {
        for (std::uint32_t x = 0; x < kWidth; ++x) {
            glm::vec3& texel = picture[y * kWidth + x];
            if (y < 4) {
                texel = {5, 5, 5};  // straight up
            } else if (y >= 28) {
                texel = {7, 7, 7};  // straight down
            } else if (x >= 28 && x < 36) {
                texel = {1, 0, 0};  // the middle
            } else if (x >= 44 && x < 52) {
                texel = {0, 1, 0};  // a quarter turn to the right
            } else if (x >= 12 && x < 20) {
                texel = {0, 0, 1};  // to the left
            } else if (x < 4 || x >= 60) {
                texel = {2, 2, 0};  // both ends: behind
            }
        }
    }
    const EnvironmentMap map = environmentFromEquirectangular("compass", picture, kWidth, kHeight);
    EXPECT_EQ(map.faceSize, 32u);
    ASSERT_EQ(map.texels.size(), 6u * 32 * 32);
    const auto sees = [&](glm::vec3 direction, glm::vec3 color) {
        const glm::vec3 seen = towards(map, direction);
        EXPECT_NEAR(seen.x, color.x, 1e-5f) << direction.x << direction.y << direction.z;
        EXPECT_NEAR(seen.y, color.y, 1e-5f) << direction.x << direction.y << direction.z;
        EXPECT_NEAR(seen.z, color.z, 1e-5f) << direction.x << direction.y << direction.z;
    };
    sees({0, 0, -1}, {1, 0, 0});
    sees({1, 0, 0}, {0, 1, 0});
    sees({-1, 0, 0}, {0, 0, 1});
    sees({0, 0, 1}, {2, 2, 0});
    sees({0, 1, 0}, {5, 5, 5});
    sees({0, -1, 0}, {7, 7, 7});
}

TEST(Panorama, ConstantPanoramasStayConstant) {
    for (const auto& [width, height] :
         {std::pair{1u, 1u}, {2u, 1u}, {5u, 3u}, {64u, 32u}, {4100u, 7u}, {30u, 60u}}) {
        const std::vector<glm::vec3> picture(std::size_t(width) * height,
                                             glm::vec3(0.1f, 0.7f, 3.0f));
        const EnvironmentMap map = environmentFromEquirectangular("even", picture, width, height);
        for (const glm::vec3& texel : map.texels) {
            ASSERT_NEAR(texel.x, 0.1f, 1e-6f) << width << " x " << height;
            ASSERT_NEAR(texel.z, 3.0f, 1e-5f) << width << " x " << height;
        }
    }
}

// Stripes that repeat after four texels: what is seen between the centres of a cube's texels has
// nine tenths of the contrast of the interpolated picture in the middle of a face, where texels are
// the largest.
TEST(Panorama, ACubeHasTheDetailOfItsPicture) {
    constexpr std::uint32_t kWidth = 1024, kHeight = 512;
    std::vector<glm::vec3> picture(std::size_t(kWidth) * kHeight);
    for (std::uint32_t i = 0; i < picture.size(); ++i) {
        picture[i] = glm::vec3(1.0 + std::sin(0.5 * kPi * (i % kWidth + 0.5)));
    }
    const EnvironmentMap map = environmentFromEquirectangular("stripes", picture, kWidth, kHeight);
    const std::uint32_t size = map.faceSize;
    const glm::vec3* row = &map.texels[(std::size_t{5} * size + size / 2) * size];  // of -Z
    double ofMap = 0.0, ofPicture = 0.0;
    for (double s = -0.25; s < 0.25; s += 1e-4) {
        const double column = (0.5 + std::atan(s) / (2.0 * kPi)) * kWidth - 0.5;
        const double wave = std::sin(0.5 * kPi * (column + 0.5));
        const auto between = [&](const glm::vec3* from, double at) {
            const double first = std::floor(at);
            const auto i = static_cast<std::size_t>(first);
            return glm::mix(double(from[i].x), double(from[i + 1].x), at - first) - 1.0;
        };
        ofMap += wave * between(row, (0.5 - 0.5 * s) * size - 0.5);
        ofPicture += wave * between(picture.data(), column);
    }
    EXPECT_NEAR(ofMap / ofPicture, 0.9, 0.05);
}

TEST(Panorama, SmallLightsKeepTheirFlux) {
    // One bright texel of a large picture; its light per solid angle must survive the smaller map.
    constexpr std::uint32_t kWidth = 4096, kHeight = 2048, kRow = 700, kColumn = 1234;
    std::vector<glm::vec3> picture(std::size_t(kWidth) * kHeight);
    picture[std::size_t(kRow) * kWidth + kColumn] = glm::vec3(60000.0f);
    const EnvironmentMap map = environmentFromEquirectangular("lamp", picture, kWidth, kHeight);
    EXPECT_EQ(map.faceSize, 1024u);
    const double polar = kPi * (kRow + 0.5) / kHeight;
    const double expected = 60000.0 * (2.0 * kPi / kWidth) * (kPi / kHeight) * std::sin(polar);
    double sum = 0.0;
    std::size_t i = 0;
    for (std::uint32_t face = 0; face < 6; ++face) {
        for (std::uint32_t y = 0; y < map.faceSize; ++y) {
            for (std::uint32_t x = 0; x < map.faceSize; ++x, ++i) {
                const glm::dvec3 d(cubeTexelDirection(face, x, y, map.faceSize));
                const double area = 2.0 / map.faceSize;
                sum += map.texels[i].x * area * area / std::pow(glm::dot(d, d), 1.5);
            }
        }
    }
    EXPECT_NEAR(sum / expected, 1.0, 0.1);
}

TEST(Panorama, InvalidTexelsBecomeBlackAndBrightOnesAreClamped) {
    const float inf = std::numeric_limits<float>::infinity();
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::vector<glm::vec3> picture(64 * 32, glm::vec3(nan, inf, -inf));
    std::fill_n(picture.begin(), 64 * 16, glm::vec3(-5.0f, 1e30f, 65504.0f));
    const EnvironmentMap map = environmentFromEquirectangular("broken", picture, 64, 32);
    float brightest = 0.0f;
    for (const glm::vec3& texel : map.texels) {
        for (int c = 0; c < 3; ++c) {
            ASSERT_TRUE(texel[c] >= 0.0f && texel[c] <= 65504.0f) << texel[c];
            brightest = std::max(brightest, texel[c]);
        }
        EXPECT_EQ(texel.x, 0.0f);
    }
    EXPECT_EQ(brightest, 65504.0f);
}

TEST(Panorama, IncompleteImagesAreRejected) {
    EXPECT_THROW(environmentFromEquirectangular("none", {}, 0, 0), std::runtime_error);
    EXPECT_THROW(environmentFromEquirectangular("torn", std::vector<glm::vec3>(7), 4, 2),
                 std::runtime_error);
}

TEST(Harmonics, AConstantMapGivesAWhiteFloorItsRadiance) {
    for (const std::uint32_t size : {1u, 2u, 16u, 64u}) {
        const auto c =
            diffuseHarmonics(mapOf(size, [](auto) { return glm::vec3(0.5f, 1.0f, 2.0f); }));
        for (const glm::vec3& n : kDirections) {
            EXPECT_NEAR(diffuse(c, n).x, 0.5f, 1e-4f) << size;
            EXPECT_NEAR(diffuse(c, n).z, 2.0f, 1e-4f) << size;
        }
    }
}

TEST(Harmonics, AHalfSkyLightsInProportionToItsVisiblePart) {
    // Radiance 1 above the plane across `up`: irradiance / pi is (1 + cos) / 2, exactly of band 1.
    for (const glm::vec3& up : kDirections) {
        const auto c =
            diffuseHarmonics(mapOf(64, [&](const glm::vec3& d) { return glm::dot(d, up) > 0.0f; }));
        for (const glm::vec3& n : kDirections) {
            EXPECT_NEAR(diffuse(c, n).x, 0.5f * (1.0f + glm::dot(n, up)), 4e-3f);
        }
    }
}

TEST(Harmonics, BandsAreConvolvedWithTheCosine) {
    // Ramamoorthi and Hanrahan 2001: pi, 2 pi / 3, pi / 4 over pi. One polynomial of each kind.
    const auto linearPart = diffuseHarmonics(mapOf(
        64, [](const glm::vec3& d) { return glm::vec3(2.0f + d.x, 2.0f + d.y, 2.0f + d.z); }));
    const auto quadraticPart = diffuseHarmonics(mapOf(64, [](const glm::vec3& d) {
        return glm::vec3(2.0f + d.x * d.y, 4.0f + 3.0f * d.z * d.z - 1.0f,
                         2.0f + d.x * d.x - d.y * d.y);
    }));
    const auto products = diffuseHarmonics(mapOf(64, [](const glm::vec3& d) {
        return glm::vec3(2.0f + d.y * d.z, 2.0f + d.x * d.z, 0.0f);
    }));
    for (const glm::vec3& n : kDirections) {
        EXPECT_NEAR(diffuse(linearPart, n).x, 2.0f + n.x * 2.0f / 3.0f, 1e-3f);
        EXPECT_NEAR(diffuse(linearPart, n).y, 2.0f + n.y * 2.0f / 3.0f, 1e-3f);
        EXPECT_NEAR(diffuse(linearPart, n).z, 2.0f + n.z * 2.0f / 3.0f, 1e-3f);
        EXPECT_NEAR(diffuse(quadraticPart, n).x, 2.0f + n.x * n.y / 4.0f, 1e-3f);
        EXPECT_NEAR(diffuse(quadraticPart, n).y, 4.0f + (3.0f * n.z * n.z - 1.0f) / 4.0f, 1e-3f);
        EXPECT_NEAR(diffuse(quadraticPart, n).z, 2.0f + (n.x * n.x - n.y * n.y) / 4.0f, 1e-3f);
        EXPECT_NEAR(diffuse(products, n).x, 2.0f + n.y * n.z / 4.0f, 1e-3f);
        EXPECT_NEAR(diffuse(products, n).y, 2.0f + n.x * n.z / 4.0f, 1e-3f);
    }
}

TEST(BuiltinEnvironments, AreFiniteNamedAndDifferent) {
    std::set<std::uint64_t> hashes;
    for (const std::string& name : builtinEnvironmentNames()) {
        const auto map = builtinEnvironment(name);
        ASSERT_TRUE(map) << name;
        EXPECT_EQ(map->name, name);
        EXPECT_FALSE(map->title.empty()) << name;
        ASSERT_EQ(map->texels.size(), 6u * map->faceSize * map->faceSize) << name;
        for (const glm::vec3& texel : map->texels) {
            for (int c = 0; c < 3; ++c)
                ASSERT_TRUE(texel[c] >= 0.0f && texel[c] <= 65504.0f) << name;
        }
        EXPECT_TRUE(hashes.insert(map->contentHash).second) << name;
        EXPECT_EQ(map->contentHash, builtinEnvironment(name)->contentHash) << name;
    }
    EXPECT_FALSE(builtinEnvironment("no such sky"));
    EXPECT_FALSE(builtinEnvironment(""));
}

TEST(BuiltinEnvironments, TheSkyLightsAWhiteFloorToOne) {
    const EnvironmentMap sky = skyEnvironment();
    ASSERT_TRUE(sky.sun);
    EXPECT_NEAR(glm::length(sky.sun->toSun), 1.0f, 1e-6f);
    const glm::vec3 up(0.0f, 1.0f, 0.0f);
    const glm::vec3 floor =
        diffuse(diffuseHarmonics(sky), up) + sky.sun->irradiance * (sky.sun->toSun.y / float(kPi));
    EXPECT_NEAR(0.2126f * floor.x + 0.7152f * floor.y + 0.0722f * floor.z, 1.0f, 0.01f);
    EXPECT_GT(sky.sun->irradiance.x, sky.sun->irradiance.z) << "late light is warm";
    // Blue above, and brightest round the sun.
    const glm::vec3 zenith = towards(sky, up), nearSun = towards(sky, sky.sun->toSun);
    EXPECT_GT(zenith.z, 2.0f * zenith.x);
    EXPECT_GT(nearSun.x, 3.0f * zenith.x);
}

TEST(BuiltinEnvironments, NeighbouringTexelsOfSkiesAreSimilar) {
    for (const EnvironmentMap& map : {skyEnvironment(), duskEnvironment()}) {
        float greatest = 0.0f, brightest = 0.0f;
        for (std::size_t i = 0; i + 1 < map.texels.size(); ++i) {
            brightest = std::max(brightest, map.texels[i].x);
            if ((i + 1) % map.faceSize == 0) continue;
            greatest = std::max(greatest, std::abs(map.texels[i].x - map.texels[i + 1].x));
        }
        EXPECT_LT(greatest, 0.1f * brightest) << map.name;
    }
}

TEST(ContentHash, DependsOnEverythingVisible) {
    EnvironmentMap map = constantEnvironment("even", glm::vec3(1.0f));
    std::set<std::uint64_t> hashes{map.contentHash};
    const auto isNew = [&] {
        completeMap(map);
        return hashes.insert(map.contentHash).second;
    };
    map.texels.back().z = 1.0001f;
    EXPECT_TRUE(isNew());
    map.sun = Sun{.toSun = {0, 1, 0}, .irradiance = glm::vec3(1.0f)};
    EXPECT_TRUE(isNew());
    map.sun->irradiance.y = 2.0f;
    EXPECT_TRUE(isNew());
    map.sun->toSun = {1, 0, 0};
    EXPECT_TRUE(isNew());
    map.name = "renamed";
    EXPECT_FALSE(isNew()) << "a name is not seen";
}

// What a lobe of GGX about an axis gathers of Legendre's polynomial of a band about the same axis.
double bandShare(int band, double roughness) {
    double gathered = 0.0, weights = 0.0;
    constexpr int kSteps = 20000;
    for (int i = 0; i < kSteps; ++i) {
        const double c = (i + 0.5) / kSteps, a2 = std::pow(roughness, 4.0);
        const double q = 0.5 * (1.0 + c) * (a2 - 1.0) + 1.0, weight = a2 / (q * q) * c;
        gathered += weight * std::legendre(static_cast<unsigned>(band), c);
        weights += weight;
    }
    return gathered / weights;
}

TEST(HarmonicErrors, AreNoneForLightOfTwoBandsAndThatOfTheThirdBand) {
    const EnvironmentMap smooth = mapOf(
        32, [](const glm::vec3& n) { return 1.0f + 0.3f * n.x - 0.2f * n.y + 0.2f * n.x * n.z; });
    const EnvironmentMap third = mapOf(
        32, [](const glm::vec3& n) { return 1.0f + 0.5f * (2.5f * n.z * n.z * n.z - 1.5f * n.z); });
    const std::array<float, 4> none = harmonicErrors(smooth), errors = harmonicErrors(third);
    for (std::size_t i = 0; i < none.size(); ++i) {
        EXPECT_LT(none[i], 4e-3f) << kHarmonicRoughness[i];
        // The root of its mean square over the directions of a cube's faces, edges and corners.
        double squares = 0.0;
        for (const double z : {1.0, std::sqrt(0.5), std::sqrt(1.0 / 3.0), 0.0}) {
            const double times = z == 1.0 ? 2.0 : z == 0.0 ? 8.0 : 8.0;
            squares += times / 26.0 * std::pow(std::legendre(3, z), 2.0);
        }
        const double expected = 0.5 * bandShare(3, kHarmonicRoughness[i]) * std::sqrt(squares);
        EXPECT_NEAR(errors[i], expected, 0.05 * expected + 4e-3) << kHarmonicRoughness[i];
    }
}

TEST(HarmonicErrors, AreThoseOfTheMapWhateverItsIntensity) {
    EnvironmentMap map = duskEnvironment();
    const std::array<float, 4> errors = map.harmonicErrors;
    for (glm::vec3& texel : map.texels) texel *= 0.25f;
    completeMap(map);
    for (std::size_t i = 0; i < errors.size(); ++i) {
        EXPECT_NEAR(map.harmonicErrors[i], errors[i], 1e-4f);
        EXPECT_GT(errors[i], 0.0f);
        EXPECT_EQ(harmonicError(map, kHarmonicRoughness[i]), map.harmonicErrors[i]);
    }
    EXPECT_EQ(harmonicError(map, 0.69f), std::numeric_limits<float>::infinity());
    EXPECT_EQ(harmonicErrors(constantEnvironment("dark", glm::vec3(0.0f))),
              (std::array<float, 4>{}));
    // Boxes of light in a dark room are harder than a sky.
    EXPECT_GT(studioEnvironment().harmonicErrors[1], 5.0f * skyEnvironment().harmonicErrors[1]);
}

}  // namespace
}  // namespace clerestory
