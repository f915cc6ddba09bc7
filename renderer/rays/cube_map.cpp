#include "rays/cube_map.h"

#include <algorithm>
#include <cmath>

namespace clerestory::rays {
namespace {

constexpr int kChannels = 3;

struct FacePoint {
    std::uint32_t face;
    float s, t;  // [-1, 1]
};

// OpenGL 4.6, table 8.19.
FacePoint facePoint(const float d[3]) {
    const float x = std::fabs(d[0]), y = std::fabs(d[1]), z = std::fabs(d[2]);
    if (x >= y && x >= z) {
        const float k = 1.0f / std::max(x, 1e-30f);
        return d[0] >= 0.0f ? FacePoint{0, -d[2] * k, -d[1] * k}
                            : FacePoint{1, d[2] * k, -d[1] * k};
    }
    if (y >= z) {
        const float k = 1.0f / y;
        return d[1] >= 0.0f ? FacePoint{2, d[0] * k, d[2] * k} : FacePoint{3, d[0] * k, -d[2] * k};
    }
    const float k = 1.0f / z;
    return d[2] >= 0.0f ? FacePoint{4, d[0] * k, -d[1] * k} : FacePoint{5, -d[0] * k, -d[1] * k};
}

// The inverse: a direction through a point of a face.
void directionOf(const FacePoint& p, float d[3]) {
    const float s = p.s, t = p.t;
    const float directions[6][3] = {{1, -t, -s}, {-1, -t, s}, {s, 1, t},
                                    {s, -1, -t}, {s, -t, 1},  {-s, -t, -1}};
    std::copy_n(directions[p.face], 3, d);
}

}  // namespace

CubeMap::CubeMap(std::uint32_t faceSize, std::uint32_t levels) : levels_(levels) {
    for (std::uint32_t i = 0; i < levels; ++i) {
        levels_[i].size = std::max(1u, faceSize >> i);
        const std::size_t edge = levels_[i].size + 2;
        levels_[i].texels.resize(6 * edge * edge * kChannels);
    }
}

// x and y: -1 .. size.
float* CubeMap::texel(Level& level, std::uint32_t face, int x, int y) const {
    const std::size_t edge = level.size + 2;
    return level.texels.data() + ((face * edge + static_cast<std::size_t>(y + 1)) * edge +
                                  static_cast<std::size_t>(x + 1)) *
                                     kChannels;
}

void CubeMap::setFace(std::uint32_t level, std::uint32_t face, std::span<const float> rgba) {
    Level& to = levels_[level];
    const int size = static_cast<int>(to.size);
    const float* from = rgba.data();
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x, from += 4) std::copy_n(from, 3, texel(to, face, x, y));
    }
}

// A border texel is that of the neighbour where the direction through its centre points; in a
// corner, where three faces meet, the mean of both borders next to it.
void CubeMap::joinEdges() {
    for (Level& level : levels_) {
        const int size = static_cast<int>(level.size);
        const auto coordinate = [&](int i) { return (2.0f * i + 1.0f) / level.size - 1.0f; };
        for (std::uint32_t face = 0; face < 6; ++face) {
            const auto copy = [&](int x, int y) {
                float d[3];
                directionOf({face, coordinate(x), coordinate(y)}, d);
                const FacePoint p = facePoint(d);
                const auto place = [&](float c) {
                    return std::clamp(static_cast<int>(0.5f * (c + 1.0f) * level.size), 0,
                                      size - 1);
                };
                std::copy_n(texel(level, p.face, place(p.s), place(p.t)), 3,
                            texel(level, face, x, y));
            };
            for (int i = 0; i < size; ++i) {
                copy(i, -1);
                copy(i, size);
                copy(-1, i);
                copy(size, i);
            }
            for (const int y : {-1, size}) {
                for (const int x : {-1, size}) {
                    const float* a = texel(level, face, std::clamp(x, 0, size - 1), y);
                    const float* b = texel(level, face, x, std::clamp(y, 0, size - 1));
                    float* corner = texel(level, face, x, y);
                    for (int c = 0; c < 3; ++c) corner[c] = 0.5f * (a[c] + b[c]);
                }
            }
        }
    }
}

void CubeMap::sample(const float direction[3], float level, float rgb[3]) const {
    const FacePoint p = facePoint(direction);
    const float last = static_cast<float>(levels_.size() - 1);
    const float lod = std::clamp(level, 0.0f, last);
    const auto first = static_cast<std::size_t>(lod);
    const float part = lod - static_cast<float>(first);
    const auto read = [&](const Level& l, float weight, float* sum) {
        const std::size_t edge = l.size + 2;
        const float x = std::clamp(0.5f * (p.s + 1.0f) * l.size + 0.5f, 0.5f, l.size + 0.5f);
        const float y = std::clamp(0.5f * (p.t + 1.0f) * l.size + 0.5f, 0.5f, l.size + 0.5f);
        const auto column = static_cast<std::size_t>(x), row = static_cast<std::size_t>(y);
        const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
        const float* a = l.texels.data() + ((p.face * edge + row) * edge + column) * kChannels;
        const float* b = a + edge * kChannels;
        for (int c = 0; c < 3; ++c) {
            const float upper = a[c] + (a[c + kChannels] - a[c]) * fx;
            const float lower = b[c] + (b[c + kChannels] - b[c]) * fx;
            sum[c] += weight * (upper + (lower - upper) * fy);
        }
    };
    rgb[0] = rgb[1] = rgb[2] = 0.0f;
    read(levels_[first], 1.0f - part, rgb);
    if (part > 0.0f) read(levels_[first + 1], part, rgb);
}

}  // namespace clerestory::rays
