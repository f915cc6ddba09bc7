// One step of a frame: what every pass has, and the work of its own type.
//
// A pass type is a plain struct with
//   kind()                          the word that the API, timings and tests use
//   reads()                         targets of earlier passes that it reads
//   knobs()                         fields of a request that its work comes from: "/a, /b"
//   shadedSamples(target, plan)     what it costs; see work.h
//   addTo(hash, stage)              everything that its picture depends on, reads() apart
// and, where it draws the scene, `view` and drawLists(), and where it reads a stored environment
// map, `map`. A new one is added to PassWork, and gets an
// execute() in passes/; nothing else changes.
#pragma once

#include "plan/graph/effect.h"
#include "plan/graph/map_passes.h"
#include "plan/graph/picture_passes.h"
#include "plan/graph/scene_passes.h"

#include <variant>

namespace clerestory {

using PassWork = std::variant<PrefilterMap, PrefilterCube, BlurCube, BuildLevels, DrawScene,
                              DrawGlass, DrawBackFaces, DrawChannel, CopyBackdrop, Twirl, Convolve,
                              GlowBright, GlowDown, GlowUp, Glow, ToneMapping, EdgeFilter>;

struct Pass {
    std::string name;
    Effect effect = Effect::base;
    std::uint32_t generation = 0;  // 0: of the requested view; k: k reflections behind it
    TargetId target = kNoTarget;
    std::string reason;
    PassWork work;

    std::string_view kind() const;
    std::vector<TargetId> reads() const;
    std::string_view knobs() const;
    const View* view() const;                              // null: draws no scene
    std::string_view map() const;                          // stored map that it reads; or empty
    std::vector<std::span<const Draw>> drawLists() const;  // in drawing order
    bool operator==(const Pass&) const = default;
};

// Whether some draw follows rays.
bool followsRays(const Pass& pass);

}  // namespace clerestory
