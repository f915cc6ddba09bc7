// Full-screen passes over a finished picture: requested filters, tone mapping, edge filter.
// graph/pass.h describes the members that every pass type has.
#pragma once

#include "plan/graph/sample_costs.h"
#include "plan/graph/target.h"
#include "plan/lens/tiles.h"
#include "plan/request/frame_request.h"
#include "scene/hash.h"

#include <array>
#include <string_view>
#include <vector>

namespace clerestory {

struct Stage;

// Common part: shades each pixel of the target once and reads one picture. No captured map depends
// on these passes, so that they have nothing to hash.
struct PicturePass {
    TargetId source = kNoTarget;

    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const { return "/filters"; }
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash&, const PicturePass&, const Stage&) {}
    bool operator==(const PicturePass&) const = default;
};

// Assembles the frame of a lens from the pictures of its tiles, by weight.
struct AssembleLens {
    Lens lens;
    std::vector<LensTile> tiles;
    std::vector<TargetId> sources;  // one for each tile
    bool numbers = false;           // of a channel: nearest texels of one tile, not mixed
    bool depth = false;             // which change with the direction

    std::string_view kind() const { return "lens"; }
    std::vector<TargetId> reads() const { return sources; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash&, const AssembleLens&, const Stage&) {}  // of frames only
    bool operator==(const AssembleLens&) const = default;
};

// Rotates each pixel about the centre by an angle that depends on its distance.
struct Twirl : PicturePass {
    float turn = 0.0f;    // radians per pixel of distance from the centre
    float radius = 0.0f;  // pixels; nothing changes beyond it
    std::string_view kind() const { return "twirl"; }
    bool operator==(const Twirl&) const = default;
};

// Convolves the picture with a 3 x 3 kernel.
struct Convolve : PicturePass {
    std::array<float, 9> kernel{};  // row by row, first row on top
    bool repeat = false;            // true: beyond a border continues the opposite side
    std::string_view kind() const { return "convolve"; }
    bool operator==(const Convolve&) const = default;
};

// Extracts what is brighter than the threshold, at half the size.
struct GlowBright : PicturePass {
    float threshold = 0.0f;  // radiance
    std::string_view kind() const { return "glowBright"; }
    bool operator==(const GlowBright&) const = default;
};

// Halves the size of the picture.
struct GlowDown : PicturePass {
    std::string_view kind() const { return "glowDown"; }
    bool operator==(const GlowDown&) const = default;
};

// Adds a smaller picture of the pyramid to the next larger one.
struct GlowUp : PicturePass {
    float share = 0.0f;  // weight of the smaller picture, 0..1
    std::string_view kind() const { return "glowUp"; }
    bool operator==(const GlowUp&) const = default;
};

// Adds the spread light to the picture.
struct Glow : PicturePass {
    TargetId spread = kNoTarget;
    float threshold = 0.0f;  // radiance
    float share = 0.0f;      // fraction of the light above the threshold that spreads, 0..1
    std::string_view kind() const { return "glow"; }
    std::vector<TargetId> reads() const { return {source, spread}; }
    bool operator==(const Glow&) const = default;
};

// From two pictures of the same scene, before a black background and before a white one of radiance
// 1: the colour of the first, and alpha, 1 less the difference as the mean of the channels.
struct BackgroundAlpha : PicturePass {
    TargetId white = kNoTarget;
    std::string_view kind() const { return "alpha"; }
    std::string_view knobs() const;
    std::vector<TargetId> reads() const { return {source, white}; }
    bool operator==(const BackgroundAlpha&) const = default;
};

// Linear radiance -> display colour. A transparent picture stays premultiplied and linear: each
// pixel's radiance over its alpha is mapped. Alpha grows to the brightest channel of what the pixel
// shows over black, so that highlights on clear glass are kept.
struct ToneMapping : PicturePass {
    ToneMap curve = ToneMap::neutral;
    float exposureFactor = 1.0f;
    bool edgeFilterFollows = false;  // then alpha holds the brightness that it reads
    bool transparent = false;        // then alpha stays alpha
    std::string_view kind() const { return "toneMap"; }
    std::string_view knobs() const;
    bool operator==(const ToneMapping&) const = default;
};

// Smooths edges in the display colour.
struct EdgeFilter : PicturePass {
    bool transparent = false;  // edges of alpha too; colour is premultiplied
    bool compressed = false;   // the tone curve compresses bright colours
    bool ofSamples = false;    // pixels have several samples, so that less is left to smooth
    std::string_view kind() const { return "edgeFilter"; }
    std::string_view knobs() const;
    bool operator==(const EdgeFilter&) const = default;
};

// Premultiplied, linear display colour -> straight alpha, encoded.
struct StraightAlpha : PicturePass {
    std::string_view kind() const { return "straightAlpha"; }
    std::string_view knobs() const;
    bool operator==(const StraightAlpha&) const = default;
};

}  // namespace clerestory
