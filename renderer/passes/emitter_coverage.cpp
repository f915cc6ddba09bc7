// Small glowing surfaces by the share that they cover of each pixel.
#include "passes/emitter_fragments.h"
#include "passes/passes.h"
#include "passes/pixel_triangles.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

namespace clerestory {
namespace {

// Of depths that a driver and the processor compute for the same point.
constexpr float kRounding = 1e-4f;
// The sum of the shares of triangles that fill a pixel, less what rounding may take.
constexpr float kWhole = 0.999f;
// An emitter reflects light, too, so that its pixels are brighter than what it emits; see
// isAlike().
constexpr float kAlike = 0.9f;
constexpr std::uint32_t kNear = 2;               // pixels
constexpr std::size_t kPartsBetweenChecks = 64;  // of whether the frame is abandoned

// A square of the picture, with a border of kNear pixels.
class Part {
public:
    // Reading a part takes time for the call as well as for its pixels.
    static constexpr std::uint32_t kEdge = 64;

    Part(const Target& picture, std::uint32_t x, std::uint32_t y) {
        const std::uint32_t width = picture.spec().width, height = picture.spec().height;
        const std::uint32_t left = x / kEdge * kEdge, bottom = y / kEdge * kEdge;
        inner_ = {left, bottom, std::min(kEdge, width - left), std::min(kEdge, height - bottom)};
        outer_.x = left - std::min(left, kNear);
        outer_.y = bottom - std::min(bottom, kNear);
        outer_.width = std::min(left + kEdge + kNear, width) - outer_.x;
        outer_.height = std::min(bottom + kEdge + kNear, height) - outer_.y;
        const std::size_t pixels = std::size_t{outer_.width} * outer_.height;
        before_.resize(pixels);
        depths_.resize(pixels);
        picture.drawn().readFloats(outer_, {&before_.data()->x, 4 * pixels});
        picture.drawn().readDepths(outer_, depths_);
        after_ = before_;
    }

    bool has(std::int64_t x, std::int64_t y) const {
        return x >= outer_.x && y >= outer_.y && x < std::int64_t{outer_.x} + outer_.width &&
               y < std::int64_t{outer_.y} + outer_.height;
    }
    const glm::vec4& color(std::int64_t x, std::int64_t y) const { return before_[index(x, y)]; }
    float storedDepth(std::int64_t x, std::int64_t y) const { return depths_[index(x, y)]; }
    void setColor(std::int64_t x, std::int64_t y, const glm::vec4& color) {
        after_[index(x, y)] = color;
    }
    void write(const Target& picture) const {
        std::vector<glm::vec4> colors;
        for (std::uint32_t y = 0; y < inner_.height; ++y) {
            const auto row = after_.begin() + static_cast<std::ptrdiff_t>(
                                                  index(inner_.x, std::int64_t{inner_.y} + y));
            colors.insert(colors.end(), row, row + inner_.width);
        }
        picture.texture().uploadPart(inner_, std::as_bytes(std::span(colors)));
    }

private:
    std::size_t index(std::int64_t x, std::int64_t y) const {
        return static_cast<std::size_t>((y - outer_.y) * outer_.width + (x - outer_.x));
    }

