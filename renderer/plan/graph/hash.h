// A 64-bit hash of plain values: equal hashes stand for equal pictures.
#pragma once

#include <glm/glm.hpp>

#include <bit>
#include <cstdint>
#include <string_view>
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
    void add(std::string_view text) {
        add(text.size());
        for (const char c : text) add(c);
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

}  // namespace clerestory
