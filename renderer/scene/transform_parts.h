// Transforms as requests give them: translation, rotation and scale, or a matrix. Each part may be
// absent.
//
//     errors = problems(parts, "/nodes/0");
//     node.parentFromLocal = changed(node.parentFromLocal, parts);
#pragma once

#include "scene/animation.h"
#include "scene/fields.h"
#include "scene/geometry.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace clerestory {

struct TransformParts {
    std::optional<glm::dvec3> translation;  // metres
    std::optional<Quaternion> rotation;     // x y z w
    std::optional<glm::dvec3> scale;
    std::optional<std::array<double, 16>> matrix;  // column-major; instead of the three above

    bool any() const { return translation || rotation || scale || matrix; }
};
template <class Request>
TransformParts partsOf(const Request& r) {
    return {r.translation, r.rotation, r.scale, r.matrix};
}

// Checks that the transform is invertible and of moderate size, and given in one form. `pointer` is
// the JSON Pointer of the object with the parts.
std::vector<FieldError> problems(const TransformParts& parts, const std::string& pointer);

// A mirrored matrix has a negative factor along x, an axis of length 0 the factor 0. Shear is lost.
Transform transformOf(const glm::dmat4& matrix);

// `own` with the parts replaced. Keeps shear where only the translation changes.
glm::dmat4 changed(const glm::dmat4& own, const TransformParts& parts);

}  // namespace clerestory
