// Hashes of plain values, not cryptographic: collisions can be constructed. Values of different
// types hash differently, and texts and lists include their length.
//
// ContentHash is stable: its result identifies a scene on disk and between processes, so the order
// of the calls must not change. PlanHash is faster for single numbers and used within a process
// only.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace clerestory {

// XXH3.
std::uint64_t hashOfBytes(std::span<const std::byte> bytes, std::uint64_t seed = 0);
struct Hash128 {
    std::uint64_t low = 0, high = 0;
};
Hash128 hash128OfBytes(std::span<const std::byte> bytes);

// Hash of a text, equal in all processes.
std::uint64_t hashOf(std::string_view text);
// Its 128-bit hash as 32 hexadecimal digits.
std::string hashWordOf(std::string_view text);

// add() for composite values, by adding their numbers one after another to Derived::addNumber().
template <class Derived>
class HashInput {
public:
    template <class T>
    requires std::is_arithmetic_v<T> || std::is_enum_v<T>
    void add(T value) { static_cast<Derived*>(this)->addNumber(value); }
    template <int N, class T>
    void add(const glm::vec<N, T>& v) {
        for (int i = 0; i < N; ++i) add(v[i]);
    }
    template <int C, int R, class T>
    void add(const glm::mat<C, R, T>& m) {
        for (int i = 0; i < C; ++i) add(m[i]);
    }
    void add(const glm::dquat& q) {
        for (const double v : {q.x, q.y, q.z, q.w}) add(v);
    }
    void add(std::string_view text) {
        add(text.size());
        for (const char c : text) add(c);
    }
};

class ContentHash : public HashInput<ContentHash> {
public:
    ContentHash();

    using HashInput::add;
    // T must have no padding.
    template <class T>
    requires std::is_trivially_copyable_v<T>
    void add(const std::vector<T>& values) {
        add(values.size());
        addBytes(values.data(), values.size() * sizeof(T));
    }
    void addBytes(const void* bytes, std::size_t count);
    std::uint64_t value() const;

private:
    friend HashInput;
    template <class T>
    void addNumber(T value) {
        addBytes(&value, sizeof value);
    }

    static constexpr std::size_t kStateBytes = 576;  // of XXH3_state_t
    alignas(64) std::byte state_[kStateBytes];
};

class PlanHash : public HashInput<PlanHash> {
public:
    // Never 0.
    std::uint64_t value() const { return value_ == 0 ? 1 : value_; }

private:
    friend HashInput;
    template <class T>
    void addNumber(T value) {
        if constexpr (std::is_floating_point_v<T>)
            mix(std::bit_cast<std::uint64_t>(static_cast<double>(value)));
        else
            mix(static_cast<std::uint64_t>(value));
    }
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
