// A tile's picture is a part of a plane one unit in front of the eye with `focal` texels per unit,
// counted from its corner at -1, -1, so that the borders of a cube's faces lie between texels.
#include "plan/lens/tiles.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <thread>

namespace clerestory {
namespace {

constexpr const char* kFaceNames[6] = {"right", "left", "up", "down", "back", "front"};

// Samples of the frame along an edge, from which the planner finds the tiles.
constexpr double kSamples = 64.0;
// One tile about the axis is used up to this area of its plane; the faces of a cube have 4 each.
constexpr double kMaxSingleArea = 10.0;
constexpr double kMaxSingleTangent = 2.5;
// Overlap on each side, texels: of the edge of a face, and at least.
constexpr double kOverlap = 0.04;
constexpr double kMinOverlap = 6.0;
// Texels of weight 0 at the border of a tile, for neighbours in bilinear look-ups.
constexpr double kGuard = 2.0;
constexpr double kMaxTileEdge = 8192.0;
// Factor on focal lengths: pixels between the samples may be finer. Those of a cube lens are known.
constexpr double kBetweenSamples = 1.04;

// A direction that the frame shows, and its change from a pixel to the next one.
struct Sample {
    glm::dvec3 direction, right, below;
    double reach;  // half of the distance to the next samples, radians
};

// Per pixel along a side of it; none if the picture of the lens ends there.
std::optional<glm::dvec3> changeAlong(const Lens& lens, const glm::dvec2& pixel,
                                      const glm::dvec3& here, const glm::dvec2& along) {
    constexpr double kDifference = 1e-3;  // pixels
    for (const double step : {kDifference, -kDifference}) {
        if (const auto there = rayOf(lens, pixel + step * along)) return (*there - here) / step;
    }
    return std::nullopt;
}

Sample sampleAt(const Lens& lens, const glm::dvec2& pixel, const glm::dvec3& here) {
    const auto right = changeAlong(lens, pixel, here, {1.0, 0.0});
    const auto below = changeAlong(lens, pixel, here, {0.0, 1.0});
    // A pixel of which only the centre is in the picture is taken for a square; a lone point for
    // one that is a radian wide.
    const glm::dvec3 aside = std::abs(here.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 u = right   ? *right
                         : below ? glm::cross(here, *below)
                                 : glm::normalize(glm::cross(here, aside));
    return {here, u, below.value_or(glm::cross(here, u)), 0.0};
}

std::vector<Sample> samplesOf(const Lens& lens) {
    const glm::dvec2 size(lens.width, lens.height);
    const glm::dvec2 step = glm::max(glm::dvec2(1.0), glm::ceil(size / kSamples));
    std::vector<Sample> samples;
    for (double y = 0.5;; y = std::min(y + step.y, size.y - 0.5)) {
        for (double x = 0.5;; x = std::min(x + step.x, size.x - 0.5)) {
            if (const auto here = rayOf(lens, {x, y})) {
                samples.push_back(sampleAt(lens, {x, y}, *here));
                Sample& s = samples.back();
                s.reach = 0.5 * (glm::length(s.right) * step.x + glm::length(s.below) * step.y);
            }
            if (x >= size.x - 0.5) break;
        }
        if (y >= size.y - 0.5) break;
    }
    return samples;
}

// A plane in front of the eye, and the part of it that the frame shows.
struct TilePlane {
    glm::dmat3 cameraFromTile{1.0};
    glm::dvec2 low{INFINITY}, high{-INFINITY};  // tangents to the right and up
    double focal = 0.0;                         // texels per tangent
    double samples = 0.0;                       // that it shows itself

    bool empty() const { return !(low.x < high.x); }

    // own: not only because directions near the sample may be on the plane.
    void add(const Sample& s, bool own) {
        const glm::dmat3 tileFromCamera = glm::transpose(cameraFromTile);
        const glm::dvec3 local = tileFromCamera * s.direction;
        const glm::dvec2 t(local.x / -local.z, local.y / -local.z);
        const auto change = [&](const glm::dvec3& direction) {
            const glm::dvec3 d = tileFromCamera * direction;
            return (glm::dvec2(d) + t * d.z) / -local.z;
        };
        const double stretch = 1.0 + glm::dot(t, t);  // tangents per radian, at most
        low = glm::min(low, t - stretch * s.reach);
        high = glm::max(high, t + stretch * s.reach);
        // Singular values of the map from pixels to tangents.
        const glm::dvec2 u = change(s.right), v = change(s.below);
        const double mean = 0.5 * (glm::dot(u, u) + glm::dot(v, v));
        const double spread = std::hypot(0.5 * (glm::dot(u, u) - glm::dot(v, v)), glm::dot(u, v));
        const double longer = std::sqrt(mean + spread);
        const double shorter = std::sqrt(std::max(0.0, mean - spread));
        const double needed = 1.0 / std::max({shorter, 0.5 * longer, 1e-9});
        if (own && samples == 0.0) focal = 0.0;
        if (own || samples == 0.0) focal = std::max(focal, needed);
        if (own) samples += 1.0;
    }
    void clamp(double least, double most) {
        low = glm::clamp(low, least, most);
        high = glm::clamp(high, least, most);
    }
};

LensTile tileOf(const TilePlane& plane, const char* name, double focal, double overlap) {
    const glm::dvec2 low = glm::floor((plane.low + 1.0) * focal + 1e-6) - overlap;
    const glm::dvec2 high = glm::ceil((plane.high + 1.0) * focal - 1e-6) + overlap;
    LensTile tile{.name = name, .cameraFromTile = plane.cameraFromTile};
    tile.width = static_cast<std::uint32_t>(std::clamp(high.x - low.x, 1.0, kMaxTileEdge));
    tile.height = static_cast<std::uint32_t>(std::clamp(high.y - low.y, 1.0, kMaxTileEdge));
    // y is counted from above.
    tile.pinhole = {focal, focal, focal - low.x, tile.height - (focal - low.y), PixelCenter::half};
    return tile;
}

bool isCube(const Lens& lens) {
    return std::holds_alternative<CubeLens>(lens.model);
}

// Twice the focal length is a whole number of texels: the edge of a cube's face.
double wholeEdge(double focal) {
    return std::max(1.0, std::ceil(2.0 * focal - 1e-3));
}

double areaOf(const TilePlane& p) {
    return (p.high.x - p.low.x) * (p.high.y - p.low.y);
}

// Factor on all focal lengths, which limits the texels of the tiles together, and the edges of
// each.
double focalScale(const std::vector<TilePlane>& planes, const Lens& lens, double density) {
    const double finer = isCube(lens) ? 1.0 : kBetweenSamples * density;
    double texels = 0.0, longest = 0.0;
    for (const TilePlane& p : planes) {
        if (p.empty()) continue;
        texels += areaOf(p) * p.focal * p.focal;
        longest =
            std::max({longest, p.focal * (p.high.x - p.low.x), p.focal * (p.high.y - p.low.y)});
    }
    const double most = kMaxTileTexels * std::max(4096.0, double(lens.width) * lens.height);
    const double longestAllowed = kMaxTileEdge * (1.0 - 2.0 * kOverlap) - 2.0 * kMinOverlap;
    return std::min({finer, std::sqrt(most / std::max(texels, 1e-12)),
                     longestAllowed / std::max(longest, 1e-12)});
}

double overlapOf(double edge) {
    return std::max(kMinOverlap, std::ceil(kOverlap * edge));
}

// The plane about the axis, if it shows the whole frame well.
std::optional<TilePlane> singlePlane(const std::vector<Sample>& samples) {
    TilePlane plane;
    for (const Sample& s : samples) {
        if (!(s.direction.z < -0.1)) return std::nullopt;
        plane.add(s, true);
    }
    const double farthest = std::max({-plane.low.x, -plane.low.y, plane.high.x, plane.high.y});
    if (areaOf(plane) > kMaxSingleArea || farthest > kMaxSingleTangent) return std::nullopt;
    return plane;
}

std::vector<TilePlane> cubePlanes(const std::vector<Sample>& samples) {
    std::vector<TilePlane> planes(6);
    for (std::size_t face = 0; face < 6; ++face) {
        TilePlane& plane = planes[face];
        plane.cameraFromTile = cubeFaceAxes()[face];
        for (const Sample& s : samples) {
            const glm::dvec3 local = glm::transpose(plane.cameraFromTile) * s.direction;
            const double sideways = std::max(std::abs(local.x), std::abs(local.y));
            // Directions within `reach` of the sample may be on the face.
            if (-local.z > 0.2 && sideways <= -local.z + 2.0 * s.reach) {
                constexpr double kRounding = 1e-9;  // no face has its border itself
                plane.add(s, sideways < -local.z * (1.0 - kRounding));
            }
        }
        plane.clamp(-1.0, 1.0);
    }
    return planes;
}

bool contains(const LensTile& tile, const glm::dvec2& texel) {
    return texel.x >= kGuard && texel.y >= kGuard && texel.x <= tile.width - kGuard &&
           texel.y <= tile.height - kGuard;
}

// The place in the tile, and how far inside the face: 1 at its middle, 0 at its border, negative
// beyond.
struct Place {
    glm::dvec2 texel;
    double inside;
};
Place placeIn(const LensTile& tile, const glm::dvec3& local) {
    const glm::dvec2 t(local.x / -local.z, local.y / -local.z);
    const Intrinsics& i = tile.pinhole;
    return {{i.cx + i.fx * t.x, tile.height - i.cy + i.fy * t.y},
            1.0 - std::max(std::abs(t.x), std::abs(t.y))};
}

// Writes the lookups of one tile; grows its rectangle first.
class LookupTable {
public:
    void touch(std::uint32_t x, std::uint32_t y) {
        low_ = glm::min(low_, glm::uvec2(x, y));
        high_ = glm::max(high_, glm::uvec2(x + 1, y + 1));
    }
    void allocate() {
        if (low_.x >= high_.x) low_ = high_ = glm::uvec2(0);
        table.x = low_.x;
        table.y = low_.y;
        table.width = high_.x - low_.x;
        table.height = high_.y - low_.y;
        table.texels.assign(std::size_t{table.width} * table.height, glm::vec4(0.0f));
    }
    glm::vec4& at(std::uint32_t x, std::uint32_t y) {
        return table.texels[std::size_t{y - low_.y} * table.width + (x - low_.x)];
    }
    TileLookups table;

private:
    glm::uvec2 low_{~0u}, high_{0u};
};

struct Reading {
    std::size_t tile = 0;
    glm::vec4 value{0.0f};
};

// The tiles that show a direction, with their weights.
class Reader {
public:
    Reader(const Lens& lens, const std::vector<LensTile>& tiles, bool blend)
        : lens_(lens),
          tiles_(tiles),
          blend_(blend && tiles.size() > 1 && !isCube(lens)),
          // A face of a cube that shows a direction is at most 55 degrees away from it.
          least_(tiles.size() > 1 ? 0.4 : 1e-3) {}

    // Up to four.
    std::span<const Reading> readings(const glm::dvec3& direction) {
        count_ = 0;
        double sum = 0.0, best = -INFINITY;
        Reading owner;
        for (std::size_t i = 0; i < tiles_.size(); ++i) {
            const double ahead = -glm::dot(tiles_[i].cameraFromTile[2], direction);
            if (ahead < least_) continue;
            const glm::dvec3 local = glm::transpose(tiles_[i].cameraFromTile) * direction;
            const Place place = placeIn(tiles_[i], local);
            const float factor = static_cast<float>(depthPerDistance(lens_, direction) / -local.z);
            Reading reading{i, glm::vec4(place.texel, 1.0f, factor)};
            // A tile that was cropped may lack it; then its neighbours do not.
            const bool shown = contains(tiles_[i], place.texel);
            const double preference = place.inside - (shown ? 0.0 : 4.0);
            if (preference > best) best = preference, owner = reading;
            const double ramp = std::max(
                1e-9, (overlapOf(2.0 * tiles_[i].pinhole.fx) - kGuard) / tiles_[i].pinhole.fx);
            const double weight = std::clamp(0.5 + 0.5 * place.inside / ramp, 0.0, 1.0);
            if (!blend_ || !shown || weight == 0.0 || count_ == held_.size()) continue;
            reading.value.z = static_cast<float>(weight);
            sum += weight;
            held_[count_++] = reading;
        }
        if (count_ == 0 && best > -INFINITY) held_[count_++] = owner, sum = 1.0;
        for (std::size_t i = 0; i < count_; ++i) held_[i].value.z /= static_cast<float>(sum);
        return {held_.data(), count_};
    }

private:
    const Lens& lens_;
    const std::vector<LensTile>& tiles_;
    bool blend_;
    double least_;
    std::array<Reading, 4> held_;
    std::size_t count_ = 0;
};

// Of every pixel, lower row first; 0 where there is none.
std::vector<glm::vec3> raysOf(const Lens& lens) {
    std::vector<glm::vec3> rays(std::size_t{lens.width} * lens.height);
    std::atomic<std::uint32_t> next = 0;
    const auto work = [&] {
        for (std::uint32_t y; (y = next++) < lens.height;) {
            glm::vec3* row = rays.data() + std::size_t{y} * lens.width;
            for (std::uint32_t x = 0; x < lens.width; ++x) {
                row[x] = rayOf(lens, {x + 0.5, lens.height - y - 0.5}).value_or(glm::dvec3(0.0));
            }
        }
    };
    const bool large = rays.size() > 65536;
    std::vector<std::jthread> others(large ? std::max(1u, std::thread::hardware_concurrency()) - 1
                                           : 0);
    for (std::jthread& other : others) other = std::jthread(work);
    work();
    others.clear();  // joins
    return rays;
}

}  // namespace

std::vector<LensTile> tilesOf(const Lens& lens, double density) {
    const std::vector<Sample> samples = samplesOf(lens);
    if (samples.empty()) return {};
    std::vector<LensTile> tiles;
    if (const auto plane = isCube(lens) ? std::nullopt : singlePlane(samples)) {
        const double edge = wholeEdge(plane->focal * focalScale({*plane}, lens, density));
        tiles.push_back(tileOf(*plane, "front", 0.5 * edge, kMinOverlap));
        tiles.back().share = 1.0;
        return tiles;
    }
    const std::vector<TilePlane> planes = cubePlanes(samples);
    const double scale = focalScale(planes, lens, density);
    for (std::size_t face = 0; face < 6; ++face) {
        if (planes[face].empty()) continue;
        const double edge = wholeEdge(planes[face].focal * scale);
        const double overlap = isCube(lens) ? kMinOverlap : overlapOf(edge);
        tiles.push_back(tileOf(planes[face], kFaceNames[face], 0.5 * edge, overlap));
        tiles.back().share = planes[face].samples / static_cast<double>(samples.size());
    }
    std::stable_sort(tiles.begin(), tiles.end(),
                     [](const LensTile& a, const LensTile& b) { return a.share > b.share; });
    return tiles;
}

std::vector<TileLookups> lookupsOf(const Lens& lens, const std::vector<LensTile>& tiles,
                                   bool blend) {
    std::vector<LookupTable> tables(tiles.size());
    Reader reader(lens, tiles, blend);
    const std::vector<glm::vec3> rays = raysOf(lens);
    const auto forEachReading = [&](auto&& act) {
        const glm::vec3* ray = rays.data();
        for (std::uint32_t y = 0; y < lens.height; ++y) {
            for (std::uint32_t x = 0; x < lens.width; ++x, ++ray) {
                if (*ray == glm::vec3(0.0f)) continue;
                for (const Reading& reading : reader.readings(glm::dvec3(*ray))) {
                    act(tables[reading.tile], x, y, reading.value);
                }
            }
        }
    };
    forEachReading([](LookupTable& table, std::uint32_t x, std::uint32_t y, const glm::vec4&) {
        table.touch(x, y);
    });
    for (LookupTable& table : tables) table.allocate();
    forEachReading([](LookupTable& table, std::uint32_t x, std::uint32_t y,
                      const glm::vec4& value) { table.at(x, y) = value; });
    std::vector<TileLookups> lookups;
    for (LookupTable& table : tables) lookups.push_back(std::move(table.table));
    return lookups;
}

}  // namespace clerestory
