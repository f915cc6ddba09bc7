// What a comparison is asked for: a frame, and the accuracies to hold against the truth. A plain
// value; its field table is the frame's with a few fields more.
#pragma once

#include "plan/request/frame_request.h"
#include "reference/reference.h"

namespace clerestory {

struct ComparisonRequest {
    FrameRequest frame;  // its accuracy stands first among the settings if none are given
    std::vector<Accuracy> settings;  // empty: the frame's own and every preset
    ReferenceMode mode = ReferenceMode::effects;
    std::uint32_t samples = 64;  // paths a pixel of the truth
    std::uint32_t seed = 1;      // of its random numbers
    std::uint32_t frames = 15;   // warm frames measured for each setting
    bool errorPictures = false;  // a picture of each setting's error
};

inline constexpr std::size_t kMaxSettings = 32;
// A truth of more paths takes hours.
inline constexpr double kMaxPaths = 4e9;

template <class V>
void fields(ComparisonRequest& c, V&& visit) {
    fields(c.frame, visit);
    visit("settings", c.settings, NestedPresetList{kMaxSettings},
          "accuracies to compare; the frame's own and every preset when there are none");
    visit(
        "mode", c.mode,
        Choice<ReferenceMode>{{{"effects", ReferenceMode::effects}, {"full", ReferenceMode::full}}},
        "the truth's light: as the renderer lights, with true mirrors and glass; or with shadows "
        "and light from surface to surface too");
    visit("samples", c.samples, Range{2, 16384}, "paths a pixel of the truth");
    visit("seed", c.seed, Range{0, 4294967295.0}, "of the truth's random numbers");
    visit("frames", c.frames, Range{1, 200}, "warm frames measured for each setting");
    visit("errorPictures", c.errorPictures, Flag{}, "a picture of each setting's error");
}

// As problems(FrameRequest), and the paths in all.
std::vector<FieldError> problems(const ComparisonRequest& request);

// The settings that are compared: never empty, none twice.
std::vector<Accuracy> settingsOf(const ComparisonRequest& request);

// A preset's name when every knob is the preset's; otherwise its name and the knobs that differ, as
// in "standard, probeSize 512".
std::string nameOf(const Accuracy& accuracy);

}  // namespace clerestory
