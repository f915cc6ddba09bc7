#include "server/live/pace.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace clerestory {
namespace {

constexpr double kSlow = 1.2, kVerySlow = 2.0;  // of the target
constexpr double kFast = 0.8;                   // of the target, expected of the finer level
constexpr int kSlowFrames = 2, kFastFrames = 4;
constexpr double kForgetting = 0.99;
constexpr double kDirect = 2.0;  // of the target: level 0 needs no step before it
constexpr double kStep = 0.25;   // of the time of level 0

}  // namespace

Pace::Pace(Ladder ladder, double targetMs)
    : ladder_(std::move(ladder)),
      targetMs_(targetMs),
      moving_(ladder_.levels.size() - 1),
      times_(ladder_.levels.size()) {}

// The nearest measured level in that direction.
std::optional<std::size_t> Pace::nearest(std::size_t level, int step) const {
    const auto size = static_cast<std::ptrdiff_t>(times_.size());
    for (auto i = static_cast<std::ptrdiff_t>(level) + step; i >= 0 && i < size; i += step) {
        if (times_[static_cast<std::size_t>(i)]) return static_cast<std::size_t>(i);
    }
    return std::nullopt;
}

double Pace::expected(std::size_t level) const {
    if (times_[level]) return *times_[level];
    const auto finer = nearest(level, -1), coarser = nearest(level, 1);
    if (finer && coarser) {
        const double share = (cost(level) - cost(*coarser)) / (cost(*finer) - cost(*coarser));
        return std::lerp(*times_[*coarser], *times_[*finer], share);
    }
    // Part of the time does not depend on pixels: too much for finer levels.
    const auto known = finer ? finer : coarser;
    return known ? *times_[*known] * cost(level) / cost(*known) : 0.0;
}

// The finest level that is expected within that time, not finer than `from`; the coarsest one if
// none is.
std::size_t Pace::finestWithin(double milliseconds, std::size_t from) const {
    std::size_t level = from;
    while (level + 1 < times_.size() && expected(level) > milliseconds) ++level;
    return level;
}

std::size_t Pace::refined(std::size_t level) const {
    if (level == 0) return 0;
    const double full = expected(0);
    if (full <= kDirect * std::max(targetMs_, expected(level))) return 0;
    const std::size_t step = finestWithin(std::max(kStep * full, kDirect * targetMs_), 1);
    return step < level ? step : 0;
}

void Pace::moveTo(std::size_t level) {
    moving_ = level;
    slow_ = fast_ = 0;
}

bool Pace::finerIsFast() const {
    const std::size_t finer = moving_ - 1;
    const bool known = times_[finer] || nearest(finer, -1);
    const double ratio = cost(finer) / cost(moving_);
    // If it proves slow, only two frames are lost.
    const double ms = known ? expected(finer) : *times_[moving_] * std::sqrt(ratio);
    return ms <= kFast * targetMs_;
}

void Pace::measured(std::size_t level, double milliseconds) {
    for (auto& time : times_) {
        if (time) *time *= kForgetting;
    }
    std::optional<double>& time = times_[level];
    time = time ? 0.5 * (*time / kForgetting + milliseconds) : milliseconds;
    if (!std::exchange(begun_, true)) return moveTo(finestWithin(kFast * targetMs_, 0));
    if (level != moving_) return;
    slow_ = milliseconds > kSlow * targetMs_ ? slow_ + 1 : 0;
    const bool isCoarsest = moving_ + 1 == times_.size();
    if (!isCoarsest && (slow_ >= kSlowFrames || milliseconds > kVerySlow * targetMs_)) {
        // The view may have changed since the others were measured.
        std::fill(times_.begin(), times_.end(), std::nullopt);
        times_[level] = milliseconds;
        moveTo(finestWithin(targetMs_, level + 1));
        // A single interruption must not keep the level out of use for long.
        times_[level] = std::min(milliseconds, kVerySlow * targetMs_);
        return;
    }
    if (moving_ == 0) return;
    fast_ = finerIsFast() ? fast_ + 1 : 0;
    if (fast_ >= kFastFrames) moveTo(std::min(moving_ - 1, finestWithin(kFast * targetMs_, 0)));
}

}  // namespace clerestory
