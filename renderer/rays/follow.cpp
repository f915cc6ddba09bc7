#include "rays/follow.h"

#include "image/bands.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <vector>

namespace clerestory::rays {
namespace {

constexpr std::uint32_t kRowsAtOnce = 8, kRaysAtOnce = 64;
// Pixels of a row that are followed before the next row: their rays meet the same surfaces.
constexpr std::uint32_t kColumnsAtOnce = 32;

glm::vec3 radianceOf(const Path& path) {
    return {path.radiance[0], path.radiance[1], path.radiance[2]};
}

// The rays of one list, and what is known of their paths so far.
struct Paths {
    const PathTracer& tracer;
    const Density& density;
    const Records& records;
    std::uint32_t width, height;
    std::span<const Start> starts;
    Scratch& paths;

    std::size_t at(std::uint32_t x, std::uint32_t y) const { return std::size_t{y} * width + x; }
    // Whether the pixel takes a mean over its lobe at the end; see meanOfLobes().
    bool integrates(const RecordedRay& ray) const { return density.lobePaths > 1 && isRough(ray); }

    // The pixels at a distance of `step` whose paths are known: to the left and right, above and
    // below, or in the diagonals. Empty at the border of the picture.
    struct Neighbours {
        std::array<std::size_t, 4> at{};
        std::size_t count = 0;
        std::span<const std::size_t> all() const { return {at.data(), count}; }
    };
    Neighbours neighboursOf(std::uint32_t x, std::uint32_t y, std::uint32_t step) const {
        const std::uint32_t dx = x % (2 * step) != 0 ? step : 0,
                            dy = y % (2 * step) != 0 ? step : 0;
        if (x < dx || y < dy || x + dx >= width || y + dy >= height) return {};
        return {{at(x - dx, y - dy), at(x + dx, y + dy), at(x - dx, y + dy), at(x + dx, y - dy)},
                dx != 0 && dy != 0 ? 4u : 2u};
    }

    // Sets `path` to what the neighbours know of it. Returns false if they do not agree. before:
    // light that the pixel has already.
    bool agree(const Neighbours& neighbours, std::uint32_t step, const RecordedRay& ray,
               const glm::vec3& before, Path& path) const {
        if (neighbours.count == 0) return false;
        const std::uint32_t surfaces = paths[neighbours.at[0]].surfaces;
        Range range;
        glm::vec3 middle(0.0f);
        for (const std::size_t i : neighbours.all()) {
            if (paths[i].surfaces == 0 || paths[i].surfaces != surfaces) return false;
            range.add(radianceOf(paths[i]));
            middle += startOf(i);
        }
        // The ray starts between those of its neighbours, not at another surface.
        const glm::vec3 apart = middle / static_cast<float>(neighbours.count) - ray.start;
        const float reach = reachOf(step, ray);
        if (glm::dot(apart, apart) > reach * reach) return false;
        if (records.kind == Ray::mirrored && !isBetween(ray.along, neighbours)) return false;
        // The environment between them may differ from theirs, and costs no path.
        if (paths[neighbours.at[0]].open()) {
            path = tracer.open(ray, records.kind);
            return true;
        }
        const float contrast = step > 1 ? density.contrast : density.contrastNextTo;
        return isMean(range, neighbours, contrast, ray, before, path);
    }

    // Whether a direction is about the mean of the neighbours' directions. In a groove or at an
    // edge that is thinner than a step it is not, and meets other things.
    bool isBetween(const glm::vec3& along, const Neighbours& neighbours) const {
        std::array<glm::vec3, 4> directions;
        glm::vec3 mean(0.0f);
        for (std::size_t k = 0; k < neighbours.count; ++k) {
            directions[k] = directionOf(records.ways[neighbours.at[k]]);
            mean += directions[k] / static_cast<float>(neighbours.count);
        }
        float spread = 0.0f;
        for (std::size_t k = 0; k < neighbours.count; ++k) {
            spread = std::max(spread, glm::distance(directions[k], mean));
        }
        return glm::distance(along, mean) <= 0.5f * spread + kBent;
    }

