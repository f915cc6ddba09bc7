// Full-screen passes over a finished picture: the filters that a request asks for, the tone curve,
// the smoothing of edges. See graph/pass.h for what every pass type says.
#pragma once

#include "plan/graph/target.h"
#include "plan/request/frame_request.h"
#include "scene/hash.h"

#include <array>
#include <string_view>
#include <vector>

namespace clerestory {

struct FramePlan;
struct Stage;

// Their common part: each pixel of the target is shaded once, from one picture. No captured map
// depends on them.
struct PicturePass {
    TargetId source = kNoTarget;

    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const { return "/filters"; }
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash&, const Stage&) const {}
    bool operator==(const PicturePass&) const = default;
};

// Turns a picture about its centre.
struct Twirl : PicturePass {
    float turn = 0.0f;    // radians per pixel of distance from the centre
    float radius = 0.0f;  // pixels; farther out nothing turns
    std::string_view kind() const { return "twirl"; }
    bool operator==(const Twirl&) const = default;
};

// Weighs each pixel with its eight neighbours.
struct Convolve : PicturePass {
    std::array<float, 9> kernel{};  // row by row, first row on top
    bool repeat = false;            // beyond a border lies the opposite one
    std::string_view kind() const { return "convolve"; }
    bool operator==(const Convolve&) const = default;
};

// What is bright in a picture, half as large.
struct GlowBright : PicturePass {
    float threshold = 0.0f;  // radiance
    std::string_view kind() const { return "glowBright"; }
    bool operator==(const GlowBright&) const = default;
};

// The same half as large again.
struct GlowDown : PicturePass {
    std::string_view kind() const { return "glowDown"; }
    bool operator==(const GlowDown&) const = default;
};

// Adds a wider spread to the next narrower one.
struct GlowUp : PicturePass {
    float share = 0.0f;  // of the wider one
    std::string_view kind() const { return "glowUp"; }
    bool operator==(const GlowUp&) const = default;
};

// Puts spread light back into the picture it came from.
struct Glow : PicturePass {
    TargetId spread = kNoTarget;
    float threshold = 0.0f;  // radiance
    float share = 0.0f;      // of what is brighter, that spreads
    std::string_view kind() const { return "glow"; }
    std::vector<TargetId> reads() const { return {source, spread}; }
    bool operator==(const Glow&) const = default;
};

// Linear radiance -> display colour.
struct ToneMapping : PicturePass {
    ToneMap curve = ToneMap::neutral;
    float exposureFactor = 1.0f;
    bool edgeFilterFollows = false;  // which reads brightness from alpha
    std::string_view kind() const { return "toneMap"; }
    std::string_view knobs() const;
    bool operator==(const ToneMapping&) const = default;
};

// Smooths edges of the display colour.
struct EdgeFilter : PicturePass {
    std::string_view kind() const { return "edgeFilter"; }
    std::string_view knobs() const;
    bool operator==(const EdgeFilter&) const = default;
};

}  // namespace clerestory
