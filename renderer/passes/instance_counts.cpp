#include "passes/instance_counts.h"

#include <algorithm>

namespace clerestory {
namespace {

// first, last: rows from the upper edge.
PixelBox boxOf(const CountedPixels& c, std::uint32_t first, std::uint32_t last) {
    if (c.pixels == 0) return {};
    return {c.left, first, c.right - c.left + 1, last - first + 1};
}

PixelBox boxFromBelow(const CountedPixels& c, std::uint32_t height) {
    return boxOf(c, height - 1 - c.last, height - 1 - c.first);
}

PixelBox boxFromAbove(const CountedPixels& c) {
    return boxOf(c, c.first, c.last);
}

}  // namespace

void CountedPixels::add(std::uint32_t x, std::uint32_t y) {
    ++pixels;
    left = std::min(left, x);
    right = std::max(right, x);
    first = std::min(first, y);
    last = std::max(last, y);
}

InstanceCounts::InstanceCounts(const gl::Framebuffer& identifiers) : height_(identifiers.height()) {
    const std::uint32_t width = identifiers.width();
    std::vector<float> shown(std::size_t{width} * height_);
    identifiers.readReds({0, 0, width, height_}, shown);
    CountedPixels* counted = nullptr;
    float before = 0.0f;
    for (std::size_t i = 0; i < shown.size(); ++i) {
        if (shown[i] < 1.0f) continue;
        if (!counted || shown[i] != before) counted = &seen_[static_cast<Index>(shown[i]) - 1];
        before = shown[i];
        counted->add(static_cast<std::uint32_t>(i % width), static_cast<std::uint32_t>(i / width));
    }
}

void InstanceCounts::add(Index instance, const gl::Framebuffer& alone, const gl::Rect& rect) {
    alone_.resize(std::size_t{rect.width} * rect.height);
    alone.readReds(rect, alone_);
    CountedPixels whole;
    auto shown = alone_.begin();
    for (std::uint32_t y = rect.y; y < rect.y + rect.height; ++y) {
        for (std::uint32_t x = rect.x; x < rect.x + rect.width; ++x, ++shown) {
            if (*shown >= 1.0f) whole.add(x, y);
        }
    }
    if (whole.pixels == 0) return;
    const CountedPixels& seen = seen_[instance];
    extents_.push_back({instance, seen.pixels, whole.pixels, boxFromBelow(seen, height_),
                        boxFromBelow(whole, height_)});
}

void LayerCounts::add(std::span<const Index> instances, std::uint32_t x, std::uint32_t y) {
    for (std::size_t i = 0; i < instances.size(); ++i) {
        Counted& counted = counted_[instances[i]];
        counted.whole.add(x, y);
        if (i == 0) counted.seen.add(x, y);
    }
}

std::vector<InstanceExtent> LayerCounts::all() const {
    std::vector<InstanceExtent> extents;
    for (const auto& [instance, counted] : counted_) {
        extents.push_back({instance, counted.seen.pixels, counted.whole.pixels,
                           boxFromAbove(counted.seen), boxFromAbove(counted.whole)});
    }
    return extents;
}

}  // namespace clerestory
