// The request for a comparison: a frame, and the accuracies to compare with the reference picture.
// A plain value; its field table is that of the frame with some fields added.
#pragma once

#include "plan/request/frame_request.h"
#include "reference/reference.h"

namespace clerestory {

struct ComparisonRequest {
    FrameRequest frame;              // its accuracy is the first setting if settings is empty
    std::vector<Accuracy> settings;  // empty: the frame's own and every preset
    ReferenceMode mode = ReferenceMode::effects;
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
        "light transport of the reference; effects: the renderer's lights with exact mirrors and "
        "glass; full: also shadows and light between surfaces");
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

}  // namespace clerestory