    // The same whatever the neighbours meet, if all of them start near this ray in similar
    // directions and their radiance differs little enough.
    bool resemble(const Neighbours& neighbours, std::uint32_t step, const RecordedRay& ray,
                  const glm::vec3& before, Path& mean) const {
        if (neighbours.count == 0) return false;
        const float reach = kSlant * reachOf(step, ray);
        Range range;
        for (const std::size_t i : neighbours.all()) {
            if (paths[i].surfaces == 0) return false;
            const RecordedRay other = rayOf(starts[i], records.ways[i]);
            if (glm::distance(other.start, ray.start) > reach ||
                glm::distance(other.along, ray.along) > kTurned || other.intoBody != ray.intoBody) {
                return false;
            }
            range.add(radianceOf(paths[i]));
        }
        return isMean(range, neighbours, density.contrastBetween, ray, before, mean);
    }

    // Radiance of several paths.
    struct Range {
        glm::vec3 low{1e30f}, high{0.0f}, sum{0.0f};
        void add(const glm::vec3& radiance) {
            low = glm::min(low, radiance);
            high = glm::max(high, radiance);
            sum += radiance;
        }
    };
    // Sets `mean` to that of the range unless it is wider than the contrast permits.
    bool isMean(const Range& range, const Neighbours& neighbours, float contrast,
                const RecordedRay& ray, const glm::vec3& before, Path& mean) const {
        const glm::vec3 radiance = range.sum / static_cast<float>(neighbours.count),
                        difference = ray.share * (range.high - range.low),
                        seen = before + ray.share * radiance;
        const float allowed = contrast * (std::max({seen.x, seen.y, seen.z}) + 0.02f);
        if (std::max({difference.x, difference.y, difference.z}) > allowed) return false;
        mean = {{radiance.x, radiance.y, radiance.z}, paths[neighbours.at[0]].surfaces, 0.0f, 0};
        return true;
    }
    glm::vec3 startOf(std::size_t i) const {
        const float* p = starts[i].position;
        return {p[0], p[1], p[2]};
    }
    static float reachOf(std::uint32_t step, const RecordedRay& ray) {
        return 2.0f * static_cast<float>(step) * ray.width;
    }
    static constexpr float kSlant = 4.0f;  // pixels of a surface seen at a slant are farther apart
    static constexpr float kTurned = 0.15f;  // radians between rays of similar directions
    static constexpr float kBent = 0.03f;    // radians by which a mean direction may be wrong

    // Whether the path is known from neighbours; sets `path` to it.
    bool known(std::uint32_t x, std::uint32_t y, std::uint32_t step, const RecordedRay& ray,
               const glm::vec3& before, Path& path) const {
        const Neighbours neighbours = neighboursOf(x, y, step);
        return agree(neighbours, step, ray, before, path) ||
               (step < density.finest && resemble(neighbours, step, ray, before, path));
    }

    // Adds to `found` the eight neighbours at a distance of `step` that took a mean of other
    // surfaces than those of the followed pixel i, each once. taken: one byte for each pixel.
    void addOthers(std::size_t i, std::uint32_t step, std::vector<std::uint8_t>& taken,
                   std::vector<std::size_t>& found) const {
        const auto x = static_cast<std::uint32_t>(i % width),
                   y = static_cast<std::uint32_t>(i / width);
        for (std::uint32_t v = y < step ? y : y - step; v <= std::min(y + step, height - 1);
             v += step) {
            for (std::uint32_t u = x < step ? x : x - step; u <= std::min(x + step, width - 1);
                 u += step) {
                const std::size_t k = at(u, v);
                const Path& path = paths[k];
                if (path.count != 0 || path.surfaces == 0 || path.surfaces == paths[i].surfaces ||
                    taken[k] != 0) {
                    continue;
                }
                taken[k] = 1;
                found.push_back(k);
            }
        }
    }

