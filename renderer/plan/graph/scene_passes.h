// Passes that draw the scene from one view. graph/pass.h describes the members that every pass type
// has.
#pragma once

#include "plan/graph/draw.h"
#include "plan/graph/sample_costs.h"
#include "scene/hash.h"

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace clerestory {

struct Stage;

// Draws whose rays the processor follows: they write records of their rays into targets of the
// view's size, which FollowRays reads. They are drawn after the others, so that a record belongs to
// what is visible.
struct RecordedDraws {
    std::vector<TargetId> targets;  // two for mirrors, two more for glass; empty without draws
    std::vector<Draw> draws;
    TargetRect rect;  // contains what they cover
    bool operator==(const RecordedDraws&) const = default;
};

// Draws depth, opaque and masked surfaces, the sky behind them, then blended surfaces.
struct DrawScene {
    enum class Purpose { surface, mirror, capture };
    Purpose purpose = Purpose::surface;  // requested view, mirrored view, face of a cube
    std::uint32_t face = 0;              // of a cube target
    View view;
    std::string map;                   // environment map of the lighting and the sky; may be empty
    TargetId environment = kNoTarget;  // the prefiltered map that lights the draws
    bool sky = false;
    OwnBackground background;
    std::vector<ReflectedPicture> reflections;
    // In drawing order. depthDraws are the opaque draws that occlude most of the others; empty
    // without a depth prepass.
    std::vector<Draw> depthDraws;
    std::vector<Draw> opaqueDraws;   // masked ones last
    RecordedDraws recorded;          // opaque
    std::vector<Draw> blendedDraws;  // far to near

    std::string_view kind() const;
    std::vector<TargetId> reads() const;
    std::vector<std::span<const Draw>> drawLists() const {
        return {depthDraws, opaqueDraws, recorded.draws, blendedDraws};
    }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawScene& work, const Stage& stage);
    bool operator==(const DrawScene&) const = default;
};

// Draws a layer of glass over its backdrop, then blended surfaces in front of it.
struct DrawGlass {
    std::uint32_t face = 0;  // of a cube target
    View view;
    std::string map;                   // as in DrawScene
    TargetId environment = kNoTarget;  // as in DrawScene
    TargetId backdrop = kNoTarget;     // picture behind the glass
    TargetId backFaces = kNoTarget;    // exit points of solid glass, or none
    OwnBackground background;
    std::vector<ReflectedPicture> reflections;
    std::vector<Draw> glassDraws;
    RecordedDraws recorded;
    std::vector<Draw> blendedDraws;  // far to near

    std::string_view kind() const { return "glass"; }
    std::vector<TargetId> reads() const;
    std::vector<std::span<const Draw>> drawLists() const {
        return {glassDraws, recorded.draws, blendedDraws};
    }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawGlass& work, const Stage& stage);
    bool operator==(const DrawGlass&) const = default;
};

// Draws blended surfaces over a view whose rays have been added. Far to near; if the last draw has
// rays, `recorded` holds it.
struct DrawBlended {
    std::uint32_t face = 0;  // of a cube target
    View view;
    std::string map;                   // as in DrawScene
    TargetId environment = kNoTarget;  // as in DrawScene
    OwnBackground background;
    std::vector<ReflectedPicture> reflections;
    std::vector<Draw> draws;
    RecordedDraws recorded;

    std::string_view kind() const { return "blended"; }
    std::vector<TargetId> reads() const;
    std::vector<std::span<const Draw>> drawLists() const { return {draws, recorded.draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawBlended& work, const Stage& stage);
    bool operator==(const DrawBlended&) const = default;
};

// Follows the recorded rays of a pass on the processor and adds their light to the target.
struct FollowRays {
    std::uint32_t face = 0;  // of a cube target
    View view;
    std::string map;                   // as in DrawScene
    TargetId environment = kNoTarget;  // as in DrawScene
    OwnBackground background;
    std::vector<TargetId> records;  // RecordedDraws::targets
    TargetRect rect;                // RecordedDraws::rect
    TargetId radiance = kNoTarget;  // receives the light before it is added
    // Each pixel follows a ray of its own, whatever RayScene::stride says. Where that would depend
    // on the light behind glass, pictures before different backgrounds would differ by more than
    // these.
    bool everyPixel = false;

    std::string_view kind() const { return "rays"; }
    std::vector<TargetId> reads() const;
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const FollowRays& work, const Stage& stage);
    bool operator==(const FollowRays&) const = default;
};

// Draws the depth of what hides a light from others, as the light sees it, into a tile of the
// shadow map: the back faces of one-sided surfaces, and both of others. The nearest of them hides
// the light from everything behind it.
struct DrawShadow {
    View view;
    TargetRect tile;
    std::vector<Draw> draws;
    TargetId still = kNoTarget;  // a map whose tile it begins with

    std::string_view kind() const { return "shadow"; }
    std::vector<TargetId> reads() const;
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawShadow& work, const Stage& stage);
    bool operator==(const DrawShadow&) const = default;
};

// Draws what glass and blended surfaces leave of a light, and the depth of the nearest of them,
// into a tile of a map that is half as large as the shadow map. What is behind the nearest has the
// light that all of them leave.
struct DrawShadowTint {
    View view;
    TargetRect tile;
    std::vector<Draw> draws;

    std::string_view kind() const { return "shadowTint"; }
    std::vector<TargetId> reads() const { return {}; }
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawShadowTint& work, const Stage& stage);
    bool operator==(const DrawShadowTint&) const = default;
};

// Draws the back faces of solid glass, as normals and distances.
struct DrawBackFaces {
    View view;
    std::vector<Draw> draws;

    std::string_view kind() const { return "backFaces"; }
    std::vector<TargetId> reads() const { return {}; }
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawBackFaces& work, const Stage& stage);
    bool operator==(const DrawBackFaces&) const = default;
};

// Draws depth, normals or identifiers instead of colour, as FramePlan::channel says.
struct DrawChannel {
    View view;
    std::vector<Draw> draws;

    std::string_view kind() const { return "channel"; }
    std::vector<TargetId> reads() const { return {}; }
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const DrawChannel& work, const Stage& stage);
    bool operator==(const DrawChannel&) const = default;
};

// Copies the picture drawn so far as the background of glass, and builds all levels of the target.
struct CopyBackdrop {
    TargetId source = kNoTarget;
    std::uint32_t face = 0;  // of a cube source

    std::string_view kind() const { return "backdrop"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash& hash, const CopyBackdrop& work, const Stage& stage);
    bool operator==(const CopyBackdrop&) const = default;
};

}  // namespace clerestory
