#include "passes/instance_counts.h"

#include <algorithm>

namespace clerestory {

void InstanceCounts::Counted::add(std::uint32_t x, std::uint32_t y) {
    ++pixels;
    left = std::min(left, x);
    right = std::max(right, x);
    bottom = std::min(bottom, y);
    top = std::max(top, y);
}

PixelBox InstanceCounts::boxOf(const Counted& c) const {
    if (c.pixels == 0) return {};
    return {c.left, height_ - 1 - c.top, c.right - c.left + 1, c.top - c.bottom + 1};
}

InstanceCounts::InstanceCounts(const gl::Framebuffer& identifiers) : height_(identifiers.height()) {
    const std::uint32_t width = identifiers.width();
    std::vector<float> shown(std::size_t{width} * height_);
    identifiers.readReds({0, 0, width, height_}, shown);
    Counted* counted = nullptr;
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
    Counted whole;
    auto shown = alone_.begin();
    for (std::uint32_t y = rect.y; y < rect.y + rect.height; ++y) {
        for (std::uint32_t x = rect.x; x < rect.x + rect.width; ++x, ++shown) {
            if (*shown >= 1.0f) whole.add(x, y);
        }
    }
    if (whole.pixels == 0) return;
    const Counted& seen = seen_[instance];
    extents_.push_back({instance, seen.pixels, whole.pixels, boxOf(seen), boxOf(whole)});
}

}  // namespace clerestory