    // Mean over a square of pixels in which all patterns have equal weight. Pixels that show the
    // same part of the scene are included: their lobes have the same width, their directions differ
    // by less than a lobe, and their starts are closer than the width of the lobe at its hit.
    glm::vec3 meanOfLobes(std::uint32_t x, std::uint32_t y, const RecordedRay& ray) const {
        const Path& own = paths[at(x, y)];
        glm::vec3 sum(0.0f);
        float weights = 0.0f;
        const auto first = [](std::uint32_t c) { return c < kReach ? 0 : c - kReach; };
        for (std::uint32_t v = first(y); v <= std::min(y + kReach, height - 1); ++v) {
            for (std::uint32_t u = first(x); u <= std::min(x + kReach, width - 1); ++u) {
                const std::size_t i = at(u, v);
                const Path& path = paths[i];
                if (!starts[i].present() || path.surfaces == 0) continue;
                const RecordedRay other = rayOf(starts[i], records.ways[i]);
                const float wider = std::max(ray.lobe, other.lobe),
                            narrower = std::min(ray.lobe, other.lobe);
                if (wider > 1.25f * narrower || ray.intoBody != other.intoBody) continue;
                const float distance = std::min(own.distance, path.distance);
                const float apart =
                    (glm::distance(ray.start, other.start) / std::max(distance, 1e-12f) +
                     glm::distance(ray.along, other.along)) /
                    (kAlike * narrower);
                const float edge = (u + kReach == x || u == x + kReach ? 0.5f : 1.0f) *
                                   (v + kReach == y || v == y + kReach ? 0.5f : 1.0f);
                const float weight = edge * std::max(1.0f - apart * apart, 0.0f);
                sum += weight * radianceOf(path);
                weights += weight;
            }
        }
        return sum / weights;  // its own weight is 1
    }

    static constexpr std::uint32_t kReach = 2;
    static constexpr float kAlike = 1.0f;  // of the slope of a lobe
};

// The 16 patterns lie in squares of 4 x 4 pixels, in the order of a Bayer matrix: neighbours are
// many steps apart.
std::uint32_t patternAt(std::uint32_t x, std::uint32_t y) {
    const auto bit = [](std::uint32_t v, std::uint32_t i) { return v >> i & 1u; };
    const std::uint32_t d = x ^ y;
    return bit(d, 0) << 3 | bit(y, 0) << 2 | bit(d, 1) << 1 | bit(y, 1);
}

// Pixels whose own rays are followed together.
class OwnRays {
public:
    explicit OwnRays(const Paths& list) : list_(list) {}

