// Measures time and error of accuracy settings for one view of one scene: the request, the
// comparison with the reference picture, and its result. Draws through a callback, so that it does
// not depend on OpenGL or on its thread.
#pragma once

#include "measures/errors.h"
#include "plan/graph/frame_plan.h"
#include "plan/request/frame_request.h"
#include "reference/reference.h"

#include <memory>

namespace clerestory {

struct ComparisonRequest {
    FrameRequest frame;              // its accuracy is the first setting if settings is empty
    std::vector<Accuracy> settings;  // empty: the frame's own and every preset
    ReferenceMode mode = ReferenceMode::full;
    std::uint32_t samples = 64;  // paths per pixel of the reference
    std::uint32_t seed = 1;      // of the reference's random numbers
    std::uint32_t frames = 15;   // warm frames measured for each setting
    bool errorPictures = false;  // make a picture of the error of each setting
};

inline constexpr std::size_t kMaxSettings = 32;
// Limit of samples x pixels: a reference with more paths takes hours.
inline constexpr double kMaxPaths = 4e9;

template <class V>
void fields(ComparisonRequest& c, V&& visit) {
    fields(c.frame, visit);
    visit("settings", c.settings, NestedPresetList{kMaxSettings},
          "values of accuracy to compare; the frame's own and every preset when empty");
    visit(
        "mode", c.mode,
        Choice<ReferenceMode>{{{"effects", ReferenceMode::effects}, {"full", ReferenceMode::full}}},
        "light transport of the reference; full: all of it; effects: exact mirrors and glass, but "
        "neither shadows nor light between surfaces");
    visit("samples", c.samples, Range{2, 16384}, "paths per pixel of the reference");
    visit("seed", c.seed, Range{0, 4294967295.0}, "seed of the reference's random numbers");
    visit("frames", c.frames, Range{1, 200}, "warm frames measured for each setting");
    visit("errorPictures", c.errorPictures, Flag{},
          "true: the result links to a picture of the error of each setting");
}

// problems(FrameRequest), and the total number of paths.
std::vector<FieldError> problems(const ComparisonRequest& request);

// The settings to compare: not empty, without duplicates.
std::vector<Accuracy> settingsOf(const ComparisonRequest& request);

// The name of the preset, followed by the fields that differ from it, such as
// "standard, probeSize 512".
std::string nameOf(const Accuracy& accuracy);

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
    double relMseNoise = 0.0;  // over these pixels, of the noise of the reference
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
    double modelDecibels = 0.0;          // decibels() over the pixels that show the scene
    double closedGap = 0.0;
    std::vector<EffectErrors> effects;  // those that are on and visible
    double jpegPsnr = 0.0;              // of the JPEG relative to the uncompressed image
    Image errorPicture;                 // srgb8; empty unless requested
};

struct Comparison {
    ReferenceMode mode = ReferenceMode::effects;
    std::uint32_t samples = 0, seed = 0;
    double truthMs = 0.0;
    double relMseNoise = 0.0;  // of the reference; errors below five times this are insignificant
    double relMseOff = 0.0;    // with every effect off
    std::uint64_t nonFinite =
        0;  // samples of the reference that were not finite; above 0 only if there is a bug
    std::vector<SettingResult> settings;  // in the order of settingsOf()
};

// relMSE of the reference's noise, over a mask or the whole image. Smaller errors are not
// significant.
double relMseNoise(const ReferenceImage& truth, const Mask* mask = nullptr);

// `scene` needs no texels. `progress` receives the completed fraction, 0..1; if it returns false,
// the comparison is cancelled and nothing is returned. Passes on exceptions of `draw`.
std::optional<Comparison> compare(const ComparisonRequest& request, const Scene& scene,
                                  const ReferenceRender& truth, const DrawFrame& draw,
                                  const std::function<bool(double)>& progress = {});

}  // namespace clerestory
