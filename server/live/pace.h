// Chooses the level of live frames (server/live/ladder.h) from measured milliseconds: in motion
// toward a target time per frame, at rest in steps up to the request itself. A value without clock
// and threads:
//
//     Pace pace(ladderOf(request), 100.0);
//     pace.measured(level, milliseconds);  // of each frame that was drawn
//     next = pace.moving();                // the level of the next frame in motion
//     next = pace.refined(level);          // at rest, after a frame of `level` > 0
//
// In motion the first frame has the coarsest level, and its time gives the next one. Later a frame
// is slow above 1.2 of the target: two in turn, or one of twice the target, lead to a coarser
// level. Four frames in turn after which the next finer level is expected within 0.8 of the target
// lead to that level. The measured time of a level that is not used is trusted less and less: it
// shrinks by 1 % per frame, so that a finer level is tried again.
#pragma once

#include "server/live/ladder.h"

#include <cstddef>
#include <optional>
#include <vector>

namespace clerestory {

class Pace {
public:
    // `targetMs`: of a frame in motion, above 0.
    Pace(Ladder ladder, double targetMs);

    const Ladder& ladder() const { return ladder_; }
    std::size_t moving() const { return moving_; }

    // The next level at rest. The last step is level 0. Before it comes a cheaper one if level 0 is
    // expected to take more than twice the target and twice the time of `level`: the finest level
    // within a quarter of that time or twice the target.
    std::size_t refined(std::size_t level) const;

    // `milliseconds`: of drawing and encoding, without waiting and without compiling shaders.
    void measured(std::size_t level, double milliseconds);

    // Expected time of a level: measured, or from the nearest measured levels. 0 before the first
    // measurement.
    double expected(std::size_t level) const;

private:
    std::optional<std::size_t> nearest(std::size_t level, int step) const;
    double cost(std::size_t level) const { return ladder_.levels[level].cost(); }
    bool finerIsFast() const;
    void moveTo(std::size_t level);
    std::size_t finestWithin(double milliseconds, std::size_t from) const;

    Ladder ladder_;
    double targetMs_;
    std::size_t moving_;
    std::vector<std::optional<double>> times_;  // smoothed, by level
    bool begun_ = false;
    int slow_ = 0, fast_ = 0;  // frames in turn
};

}  // namespace clerestory
