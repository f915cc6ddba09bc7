// Measures time and error of accuracy settings for one view of one scene. Draws through a callback,
// so that it does not depend on OpenGL or on its thread.
#pragma once

#include "comparison/comparison_request.h"
#include "measures/displayed_errors.h"
#include "measures/linear_errors.h"
#include "plan/graph/frame_plan.h"

#include <memory>

namespace clerestory {

struct DrawnFrame {
    Image image;
    double milliseconds = 0.0;  // wall clock until the GPU has finished; without time in a queue
    FramePlan plan;
};
using DrawFrame = std::function<DrawnFrame(const FrameRequest&)>;

struct ReferenceRender {
    ReferenceImage image;
    double milliseconds = 0.0;  // of tracing
};

struct EffectErrors {
    Effect effect = Effect::base;
    LinearErrors errors;       // over the pixels whose first surface shows the effect
    double relMseOff = 0.0;    // over these pixels, with this effect off and preset standard
    double relMseNoise = 0.0;  // over these pixels, of the truth's noise
    double closedGap = 0.0;
};

struct SettingResult {
    Accuracy accuracy;
    std::string name;     // nameOf(accuracy)
    double coldMs = 0.0;  // of the first frame, which compiles programs and draws maps
    double medianMs = 0.0, p95Ms = 0.0;  // of warm frames
    double predictedMs = 0.0;            // sum over the plan's decisions; 0: no decisions
    PlanTotals totals;                   // of a warm frame
    LinearErrors frame;                  // linear radiance before tone mapping
    DisplayedErrors displayed;           // of displayed values, before JPEG
    double closedGap = 0.0;
    std::vector<EffectErrors> effects;  // those that are on and visible
    double jpegPsnr = 0.0;              // of the JPEG relative to the uncompressed image
    Image errorPicture;                 // srgb8; empty unless requested
};

struct Comparison {
    ReferenceMode mode = ReferenceMode::effects;
    std::uint32_t samples = 0, seed = 0;
    double truthMs = 0.0;
    double relMseNoise = 0.0;  // of the truth; errors below five times this are not significant
    double relMseOff = 0.0;    // with every effect off
    std::uint64_t nonFinite =
        0;  // samples of the truth that were not finite; above 0 only if there is a bug
    std::vector<SettingResult> settings;  // in the order of settingsOf()
};

// relMSE of the truth's noise, over a mask or the whole image. Smaller errors are not significant.
double relMseNoise(const ReferenceImage& truth, const Mask* mask = nullptr);

// `scene` needs no texels. `progress` receives the completed fraction, 0..1; if it returns false,
// the comparison is cancelled and nothing is returned. Passes on exceptions of `draw`.
std::optional<Comparison> compare(const ComparisonRequest& request, const Scene& scene,
                                  const ReferenceRender& truth, const DrawFrame& draw,
                                  const std::function<bool(double)>& progress = {});

}  // namespace clerestory
