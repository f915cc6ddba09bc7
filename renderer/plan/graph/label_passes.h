// Passes that derive labels from what DrawChannel drew. graph/pass.h describes the members that
// every pass type has.
#pragma once

#include "plan/graph/draw.h"
#include "plan/graph/projection.h"
#include "plan/graph/sample_costs.h"
#include "plan/graph/target.h"
#include "scene/hash.h"

#include <span>
#include <string_view>
#include <vector>

namespace clerestory {

struct Stage;

// What the n-th draw of the surfaces of pixels shows: primitives of an instance, from this index
// on.
struct SurfaceDraw {
    Index instance = 0;
    std::uint32_t firstIndex = 0;  // into Scene::indices
    bool mirrors = false;          // it reflects the scene
    bool operator==(const SurfaceDraw&) const = default;
};

// Computes on the processor, for each pixel, where the point of its surface is in another frame, or
// where a mirror or glass shows it there.
struct MeasureFlow {
    TargetId source = kNoTarget;  // for each pixel: 1 + index of `draws`, number of the primitive
    std::vector<SurfaceDraw> draws;
    Projection from, to;
    double time = 0.0;  // of the other frame, seconds
    OutputLayer layer = OutputLayer::direct;

    std::string_view kind() const { return "flow"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash&, const MeasureFlow&, const Stage&) {}  // of frames only
    bool operator==(const MeasureFlow&) const = default;
};

// Finds on the processor, for each pixel, what its surface mirrors or lets through, along one ray,
// and writes the channel of that.
struct FollowLayer {
    TargetId source = kNoTarget;  // as of MeasureFlow
    std::vector<SurfaceDraw> draws;
    Projection from;
    OutputLayer layer = OutputLayer::reflected;
    std::vector<std::uint32_t> labels;  // of instances; empty: instance + 1

    std::string_view kind() const { return "layer"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash&, const FollowLayer&, const Stage&) {}  // of frames only
    bool operator==(const FollowLayer&) const = default;
};

// Counts on the processor the pixels of mirrors and glass that show each instance in a layer, and
// those that would if the other instances were absent.
struct CountLayer {
    TargetId source = kNoTarget;  // as of MeasureFlow
    std::vector<SurfaceDraw> draws;
    Projection from;
    OutputLayer layer = OutputLayer::reflected;

    std::string_view kind() const { return "instances"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash&, const CountLayer&, const Stage&) {}  // of frames only
    bool operator==(const CountLayer&) const = default;
};

// Counts the pixels of each instance: those that show it, and those that would if it were alone,
// for which it is drawn alone into the target.
struct MeasureInstances {
    // Some of `draws`, and what they cover at most.
    struct Alone {
        Index instance = 0;
        std::uint32_t firstDraw = 0, drawCount = 0;
        TargetRect rect;
        bool operator==(const Alone&) const = default;
    };

    TargetId source = kNoTarget;  // 1 + instance of each pixel
    View view;
    std::vector<Draw> draws;  // by instance
    std::vector<Alone> instances;

    std::string_view kind() const { return "instances"; }
    std::vector<TargetId> reads() const { return {source}; }
    std::vector<std::span<const Draw>> drawLists() const { return {draws}; }
    std::string_view knobs() const;
    std::uint64_t shadedSamples(const TargetSpec& target, const SampleFactors& factors) const;
    friend void addTo(PlanHash&, const MeasureInstances&, const Stage&) {}  // of frames only
    bool operator==(const MeasureInstances&) const = default;
};

}  // namespace clerestory
