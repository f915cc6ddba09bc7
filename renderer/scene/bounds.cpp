#include "scene/bounds.h"

namespace clerestory {

bool inReach(const Bounds& box) {
    const glm::vec3 farthest(kMaxCoordinate);
    return glm::all(glm::lessThan(glm::abs(box.min), farthest)) &&
           glm::all(glm::lessThan(glm::abs(box.max), farthest));
}

bool inReach(const glm::dmat4& m) {
    const glm::dvec4 farthest(1e30);
    bool all = true;
    for (int column = 0; column < 4; ++column) {
        all = all && glm::all(glm::lessThan(glm::abs(m[column]), farthest));
    }
    return all;
}

Bounds transformed(const Bounds& box, const glm::dmat4& toFromBox) {
    if (box.empty()) return box;
    // Arvo 1990: each axis sums the smaller and the larger products.
    glm::dvec3 low(toFromBox[3]), high(toFromBox[3]);
    for (int column = 0; column < 3; ++column) {
        const glm::dvec3 axis(toFromBox[column]);
        const glm::dvec3 a = axis * static_cast<double>(box.min[column]);
        const glm::dvec3 b = axis * static_cast<double>(box.max[column]);
        low += glm::min(a, b);
        high += glm::max(a, b);
    }
    Bounds result;
    result.min = glm::vec3(low);
    result.max = glm::vec3(high);
    return result;
}

}  // namespace clerestory
