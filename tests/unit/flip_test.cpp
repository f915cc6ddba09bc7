// FLIP compared with its authors' program and with a second evaluation of the paper's formulae,
// with full two-dimensional kernels.
#include "measures/errors.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <random>

namespace clerestory::test {
namespace {

constexpr int kWidth = 48, kHeight = 32;
using Codes = std::array<int, 3>;
using Paint = std::function<Codes(int, int)>;

Image picture(const Paint& paint, int width = kWidth, int height = kHeight) {
    Image image = makeImage(std::uint32_t(width), std::uint32_t(height), 3, PixelType::srgb8);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const Codes c = paint(x, y);
            for (int k = 0; k < 3; ++k) {
                image.bytes()[3 * (y * width + x) + k] = std::uint8_t(c[std::size_t(k)]);
            }
        }
    }
    return image;
}

// Structure of every width.
Codes fine(int x, int y) {
    return {(37 * x + 11 * y) % 256, (5 * x + 23 * y + x * y) % 256, (13 * x * x + 3 * y) % 256};
}
Codes dimmed(int x, int y) {
    Codes c = fine(x, y);
    for (int& code : c) code = code * 7 / 8;
    return c;
}
Codes smooth(int x, int y) {
    return {255 * x / 47, 255 * y / 31, 255 * (47 - x + 31 - y) / 78};
}
// A square of another colour on it, and a white point.
Codes patched(int x, int y) {
    if (x >= 10 && x < 26 && y >= 8 && y < 20) return {200, 60, 30};
    if (x == 38 && y == 24) return {255, 255, 255};
    return smooth(x, y);
}

// ---- the paper's formulae -----------------------------------------------------------------

using Triple = std::array<double, 3>;
struct Plane {
    int width = 0, height = 0;
    std::vector<Triple> at;
    const Triple& clamped(int x, int y) const {
        return at[std::size_t(std::clamp(y, 0, height - 1) * width + std::clamp(x, 0, width - 1))];
    }
};

// XYZ over that of white. The matrix follows from the primaries and the white of IEC 61966-2-1.
Triple relativeXyz(const Triple& linear) {
    static constexpr double m[3][3] = {{0.4124564, 0.3575761, 0.1804375},
                                       {0.2126729, 0.7151522, 0.0721750},
                                       {0.0193339, 0.1191920, 0.9503041}};
    Triple xyz{};
    for (std::size_t i = 0; i < 3; ++i) {
        const double white = m[i][0] + m[i][1] + m[i][2];
        for (std::size_t k = 0; k < 3; ++k) xyz[i] += m[i][k] * linear[k] / white;
    }
    return xyz;
}
// By Cramer's rule.
Triple linearOfRelativeXyz(const Triple& xyz) {
    double m[3][3];  // columns: XYZ of the primaries
    for (std::size_t k = 0; k < 3; ++k) {
        Triple primary{};
        primary[k] = 1.0;
        const Triple column = relativeXyz(primary);
        for (std::size_t i = 0; i < 3; ++i) m[i][k] = column[i];
    }
    const auto determinant = [](const double a[3][3]) {
        return a[0][0] * (a[1][1] * a[2][2] - a[1][2] * a[2][1]) -
               a[0][1] * (a[1][0] * a[2][2] - a[1][2] * a[2][0]) +
               a[0][2] * (a[1][0] * a[2][1] - a[1][1] * a[2][0]);
    };
    Triple linear{};
    for (std::size_t k = 0; k < 3; ++k) {
        double replaced[3][3];
        for (std::size_t i = 0; i < 3; ++i) {
            for (std::size_t j = 0; j < 3; ++j) replaced[i][j] = j == k ? xyz[i] : m[i][j];
        }
        linear[k] = determinant(replaced) / determinant(m);
    }
    return linear;
}

Plane opponent(const Image& image) {
    Plane plane{int(image.width), int(image.height), {}};
    for (std::size_t i = 0; i < std::size_t(plane.width * plane.height); ++i) {
        Triple linear{};
        for (std::size_t k = 0; k < 3; ++k) {
            const double code = image.bytes()[3 * i + k] / 255.0;
            linear[k] = code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
        }
        const Triple t = relativeXyz(linear);
        plane.at.push_back({116.0 * t[1] - 16.0, 500.0 * (t[0] - t[1]), 200.0 * (t[1] - t[2])});
    }
    return plane;
}

