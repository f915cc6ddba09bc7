// Counts the pixels of instances and finds their boxes.
//
//     InstanceCounts counts(identifiers);       // 1 + instance of each pixel, for MeasureInstances
//     counts.add(instance, alone, rect);        // the same, drawn alone; for each instance
//     counts.all();
#pragma once

#include "gl/texture.h"
#include "passes/readback.h"

#include <map>
#include <span>
#include <vector>

namespace clerestory {

// Rows and columns of pixels that were counted.
struct CountedPixels {
    std::uint32_t pixels = 0;
    std::uint32_t left = ~0u, first = ~0u, right = 0, last = 0;  // right and last are included
    void add(std::uint32_t x, std::uint32_t y);
};

class InstanceCounts {
public:
    explicit InstanceCounts(const gl::Framebuffer& identifiers);
    // Pixels outside of `rect` do not show the instance. Ignores an instance without pixels.
    void add(Index instance, const gl::Framebuffer& alone, const gl::Rect& rect);
    // In the order of add().
    std::vector<InstanceExtent> all() { return std::move(extents_); }

private:
    std::uint32_t height_;
    std::map<Index, CountedPixels> seen_;  // rows from the lower edge
    std::vector<float> alone_;
    std::vector<InstanceExtent> extents_;
};

// The same for CountLayer.
class LayerCounts {
public:
    // Instances along the ray of a pixel, from the upper left corner; the first one is visible.
    void add(std::span<const Index> instances, std::uint32_t x, std::uint32_t y);
    // Ascending.
    std::vector<InstanceExtent> all() const;

private:
    struct Counted {
        CountedPixels seen, whole;
    };
    std::map<Index, Counted> counted_;
};

}  // namespace clerestory
