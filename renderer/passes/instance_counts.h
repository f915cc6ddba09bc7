// Counts the pixels of instances and finds their boxes, for MeasureInstances.
//
//     InstanceCounts counts(identifiers);       // 1 + instance of each pixel
//     counts.add(instance, alone, rect);        // the same, drawn alone; for each instance
//     counts.all();
#pragma once

#include "gl/texture.h"
#include "passes/readback.h"

#include <map>
#include <vector>

namespace clerestory {

class InstanceCounts {
public:
    explicit InstanceCounts(const gl::Framebuffer& identifiers);
    // Pixels outside of `rect` do not show the instance. Ignores an instance without pixels.
    void add(Index instance, const gl::Framebuffer& alone, const gl::Rect& rect);
    // In the order of add().
    std::vector<InstanceExtent> all() { return std::move(extents_); }

private:
    // Rows and columns of pixels from the lower left corner.
    struct Counted {
        std::uint32_t pixels = 0;
        std::uint32_t left = ~0u, bottom = ~0u, right = 0, top = 0;  // the last two are included
        void add(std::uint32_t x, std::uint32_t y);
    };
    PixelBox boxOf(const Counted& counted) const;

    std::uint32_t height_;
    std::map<Index, Counted> seen_;
    std::vector<float> alone_;
    std::vector<InstanceExtent> extents_;
};

}  // namespace clerestory