// Hunt-adjusted CIELAB of what the eye resolves at a pixel.
Triple seenAt(const Plane& plane, int x, int y, double perDegree) {
    constexpr double pi = 3.14159265358979323846;
    struct Bell {
        double a1, b1, a2, b2;
    };
    constexpr Bell bells[] = {{1, 0.0047, 0, 1}, {1, 0.0053, 0, 1}, {34.1, 0.04, 13.5, 0.025}};
    const int radius = int(std::ceil(3.0 * std::sqrt(0.04 / (2.0 * pi * pi)) * perDegree));
    Triple sum{}, weights{};
    for (int dy = -radius; dy <= radius; ++dy) {
        for (int dx = -radius; dx <= radius; ++dx) {
            const double z = (dx * dx + dy * dy) / (perDegree * perDegree);
            for (std::size_t k = 0; k < 3; ++k) {
                const Bell& b = bells[k];
                const double weight = b.a1 * std::sqrt(pi / b.b1) * std::exp(-pi * pi * z / b.b1) +
                                      b.a2 * std::sqrt(pi / b.b2) * std::exp(-pi * pi * z / b.b2);
                sum[k] += weight * plane.clamped(x + dx, y + dy)[k];
                weights[k] += weight;
            }
        }
    }
    const double ty = (sum[0] / weights[0] + 16.0) / 116.0;
    Triple linear = linearOfRelativeXyz(
        {ty + sum[1] / weights[1] / 500.0, ty, ty - sum[2] / weights[2] / 200.0});
    for (double& c : linear) c = std::clamp(c, 0.0, 1.0);
    Triple t = relativeXyz(linear);
    for (double& c : t) {
        c = c > 216.0 / 24389.0 ? std::cbrt(c) : (24389.0 / 27.0 * c + 16.0) / 116.0;
    }
    const double lightness = 116.0 * t[1] - 16.0;
    return {lightness, 5.0 * lightness * (t[0] - t[1]), 2.0 * lightness * (t[1] - t[2])};
}

// The edge and point features at a pixel.
std::array<double, 2> featuresAt(const Plane& plane, int x, int y, double perDegree) {
    const double sd = 0.5 * 0.082 * perDegree;
    const int radius = int(std::ceil(3.0 * sd));
    std::array<double, 2> result{};
    for (int kind = 0; kind < 2; ++kind) {
        double along[2][2] = {}, weights[2] = {};  // of x and y; positive and negative
        for (int dy = -radius; dy <= radius; ++dy) {
            for (int dx = -radius; dx <= radius; ++dx) {
                const double bell = std::exp(-(dx * dx + dy * dy) / (2.0 * sd * sd));
                const double weight = (kind == 0 ? -dx : dx * dx / (sd * sd) - 1.0) * bell;
                const int sign = weight > 0.0 ? 0 : 1;
                weights[sign] += std::abs(weight);
                along[0][sign] += weight * (plane.clamped(x + dx, y + dy)[0] + 16.0) / 116.0;
                along[1][sign] += weight * (plane.clamped(x + dy, y + dx)[0] + 16.0) / 116.0;
            }
        }
        result[std::size_t(kind)] = std::hypot(along[0][0] / weights[0] + along[0][1] / weights[1],
                                               along[1][0] / weights[0] + along[1][1] / weights[1]);
    }
    return result;
}

double flipAt(const Plane& a, const Plane& b, int x, int y, double perDegree) {
    const auto apart = [](const Triple& p, const Triple& q) {
        return std::pow(std::abs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]), 0.7);
    };
    const auto plain = [](Triple linear) {
        Plane plane{1, 1, {}};
        const Triple t = relativeXyz(linear);
        plane.at.push_back({116.0 * t[1] - 16.0, 500.0 * (t[0] - t[1]), 200.0 * (t[1] - t[2])});
        return seenAt(plane, 0, 0, 1.0);
    };
    const double most = apart(plain({0, 1, 0}), plain({0, 0, 1}));
    const double c = apart(seenAt(a, x, y, perDegree), seenAt(b, x, y, perDegree));
    const double knee = 0.4 * most;
    const double colour = c < knee ? 0.95 / knee * c : 0.95 + 0.05 * (c - knee) / (most - knee);
    const auto fa = featuresAt(a, x, y, perDegree), fb = featuresAt(b, x, y, perDegree);
    const double feature = std::max(std::abs(fa[0] - fb[0]), std::abs(fa[1] - fb[1]));
    return std::pow(colour, 1.0 - std::sqrt(feature / std::sqrt(2.0)));
}

}  // namespace