    void add(std::size_t pixel, const RecordedRay& ray) {
        const std::uint32_t pattern = patternAt(static_cast<std::uint32_t>(pixel % list_.width),
                                                static_cast<std::uint32_t>(pixel / list_.width));
        pixels_.push_back(pixel);
        rays_.push_back({ray, {list_.density.lobePaths, pattern}});
    }
    // Calls settle(pixel, ray, path) for each pixel in turn, and forgets them. Returns the number
    // of paths.
    template <class Settle>
    std::uint64_t follow(const Settle& settle) {
        paths_.resize(rays_.size());
        list_.tracer.follow(rays_, list_.records.kind, paths_);
        std::uint64_t count = 0;
        for (std::size_t k = 0; k < pixels_.size(); ++k) {
            settle(pixels_[k], rays_[k].ray, paths_[k]);
            count += paths_[k].count;
        }
        pixels_.clear();
        rays_.clear();
        return count;
    }

private:
    const Paths& list_;
    std::vector<std::size_t> pixels_;
    std::vector<RayWithLobe> rays_;
    std::vector<Path> paths_;
};

// A part that is thinner than a step is met by some of its pixels only. Follows the rays of all
// pixels of the grid that took a mean next to a path that met other surfaces, until there are none:
// along a stem or a line. Returns the number of paths.
std::uint64_t followThinParts(const Paths& list, std::uint32_t step,
                              std::span<glm::vec4> radiance) {
    std::vector<std::uint8_t> taken(list.starts.size(), 0);
    std::vector<std::size_t> front, next;
    for (std::uint32_t y = 0; y < list.height; y += step) {
        for (std::uint32_t x = 0; x < list.width; x += step) {
            const std::size_t i = list.at(x, y);
            if (list.paths[i].count != 0) list.addOthers(i, step, taken, front);
        }
    }
    const auto settle = [&](std::size_t i, const RecordedRay& ray, const Path& path) {
        if (!list.integrates(ray)) {
            const glm::vec3 more = radianceOf(path) - radianceOf(list.paths[i]);
            radiance[i] += glm::vec4(ray.share * more, 0.0f);
        }
        list.paths[i] = path;
    };
    std::atomic<std::uint64_t> followed{0};
    for (; !front.empty(); front.swap(next)) {
        forEachBand(static_cast<std::uint32_t>(front.size()), kRaysAtOnce,
                    [&](std::uint32_t k, std::uint32_t end) {
                        OwnRays own(list);
                        for (; k < end; ++k) {
                            const std::size_t i = front[k];
                            own.add(i, rayOf(list.starts[i], list.records.ways[i]));
                        }
                        followed += own.follow(settle);
                    });
        next.clear();
        for (const std::size_t i : front) list.addOthers(i, step, taken, next);
    }
    return followed;
}

}  // namespace

std::uint64_t follow(const Surroundings& surroundings, const Density& density,
                     const Records& records, std::span<glm::vec4> radiance, Scratch& scratch) {
    const PathTracer tracer(surroundings);
    const std::span<const Start> starts = records.starts;
    const std::uint32_t width = records.width;
    scratch.resize(std::max(scratch.size(), starts.size()));
    const auto height = static_cast<std::uint32_t>(starts.size() / std::max(1u, width));
    const Paths list{tracer, density, records, width, height, starts, scratch};
    const auto settle = [&](std::size_t i, const RecordedRay& ray, const Path& path) {
        scratch[i] = path;
        if (list.integrates(ray)) return;  // below
        radiance[i] += glm::vec4(ray.share * radianceOf(path), 0.0f);
    };
    // Settles the pixel, or adds its ray to `own`.
    const auto visit = [&](std::uint32_t x, std::uint32_t y, std::uint32_t step, OwnRays& own) {
        const std::size_t i = list.at(x, y);
        scratch[i] = {};
        if (!starts[i].present()) return;
        const RecordedRay ray = rayOf(starts[i], records.ways[i]);
        Path path{};
        if (step < density.stride && list.known(x, y, step, ray, glm::vec3(radiance[i]), path)) {
            settle(i, ray, path);
        } else {
            own.add(i, ray);
        }
    };
    std::atomic<std::uint64_t> followed{0};
    // The first step follows the ray of each place of the grid; the others fill the grid between.
    for (std::uint32_t step = density.stride; step >= 1; step /= 2) {
        const auto isDone = [&](std::uint32_t x, std::uint32_t y) {
            return step < density.stride && x % (2 * step) == 0 && y % (2 * step) == 0;
        };
        const std::uint32_t columns = kColumnsAtOnce * step;
        forEachBand((height + step - 1) / step, kRowsAtOnce,
                    [&](std::uint32_t first, std::uint32_t end) {
                        OwnRays own(list);
                        for (std::uint32_t left = 0; left < width; left += columns) {
                            const std::uint32_t right = std::min(left + columns, width);
                            for (std::uint32_t row = first; row < end; ++row) {
                                for (std::uint32_t x = left; x < right; x += step) {
                                    if (!isDone(x, row * step)) visit(x, row * step, step, own);
                                }
                            }
                            followed += own.follow(settle);
                        }
                    });
        if (step == density.finest && step < density.stride)
            followed += followThinParts(list, step, radiance);
    }
    if (density.lobePaths <= 1) return followed;
    forEachBand(height, kRowsAtOnce, [&](std::uint32_t y, std::uint32_t end) {
        for (; y < end; ++y) {
            for (std::uint32_t x = 0; x < width; ++x) {
                const std::size_t i = list.at(x, y);
                if (!starts[i].present()) continue;
                const RecordedRay ray = rayOf(starts[i], records.ways[i]);
                if (!list.integrates(ray)) continue;
                radiance[i] += glm::vec4(ray.share * list.meanOfLobes(x, y, ray), 0.0f);
            }
        }
    });
    return followed;
}

}  // namespace clerestory::rays
