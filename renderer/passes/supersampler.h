// Memory of the pass that gives further samples to chosen pixels (plan/graph/supersampling.h).
#pragma once

#include "display/display.h"
#include "plan/graph/supersampling.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace clerestory {

class Target;

// The finished picture of a view, while chosen pixels get further samples. The sums are formed on
// the processor, in the order of the samples. Kept from frame to frame, so that a frame allocates
// nothing.
class Supersampler {
public:
    // Reads the picture and chooses pixels by how it is displayed.
    void begin(const Supersampling& work, const Target& picture);
    // Whether pixels are left that need more samples.
    bool isDone() const { return pixels_.empty(); }
    // Of each pixel of a part, first row first; see Supersampling::Part.
    std::span<const float> chosenDepths(const Supersampling::Part& part, std::uint32_t width,
                                        std::uint32_t height);
    // Adds the sample that the picture now shows in the pixels that are left.
    void add(const Target& picture);
    // Ends the pixels whose samples so far differ less than that as displayed, 0..1.
    void endAlike(double leastDifference);
    // Writes the picture that begin() has read, with the means of the samples.
    void finish(const Target& picture);

private:
    // The range of a pixel's samples as displayed.
    struct Range {
        glm::u8vec4 low{255}, high{0};
    };
    void read(const Target& picture);
    void addToRanges();
    void writeMean(std::size_t i);

    std::uint32_t width_ = 0, height_ = 0;
    bool isHalf_ = true;
    // Of the work.
    std::uint32_t firstSamples_ = 0;
    ToneMap curve_ = ToneMap::neutral;
    float exposureFactor_ = 1.0f;
    bool transparent_ = false;
    // The picture as last read, in one of two formats, and as begin() has read it.
    std::vector<std::uint64_t> halves_, firstHalves_;
    std::vector<float> floats_, firstFloats_;
    display::Picture displayed_;
    // The pixels that are left, the first row first, and of each the sum and the range.
    std::vector<std::uint32_t> pixels_;
    std::vector<glm::vec4> sums_;
    std::vector<Range> ranges_;
    std::uint32_t samples_ = 0;  // in the sums
    std::vector<std::uint64_t> sampleHalves_;
    std::vector<std::uint8_t> isChosen_;
    std::vector<float> depths_;
};

}  // namespace clerestory