    gl::Rect inner_{}, outer_{};
    std::vector<glm::vec4> before_, after_;
    std::vector<float> depths_;
};

// The parts of a picture that are used.
class Parts {
public:
    explicit Parts(const Target& picture) : picture_(picture) {}
    std::size_t count() const { return parts_.size(); }
    Part& at(std::uint32_t x, std::uint32_t y) {
        return parts_.try_emplace({y / Part::kEdge, x / Part::kEdge}, picture_, x, y).first->second;
    }
    void write() const {
        for (const auto& [place, part] : parts_) part.write(picture_);
    }

private:
    const Target& picture_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, Part> parts_;
};

// The emitters in a pixel that nothing hides.
struct Coverage {
    float share = 0.0f;        // of the pixel
    glm::vec3 radiance{0.0f};  // mean
    bool isCut = false;        // a surface hides a part of them
    bool isShown = false;      // the picture shows one of them
};

// Of the pixels with emitters.
class Covered {
public:
    Coverage& at(std::uint32_t x, std::uint32_t y) { return pixels_[key(x, y)]; }
    // Null without an emitter.
    const Coverage* find(std::int64_t x, std::int64_t y) const {
        const auto found = pixels_.find(key(x, y));
        return found == pixels_.end() ? nullptr : &found->second;
    }

private:
    static std::uint64_t key(std::int64_t x, std::int64_t y) {
        return static_cast<std::uint64_t>(y) << 32 | static_cast<std::uint64_t>(x);
    }
    std::unordered_map<std::uint64_t, Coverage> pixels_;
};

// How much depth changes within a pixel: of the smoother side, because a surface may end there.
float slopeAt(const Part& part, const View& view, std::uint32_t x, std::uint32_t y) {
    const float here = depthOf(view, part.storedDepth(x, y));
    const auto along = [&](std::int64_t dx, std::int64_t dy) {
        float least = 0.0f;
        bool any = false;
        for (const int side : {-1, 1}) {
            const std::int64_t nx = x + side * dx, ny = y + side * dy;
            if (!part.has(nx, ny)) continue;
            const float change = std::abs(depthOf(view, part.storedDepth(nx, ny)) - here);
            least = any ? std::min(least, change) : change;
            any = true;
        }
        return least;
    };
    return along(1, 0) + along(0, 1);
}

// Of the fragments of one pixel.
Coverage coverageOf(const EmitterCoverage& work, const Part& part,
                    std::span<const EmitterFragment> fragments) {
    const std::uint32_t x = fragments.front().x, y = fragments.front().y;
    const float shown = depthOf(work.view, part.storedDepth(x, y));
    const float slope = slopeAt(part, work.view, x, y) + kRounding * shown;
    // Of the instance that the picture shows, other triangles may be behind what it shows.
    std::optional<std::uint32_t> shownInstance;
    const auto instanceOf = [&](const EmitterFragment& fragment) {
        return work.emitters[fragment.emitter].instance;
    };
    const auto isBefore = [&](const EmitterFragment& fragment) {
        return fragment.depth <= shown + slope + fragment.depthRange;
    };
    for (const EmitterFragment& fragment : fragments) {
        const bool isAt = fragment.depth >= shown - slope - fragment.depthRange;
        if (fragment.hasCenter && isAt && isBefore(fragment)) shownInstance = instanceOf(fragment);
    }
    Coverage coverage{.isShown = shownInstance.has_value()};
    std::uint64_t places = 0;
    int counted = 0;
    for (const EmitterFragment& fragment : fragments) {
        if (!isBefore(fragment) && instanceOf(fragment) != shownInstance) {
            coverage.isCut = true;
            continue;
        }
        places |= fragment.places;
        counted += std::popcount(fragment.places);
        coverage.share += fragment.share;
        coverage.radiance += fragment.share * work.emitters[fragment.emitter].radiance;
    }
    if (coverage.share == 0.0f) return coverage;
    coverage.radiance /= coverage.share;
    // Places in several triangles show how much of the sum is counted more than once.
    if (counted > 0) coverage.share *= float(std::popcount(places)) / float(counted);
    coverage.share = coverage.share < kWhole ? coverage.share : 1.0f;
    return coverage;
}

bool isAlike(const glm::vec4& color, const glm::vec3& radiance) {
    return glm::all(glm::greaterThanEqual(glm::vec3(color), kAlike * radiance));
}

// Whether the shares of the emitter in the pixel are what is seen of it: no pixel nearby is full of
// it, or of an emitter without fragments, because its outline is then like those of other surfaces;
// and nothing before it ends next to the pixel, because one depth does not tell where.
bool isKnown(const Part& part, const Covered& covered, std::uint32_t x, std::uint32_t y,
             const glm::vec3& radiance) {
    constexpr std::int64_t kReach = kNear;
    for (std::int64_t dy = -kReach; dy <= kReach; ++dy) {
        for (std::int64_t dx = -kReach; dx <= kReach; ++dx) {
            const std::int64_t nx = x + dx, ny = y + dy;
            if (!part.has(nx, ny)) continue;
            const Coverage* found = covered.find(nx, ny);
            const Coverage coverage = found ? *found : Coverage{};
            const bool isFull = coverage.share == 0.0f ? isAlike(part.color(nx, ny), radiance)
                                                       : coverage.share == 1.0f;
            const bool isNext = std::abs(dx) <= 1 && std::abs(dy) <= 1;
            if (isFull || (coverage.isCut && isNext)) return false;
        }
    }
    return true;
}

// A neighbour that shows no emitter and has the least of one in it; null without one.
const glm::vec4* backgroundOf(const Part& part, const Covered& covered, std::uint32_t x,
                              std::uint32_t y, const glm::vec3& radiance) {
    const glm::vec4* best = nullptr;
    float least = 1.0f;
    for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
            const std::int64_t nx = std::int64_t{x} + dx, ny = std::int64_t{y} + dy;
            if (!part.has(nx, ny) || isAlike(part.color(nx, ny), radiance)) continue;
            const Coverage* found = covered.find(nx, ny);
            if (found && found->isShown) continue;
            const float share = found ? found->share : 0.0f;
            if (share >= least) continue;
            least = share;
            best = &part.color(nx, ny);
        }
    }
    return best;
}

}  // namespace

