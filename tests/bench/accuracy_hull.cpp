#include "accuracy_hull.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace clerestory::bench {

std::vector<std::size_t> lowerHull(const std::vector<CostAndError>& points) {
    std::vector<std::size_t> order(points.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        const CostAndError &p = points[a], &q = points[b];
        if (p.milliseconds != q.milliseconds) return p.milliseconds < q.milliseconds;
        return p.error != q.error ? p.error < q.error : a < b;
    });
    // The left turn of the path a, b, c in logarithmic coordinates; negative: right.
    const auto turn = [&](std::size_t a, std::size_t b, std::size_t c) {
        const double abx = std::log(points[b].milliseconds / points[a].milliseconds),
                     aby = std::log(points[b].error / points[a].error),
                     acx = std::log(points[c].milliseconds / points[a].milliseconds),
                     acy = std::log(points[c].error / points[a].error);
        return abx * acy - aby * acx;
    };
    std::vector<std::size_t> hull;
    for (const std::size_t i : order) {
        // Behind the one with the least error so far everything costs more and gives nothing.
        if (!hull.empty() && points[i].error >= points[hull.back()].error) continue;
        while (hull.size() > 1 && turn(hull[hull.size() - 2], hull.back(), i) <= 0.0) {
            hull.pop_back();
        }
        hull.push_back(i);
    }
    return hull;
}

std::optional<std::size_t> betterInBoth(const std::vector<CostAndError>& points, std::size_t index,
                                        double share) {
    const CostAndError& p = points[index];
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const CostAndError& q = points[i];
        if (q.milliseconds * (1.0 + share) >= p.milliseconds) continue;
        if (q.error * (1.0 + share) >= p.error) continue;
        if (!best || q.error < points[*best].error) best = i;
    }
    return best;
}

}  // namespace clerestory::bench
