// Rotations in the forms that clients and files may use, converted to a unit quaternion.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

namespace clerestory {

using Quaternion = std::array<double, 4>;  // x y z w

inline constexpr const char* kRotationForms =
    "4 numbers: unit quaternion x y z w; 9: rotation matrix, column-major; 3: radians about X, "
    "then "
    "Y, then Z";

// Four numbers are a quaternion, nine a matrix, three angles about fixed axes. Nothing for any
// other count, or if they are not a rotation within 1e-3, which allows for rounding to float.
std::optional<Quaternion> rotationFrom(std::span<const double> numbers);

bool isUnit(const Quaternion& q);

}  // namespace clerestory
