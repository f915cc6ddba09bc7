// Hashes what a plan will draw: the content of a map is known by the passes that make it.
#pragma once

#include "plan/draws.h"

#include <bit>
#include <cstdint>
#include <span>
#include <type_traits>

namespace clerestory {

class PlanHash {
public:
    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void add(T value) {
        if constexpr (std::is_enum_v<T>)
            mix(static_cast<std::uint64_t>(value));
        else if constexpr (std::is_floating_point_v<T>)
            mix(std::bit_cast<std::uint64_t>(static_cast<double>(value)));
        else
            mix(static_cast<std::uint64_t>(value));
    }
    template <int N, class T>
    void add(const glm::vec<N, T>& v) {
        for (int i = 0; i < N; ++i) add(v[i]);
    }
    template <int C, int R, class T>
    void add(const glm::mat<C, R, T>& m) {
        for (int i = 0; i < C; ++i) add(m[i]);
    }
    // Never 0.
    std::uint64_t value() const { return value_ == 0 ? 1 : value_; }

private:
    // The finaliser of splitmix64.
    void mix(std::uint64_t more) {
        std::uint64_t key = value_ ^ (more + 0x9e3779b97f4a7c15ull + (value_ << 6) + (value_ >> 2));
        key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9ull;
        key = (key ^ (key >> 27)) * 0x94d049bb133111ebull;
        value_ = key ^ (key >> 31);
    }
    std::uint64_t value_ = 0;
};

// 0 for a scene that wears its own.
std::uint64_t hashOf(const Dressing& dressing);

// Of everything that decides the pixels of those of plan.passes: what is drawn, where it stands, of
// what it is made, in which light, into how many texels. Equal hashes, equal pictures.
std::uint64_t hashOfPasses(const FramePlan& plan, std::span<const std::size_t> passes,
                           const Stage& stage, const EnvironmentMap& environment);

}  // namespace clerestory
