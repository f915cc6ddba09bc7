// Passes that draw the scene from one view.
//
// Every pass type says its kind (the word that the API uses), the targets it reads, what it costs
// and what its picture depends on; see graph/pass.h.
#pragma once

#include "plan/graph/draw.h"
#include "scene/hash.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

struct FramePlan;
struct Stage;

// Depth, opaque, masked, the sky where nothing was drawn, then what is blended.
struct DrawScene {
    enum class Purpose { surface, mirror, capture };
    Purpose purpose = Purpose::surface;  // the requested view, a mirrored one, a cube's face
    std::uint32_t face = 0;              // of a cube target
    View view;
    std::string map;                   // that lights the view or is its sky; empty: neither
    TargetId environment = kNoTarget;  // that map, prefiltered: what lights the draws
    bool sky = false;
    std::vector<ReflectedPicture> reflections;
    // In drawing order. depthDraws are those of the opaque draws, not masked, that hide much of the
    // others; empty when a depth prepass would not pay.
    std::vector<Draw> depthDraws;
    std::vector<Draw> opaqueDraws;   // masked ones last
    std::vector<Draw> blendedDraws;  // far to near

    std::string_view kind() const;
    std::vector<TargetId> reads() const;
    std::vector<std::span<const Draw>> drawLists() const {
        return {depthDraws, opaqueDraws, blendedDraws};
    }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const DrawScene&) const = default;
};

// A layer of glass over what its backdrop holds, then what is blended over it.
struct DrawGlass {
    std::uint32_t face = 0;  // of a cube target
    View view;
    std::string map;                   // as of DrawScene
    TargetId environment = kNoTarget;  // as of DrawScene
    TargetId backdrop = kNoTarget;     // what the glass is seen against
    TargetId backFaces = kNoTarget;    // where solid glass ends; or none
    std::vector<ReflectedPicture> reflections;
    std::vector<Draw> glassDraws;
    std::vector<Draw> blendedDraws;  // far to near

    std::string_view kind() const { return "glass"; }
    std::vector<TargetId> reads() const;
    std::vector<std::span<const Draw>> drawLists() const { return {glassDraws, blendedDraws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const DrawGlass&) const = default;
};

// The far sides of solid glass, as normals and distances.
struct DrawBackFaces {
    View view;
    std::vector<Draw> draws;

    std::string_view kind() const { return "backFaces"; }
    std::vector<TargetId> reads() const { return {}; }
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const DrawBackFaces&) const = default;
};

// Depth, normals or numbers instead of colour; which is FramePlan::channel.
struct DrawChannel {
    View view;
    std::vector<Draw> draws;

    std::string_view kind() const { return "channel"; }
    std::vector<TargetId> reads() const { return {}; }
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const DrawChannel&) const = default;
};

// Copies what was drawn so far, which glass is then seen against, with all levels of the target.
struct CopyBackdrop {
    TargetId source = kNoTarget;
    std::uint32_t face = 0;  // of a cube source

    std::string_view kind() const { return "backdrop"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const FramePlan& plan) const;
    void addTo(PlanHash& hash, const Stage& stage) const;
    bool operator==(const CopyBackdrop&) const = default;
};

}  // namespace clerestory
