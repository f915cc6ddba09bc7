// Numbers of materials, lights and cameras by the name of their field, as tracks of clips set them
// (KHR_animation_pointer). A field of a texture slot is named "baseColorTexture.offset". Only
// factors can be set: a texture, a mode or a switch has no name here.
//
//     Material red;
//     setNumbers(red, "baseColor", std::array{1.0, 0.0, 0.0, 1.0});
#pragma once

#include "scene/material.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <type_traits>

namespace clerestory {

// Calls use(member, range) for the factor of that name, if there is one.
template <class S, class Use>
void withFactor(S& s, std::string_view name, const Use& use) {
    const std::size_t dot = name.find('.');
    const std::string_view first = name.substr(0, dot);
    fields(s, [&](std::string_view field, auto& member, const auto& kind, const auto&...) {
        if (field != first) return;
        using Kind = std::decay_t<decltype(kind)>;
        if constexpr (std::is_same_v<Kind, FactorRange>) {
            if (dot == std::string_view::npos) use(member, kind);
        } else if constexpr (std::is_same_v<Kind, SlotRange>) {
            if (dot != std::string_view::npos) withFactor(member, name.substr(dot + 1), use);
        }
    });
}

// How many numbers the factor of that name has; 0 if there is none.
template <class S>
std::size_t componentsOf(const S& s, std::string_view name) {
    std::size_t count = 0;
    withFactor(s, name, [&](const auto& member, const FactorRange&) {
        if constexpr (std::is_arithmetic_v<std::decay_t<decltype(member)>>)
            count = 1;
        else
            count = static_cast<std::size_t>(std::decay_t<decltype(member)>::length());
    });
    return count;
}

// Sets the factor of that name, clamped to its range. The numbers must be finite and as many as its
// components.
template <class S>
void setNumbers(S& s, std::string_view name, std::span<const double> numbers) {
    withFactor(s, name, [&](auto& member, const FactorRange& range) {
        const auto inside = [&](std::size_t i) {
            return std::clamp(static_cast<float>(numbers[i]), range.min,
                              i < 3 ? range.max : range.maxCoverage);
        };
        using Member = std::decay_t<decltype(member)>;
        if constexpr (std::is_arithmetic_v<Member>) {
            member = inside(0);
        } else {
            for (int i = 0; i < Member::length(); ++i) {
                member[i] = inside(static_cast<std::size_t>(i));
            }
        }
    });
}

}  // namespace clerestory