void execute(PassResources& resources, const PassInput& input, const EmitterCoverage& work) {
    const Target& picture = input.target();
    const TargetSpec& spec = picture.spec();
    std::vector<EmitterFragment> fragments =
        emitterFragments(input.scene->scene(), input.pose, work, spec.width, spec.height);
    const auto placeOf = [](const EmitterFragment& f) { return std::pair(f.y, f.x); };
    std::stable_sort(fragments.begin(), fragments.end(),
                     [&](const auto& a, const auto& b) { return placeOf(a) < placeOf(b); });

    Parts parts(picture);
    Covered covered;
    std::vector<std::pair<std::uint32_t, std::uint32_t>> pixels;  // y and x
    std::size_t partsAtCheck = 0;
    for (auto first = fragments.begin(); first != fragments.end();) {
        const auto last = std::find_if(
            first, fragments.end(), [&](const auto& f) { return placeOf(f) != placeOf(*first); });
        covered.at(first->x, first->y) =
            coverageOf(work, parts.at(first->x, first->y), {first, last});
        pixels.push_back(placeOf(*first));
        first = last;
        if (parts.count() < partsAtCheck + kPartsBetweenChecks) continue;
        partsAtCheck = parts.count();
        if (isInterrupted(resources, input)) return;
    }
    for (const auto& [y, x] : pixels) {
        const Coverage& coverage = *covered.find(x, y);
        if (coverage.share == 0.0f) continue;
        Part& part = parts.at(x, y);
        if (!isKnown(part, covered, x, y, coverage.radiance)) continue;
        glm::vec4 color = part.color(x, y);
        if (!coverage.isShown) {
            const glm::vec4 emitter(coverage.radiance, work.transparent ? 1.0f : color.w);
            color = glm::mix(color, emitter, coverage.share);
        } else if (const glm::vec4* other = backgroundOf(part, covered, x, y, coverage.radiance)) {
            const glm::vec4 background(glm::vec3(*other), work.transparent ? other->w : color.w);
            color = glm::mix(background, color, coverage.share);
        }
        part.setColor(x, y, color);
    }
    parts.write();
}

}  // namespace clerestory
