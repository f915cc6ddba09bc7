// Errors of images relative to a reference: of linear radiance before tone mapping, the measures by
// which settings are judged; and of images as displayed: PSNR, SSIM, FLIP, and the decibels that
// glTF viewers publish.
#pragma once

#include "image/image.h"
#include "measures/measured_pixels.h"
#include "plan/request/frame_request.h"

#include <glm/glm.hpp>

namespace clerestory {

// Over all counted pixels and channels.
struct LinearErrors {
    std::uint64_t pixels = 0;     // counted: inside the mask and finite in both images
    std::uint64_t nonFinite = 0;  // inside the mask, NaN or infinite in either image: not counted
    double meanReference = 0.0;
    double bias = 0.0;  // mean of actual - reference
    double rmse = 0.0;
    double relMse = 0.0;  // mean of (x - r)^2 / (r^2 + e^2), e = kRelativeFloor * meanReference
    // Of the same terms, without the kOutlierShare of pixels whose terms are largest: a few glints
    // do not decide it.
    double relMseTrimmed = 0.0;
    double p95 = 0.0;  // 95th percentile of |x - r|
};
inline constexpr double kRelativeFloor = 0.01;
inline constexpr double kOutlierShare = 0.001;  // of the counted pixels, rounded down

// float32 images with 3 or 4 channels, of one size; alpha is ignored. Without a mask: the whole
// image. All 0 if no pixel is counted; always finite. Throws std::runtime_error if sizes or types
// do not match.
LinearErrors linearErrors(const Image& actual, const Image& reference, const Mask* mask = nullptr);

// How much of the gap between leaving an effect out and the truth a setting closes, on a
// logarithmic scale: 0: as bad as without the effect, below 0: worse, 1: within the reference's
// noise. error, errorOff and floor (the reference's noise) are of one measure, 0 or more. Always
// finite; 1 if leaving the effect out is within the noise.
double closedGap(double error, double errorOff, double floor);

// Colour map from black through violet and orange to pale yellow, of increasing lightness. t: 0..1,
// clamped; sRGB codes.
glm::u8vec3 falseColour(double t);

// falseColour(e / maxError) per pixel, e: the mean over channels of |x - r| / (r + 1 % of the
// reference's mean). Pixels that are not finite in either image are cyan. Arguments as
// linearErrors(); maxError > 0. Returns srgb8, 3 channels.
Image errorPicture(const Image& actual, const Image& reference, double maxError = 1.0);

// Errors of displayed images: all functions take sRGB-encoded images of one size, 8-bit or float32
// (0..1, clamped), with 3 or 4 channels (alpha is ignored), and an optional mask of the pixels to
// average. Pixels that are not finite in either image are not counted. Results are finite. Throw
// std::runtime_error if sizes or channels do not match.

// Returned for equal images, whose PSNR is infinite.
inline constexpr double kMaxDecibels = 120.0;

// 10 log10(1 / mean squared difference) over pixels and channels; 1 is white. 0..kMaxDecibels.
double psnr(const Image& actual, const Image& reference, const Mask* mask = nullptr);

// Structural similarity of luma (Rec. 601), -1..1, 1: equal. Wang, Bovik, Sheikh and Simoncelli,
// "Image Quality Assessment: From Error Visibility to Structural Similarity", IEEE TIP 13(4), 2004:
// Gaussian window of 11 x 11 with sigma 1.5, K1 0.01, K2 0.03. The mean is over windows that lie
// within the image, or over all windows if the image is smaller than 11 pixels.
double ssim(const Image& actual, const Image& reference, const Mask* mask = nullptr);

// Root mean square of the squared YIQ distance relative to its maximum, in decibels:
// 10 log10(sqrt(mean(d^2)) / 35215), where d = 0.5053 y^2 + 0.299 i^2 + 0.1957 q^2 of the
// differences of 0..255 codes. 0: black and white; -kMaxDecibels: equal. The distance is of
// Kotsarenko and Ramos, "Measuring perceived color difference using YIQ NTSC transmission color
// space in mobile applications", 2010; the root mean square and the decibels are as model-viewer's
// render-fidelity-tools publish them for the glTF viewers (common.ts: analyze, toDecibel).
double decibels(const Image& actual, const Image& reference, const Mask* mask = nullptr);

// At 0.7 m from a screen 0.7 m and 3840 pixels wide, as in the paper.
inline constexpr double kPixelsPerDegree = 67.0206;

// Perceived difference when alternating between the two images, 0..1; 0: no difference. Andersson,
// Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, "FLIP: A Difference Evaluator for
// Alternating Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2), 2020.
// pixelsPerDegree: of visual angle, 1..1000.
Image flipMap(const Image& actual, const Image& reference,
              double pixelsPerDegree = kPixelsPerDegree);  // one float per pixel
double flip(const Image& actual, const Image& reference, const Mask* mask = nullptr,
            double pixelsPerDegree = kPixelsPerDegree);  // mean of the map

struct DisplayedErrors {
    std::uint64_t pixels = 0;     // counted
    std::uint64_t nonFinite = 0;  // not counted
    double psnr = 0.0, ssim = 0.0, flip = 0.0, decibels = 0.0;
};
DisplayedErrors displayedErrors(const Image& actual, const Image& reference,
                                const Mask* mask = nullptr,
                                double pixelsPerDegree = kPixelsPerDegree);

// sRGB-encoded float32, 0..1, 3 channels, with the curves of the tone mapping pass; defined for any
// input, also NaN. linear: float32, 3 or 4 channels (alpha is ignored). exposureFactor: multiplies
// radiance, > 0. Throws std::runtime_error for other types.
Image displayed(const Image& linear, ToneMap curve, float exposureFactor = 1.0f);

// Rounded to 8 bits.
Image quantised(const Image& displayed);

}  // namespace clerestory
