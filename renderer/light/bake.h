// Computes the light at the vertices of a scene with rays, in rounds that each bring it nearer to
// its limit.
//
//     Bake bake(input, {});
//     while (!bake.complete()) {
//         for (every range of samples) bake.work(first, end);  // from any number of threads
//         bake.endRound();
//     }
//     const SurfaceLight light = bake.light();
//
// Pure: the results depend neither on threads nor on the order of ranges.
#pragma once

#include "light/bake_input.h"
#include "light/surface_light.h"

#include <cstdint>
#include <memory>

namespace clerestory::light {

class Bake {
public:
    Bake(BakeInput input, const BakeQuality& quality);
    ~Bake();
    Bake(const Bake&) = delete;
    Bake& operator=(const Bake&) = delete;

    // Places where light is gathered.
    std::uint32_t samples() const;
    bool complete() const;
    // Samples first .. end of the present round; each belongs to one call.
    void work(std::uint32_t first, std::uint32_t end);
    // After all samples of the round.
    void endRound();
    // After any round.
    SurfaceLight light() const;

    std::uint64_t rays() const;  // followed so far
    std::uint64_t bytes() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace clerestory::light
