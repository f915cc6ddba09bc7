// One step of a frame: a header, and the data of its type.
//
// A pass type is a plain struct with
//   kind()                          its name in the API, in timings and in tests
//   reads()                         targets of earlier passes that it reads
//   knobs()                         fields of a request that determine its cost: "/a, /b"
//   shadedSamples(target, factors)  its cost; see work.h
//   addTo(hash, work, stage)        hashes every member except the targets of reads(). It binds all
//                                   members by name, so that a new member does not compile before
//                                   addTo() handles it
// and, if it draws the scene, `view` and drawLists(); if it reads a stored environment map, `map`.
// A new type is added to PassWork and needs an execute() in passes/.
#pragma once

#include "plan/graph/effect.h"
#include "plan/graph/emitter_coverage.h"
#include "plan/graph/label_passes.h"
#include "plan/graph/map_passes.h"
#include "plan/graph/picture_passes.h"
#include "plan/graph/scene_passes.h"
#include "plan/graph/subject.h"
#include "plan/graph/supersampling.h"

#include <variant>

namespace clerestory {

using PassWork =
    std::variant<PrefilterMap, PrefilterCube, BlurCube, BuildLevels, DrawScene, DrawGlass,
                 DrawBlended, FollowRays, DrawShadow, DrawShadowTint, DrawBackFaces, DrawChannel,
                 CopyBackdrop, EmitterCoverage, Supersampling, AssembleLens, Twirl, Convolve,
                 GlowBright, GlowDown, GlowUp, Glow, BackgroundAlpha, ToneMapping, EdgeFilter,
                 StraightAlpha, MeasureFlow, MeasureInstances, FollowLayer, CountLayer>;

struct Pass {
    std::string name;
    Subject subject;
    Effect effect = Effect::base;
    std::uint32_t generation = 0;  // 0: the requested view; k: seen through k reflections
    TargetId target = kNoTarget;
    std::string reason;
    PassWork work;

    std::string_view kind() const;
    std::vector<TargetId> reads() const;
    std::string_view knobs() const;
    const View* view() const;                              // null: does not draw the scene
    std::string_view map() const;                          // stored map that it reads, or empty
    std::vector<std::span<const Draw>> drawLists() const;  // in drawing order
    const RecordedDraws* recorded() const;                 // null: the type has none
    std::uint32_t face() const;                            // of a cube target; 0 for planes
    bool operator==(const Pass&) const = default;
};

// Returns true if a draw of the pass traces rays.
bool followsRays(const Pass& pass);

// The layer for which the pass asks on the processor what rays meet; direct: it does not.
OutputLayer layerOf(const Pass& pass);

}  // namespace clerestory
