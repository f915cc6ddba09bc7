// The difference between two images, and whether it is within a named tolerance. A failure writes
// the actual image, the expected one and their difference.
#pragma once

#include "image/image.h"

#include <gtest/gtest.h>

#include <string>

namespace clerestory::test {

// 8-bit samples count from 0 to 1, floats as they are.
struct Tolerance {
    std::string name;
    double bound = 0.0;      // of the difference of two samples
    double shareOver = 0.0;  // of all pixels, that may have a sample beyond the bound
};
inline const Tolerance kExact{"exact", 0.0, 0.0};
inline const Tolerance kRounding{"rounding", 1.0 / 255.0 + 1e-9, 0.0};  // one code
inline const Tolerance kEdges{"edges", 5.0 / 255.0, 0.001};

struct Difference {
    bool sameShape = false;       // size, channels and type; nothing else is known when they differ
    std::uint64_t nonFinite = 0;  // samples of either image
    double max = 0.0;
    double mean = 0.0;       // over all samples
    double shareOver = 0.0;  // of pixels with a sample beyond the bound, or a non-finite one
    std::uint32_t worstX = 0, worstY = 0;
};
Difference difference(const Image& actual, const Image& expected, double bound);

// True when the images have one shape, no sample is NaN or infinite, and no more pixels than the
// tolerance allows are beyond its bound. Otherwise says how far they are apart and where the
// picture of both lies, which is named after the running test.
::testing::AssertionResult imagesMatch(const Image& actual, const Image& expected,
                                       const Tolerance& tolerance);

// Actual, expected and the difference (brightest where it is greatest) as one picture. Images of
// one shape.
Image sideBySide(const Image& actual, const Image& expected);

}  // namespace clerestory::test