// The figures come from compute_ldrflip() of the authors' Python program (NVlabs/flip at commit
// dd5d0f8), run on these pictures with NumPy 1.24 and, for OpenCV's filter2D, plain sums. It rounds
// to floats between its steps, and its matrix differs from ours in the fifth digit.
TEST(FlipReferenceProgram, MatchesOurs) {
    struct Place {
        int x, y;
        double value;
    };
    struct Row {
        const char* name;
        Codes (*reference)(int, int);
        Codes (*test)(int, int);
        double perDegree, mean;
        Place places[5];
    };
    constexpr double kUsual = 67.0206, kFar = 20.0;
    const Row rows[] = {
        {"a square and a point",
         smooth,
         patched,
         kUsual,
         0.139194,
         {{0, 0, 0.000043},
          {9, 14, 0.414208},
          {18, 14, 0.819134},
          {38, 24, 0.364177},
          {47, 31, 0.000470}}},
        {"a square and a point, from afar",
         smooth,
         patched,
         kFar,
         0.118531,
         {{0, 0, 0.0}, {9, 14, 0.230108}, {18, 14, 0.823268}, {38, 24, 0.947315}, {47, 31, 0.0}}},
        {"dimmed",
         fine,
         dimmed,
         kUsual,
         0.326714,
         {{0, 0, 0.124578},
          {9, 14, 0.349158},
          {18, 14, 0.317370},
          {38, 24, 0.261304},
          {47, 31, 0.340148}}},
        {"dimmed, from afar",
         fine,
         dimmed,
         kFar,
         0.427250,
         {{0, 0, 0.008377},
          {9, 14, 0.548192},
          {18, 14, 0.398020},
          {38, 24, 0.360618},
          {47, 31, 0.341333}}},
        {"nothing alike",
         smooth,
         fine,
         kUsual,
         0.870641,
         {{0, 0, 0.968524},
          {9, 14, 0.927116},
          {18, 14, 0.695674},
          {38, 24, 0.975252},
          {47, 31, 0.983074}}},
        {"nothing alike, from afar",
         smooth,
         fine,
         kFar,
         0.906933,
         {{0, 0, 0.961942},
          {9, 14, 0.984923},
          {18, 14, 0.731234},
          {38, 24, 0.978106},
          {47, 31, 0.992185}}},
    };
    for (const Row& row : rows) {
        const Image reference = picture(row.reference), test = picture(row.test);
        EXPECT_NEAR(flip(test, reference, nullptr, row.perDegree), row.mean, 1e-4) << row.name;
        const Image map = flipMap(test, reference, row.perDegree);
        for (const Place& p : row.places) {
            EXPECT_NEAR(map.floats()[p.y * kWidth + p.x], p.value, 5e-4)
                << row.name << " at " << p.x << ", " << p.y;
        }
    }
}

TEST(FlipPaper, MatchesOursAtEveryPixel) {
    constexpr int kSmallWidth = 13, kSmallHeight = 9;
    std::mt19937 random(7);
    const auto noise = [&](int, int) {
        return Codes{int(random() % 256), int(random() % 256), int(random() % 256)};
    };
    for (const double perDegree : {20.0, 67.0206}) {
        const Image a = picture(noise, kSmallWidth, kSmallHeight);
        const Image b = picture(noise, kSmallWidth, kSmallHeight);
        const Plane planeA = opponent(a), planeB = opponent(b);
        const Image map = flipMap(a, b, perDegree);
        for (int y = 0; y < kSmallHeight; ++y) {
            for (int x = 0; x < kSmallWidth; ++x) {
                EXPECT_NEAR(map.floats()[y * kSmallWidth + x],
                            flipAt(planeA, planeB, x, y, perDegree), 1e-6)
                    << x << ", " << y << " at " << perDegree;
            }
        }
    }
}

}  // namespace clerestory::test
