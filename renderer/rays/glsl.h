// GLSL's vectors and functions in C++, so that the shaders' formulae can be compiled for the
// processor.
//
//     namespace { using namespace clerestory::rays::glsl;
//     #include "rays/swizzles.inc"  ... #include "include/optics.glsl" ... }
//
// Plain structs of floats: GLM's types with swizzles do not convert in calls of functions.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace clerestory::rays::glsl {

using uint = std::uint32_t;

struct vec2 {
    float x, y;
    vec2() = default;
    explicit constexpr vec2(float s) : x(s), y(s) {}
    constexpr vec2(float x, float y) : x(x), y(y) {}
    vec2 asXy() const { return *this; }
};

struct vec3 {
    union {
        float x, r;
    };
    union {
        float y, g;
    };
    union {
        float z, b;
    };
    vec3() = default;
    explicit constexpr vec3(float s) : x(s), y(s), z(s) {}
    constexpr vec3(float x, float y, float z) : x(x), y(y), z(z) {}
    constexpr vec3(vec2 v, float z) : x(v.x), y(v.y), z(z) {}
    constexpr vec3(float x, vec2 v) : x(x), y(v.x), z(v.y) {}
    vec2 asXy() const { return {x, y}; }
    vec2 asYz() const { return {y, z}; }
    vec3 asXyz() const { return *this; }
};

struct vec4 {
    union {
        float x, r;
    };
    union {
        float y, g;
    };
    union {
        float z, b;
    };
    union {
        float w, a;
    };
    vec4() = default;
    explicit constexpr vec4(float s) : x(s), y(s), z(s), w(s) {}
    constexpr vec4(float x, float y, float z, float w) : x(x), y(y), z(z), w(w) {}
    constexpr vec4(vec2 v, vec2 u) : x(v.x), y(v.y), z(u.x), w(u.y) {}
    constexpr vec4(vec3 v, float w) : x(v.x), y(v.y), z(v.z), w(w) {}
    vec2 asXy() const { return {x, y}; }
    vec2 asYz() const { return {y, z}; }
    vec2 asZw() const { return {z, w}; }
    vec2 asBg() const { return {z, y}; }
    vec2 asRa() const { return {x, w}; }
    vec3 asXyz() const { return {x, y, z}; }
    vec3 asYzw() const { return {y, z, w}; }
};

struct bvec2 {
    bool x, y;
};

// ---- operators ---------------------------------------------------------------------------------

#define CLERESTORY_OPERATORS(op)                                 \
    constexpr vec2 operator op(vec2 a, vec2 b) {                 \
        return {a.x op b.x, a.y op b.y};                         \
    }                                                            \
    constexpr vec2 operator op(vec2 a, float b) {                \
        return {a.x op b, a.y op b};                             \
    }                                                            \
    constexpr vec2 operator op(float a, vec2 b) {                \
        return {a op b.x, a op b.y};                             \
    }                                                            \
    constexpr vec3 operator op(vec3 a, vec3 b) {                 \
        return {a.x op b.x, a.y op b.y, a.z op b.z};             \
    }                                                            \
    constexpr vec3 operator op(vec3 a, float b) {                \
        return {a.x op b, a.y op b, a.z op b};                   \
    }                                                            \
    constexpr vec3 operator op(float a, vec3 b) {                \
        return {a op b.x, a op b.y, a op b.z};                   \
    }                                                            \
    constexpr vec4 operator op(vec4 a, vec4 b) {                 \
        return {a.x op b.x, a.y op b.y, a.z op b.z, a.w op b.w}; \
    }                                                            \
    constexpr vec4 operator op(vec4 a, float b) {                \
        return {a.x op b, a.y op b, a.z op b, a.w op b};         \
    }                                                            \
    constexpr vec4 operator op(float a, vec4 b) {                \
        return {a op b.x, a op b.y, a op b.z, a op b.w};         \
    }                                                            \
    template <class V, class S>                                  \
    constexpr V& operator op##=(V& a, S b) {                     \
        return a = a op b;                                       \
    }
CLERESTORY_OPERATORS(+)
CLERESTORY_OPERATORS(-)
CLERESTORY_OPERATORS(*)
CLERESTORY_OPERATORS(/)
#undef CLERESTORY_OPERATORS
constexpr vec2 operator-(vec2 a) {
    return {-a.x, -a.y};
}
constexpr vec3 operator-(vec3 a) {
    return {-a.x, -a.y, -a.z};
}

// ---- functions ---------------------------------------------------------------------------------

inline float abs(float x) {
    return std::fabs(x);
}
inline float floor(float x) {
    return std::floor(x);
}
inline float sqrt(float x) {
    return std::sqrt(x);
}
inline float inversesqrt(float x) {
    return 1.0f / std::sqrt(x);
}
inline float exp2(float x) {
    return std::exp2(x);
}
inline float log2(float x) {
    return std::log2(x);
}
inline float sin(float x) {
    return std::sin(x);
}
inline float cos(float x) {
    return std::cos(x);
}
inline float mod(float x, float y) {
    return x - y * std::floor(x / y);
}
inline constexpr float min(float a, float b) {
    return b < a ? b : a;
}
inline constexpr float max(float a, float b) {
    return a < b ? b : a;
}
inline constexpr int min(int a, int b) {
    return b < a ? b : a;
}
inline constexpr int max(int a, int b) {
    return a < b ? b : a;
}
inline constexpr uint max(uint a, uint b) {
    return a < b ? b : a;
}
inline constexpr float clamp(float x, float low, float high) {
    return min(max(x, low), high);
}
inline constexpr float mix(float a, float b, float t) {
    return a * (1.0f - t) + b * t;
}
inline float smoothstep(float low, float high, float x) {
    const float t = clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3.0f - 2.0f * t);
}

// Component by component.
#define CLERESTORY_ONE(f)                        \
    inline vec2 f(vec2 v) {                      \
        return {f(v.x), f(v.y)};                 \
    }                                            \
    inline vec3 f(vec3 v) {                      \
        return {f(v.x), f(v.y), f(v.z)};         \
    }                                            \
    inline vec4 f(vec4 v) {                      \
        return {f(v.x), f(v.y), f(v.z), f(v.w)}; \
    }
CLERESTORY_ONE(abs)
CLERESTORY_ONE(floor)
CLERESTORY_ONE(sqrt)
#undef CLERESTORY_ONE
#define CLERESTORY_TWO(f)                               \
    inline vec2 f(vec2 a, vec2 b) {                     \
        return {f(a.x, b.x), f(a.y, b.y)};              \
    }                                                   \
    inline vec2 f(vec2 a, float b) {                    \
        return {f(a.x, b), f(a.y, b)};                  \
    }                                                   \
    inline vec3 f(vec3 a, vec3 b) {                     \
        return {f(a.x, b.x), f(a.y, b.y), f(a.z, b.z)}; \
    }                                                   \
    inline vec3 f(vec3 a, float b) {                    \
        return {f(a.x, b), f(a.y, b), f(a.z, b)};       \
    }
CLERESTORY_TWO(min)
CLERESTORY_TWO(max)
#undef CLERESTORY_TWO
inline vec2 clamp(vec2 v, vec2 low, vec2 high) {
    return min(max(v, low), high);
}
inline vec3 clamp(vec3 v, float low, float high) {
    return min(max(v, low), high);
}
inline vec2 mix(vec2 a, vec2 b, float t) {
    return a * (1.0f - t) + b * t;
}
inline vec3 mix(vec3 a, vec3 b, float t) {
    return a * (1.0f - t) + b * t;
}
inline vec4 mix(vec4 a, vec4 b, float t) {
    return a * (1.0f - t) + b * t;
}
inline vec2 mix(vec2 a, vec2 b, bvec2 t) {
    return {t.x ? b.x : a.x, t.y ? b.y : a.y};
}
inline bvec2 greaterThan(vec2 a, vec2 b) {
    return {a.x > b.x, a.y > b.y};
}

inline float dot(vec2 a, vec2 b) {
    return a.x * b.x + a.y * b.y;
}
inline float dot(vec3 a, vec3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline float dot(vec4 a, vec4 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z + a.w * b.w;
}
inline vec3 cross(vec3 a, vec3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class V>
float length(V v) {
    return sqrt(dot(v, v));
}
template <class V>
float distance(V a, V b) {
    return length(a - b);
}
template <class V>
V normalize(V v) {
    return v * inversesqrt(dot(v, v));
}
inline vec3 reflect(vec3 along, vec3 normal) {
    return along - normal * (2.0f * dot(normal, along));
}

struct uvec4 {
    uint x, y, z, w;
};

// A half float of 16 bits: exact, subnormal numbers included.
inline float floatOfHalf(uint half) {
    const uint magnitude = half & 0x7fffu;
    const float scaled = std::bit_cast<float>(magnitude << 13u) * 0x1p112f;
    const float value =
        magnitude >= 0x7c00u ? std::bit_cast<float>((magnitude << 13u) | 0x7f800000u) : scaled;
    return (half & 0x8000u) != 0u ? -value : value;
}
inline vec2 unpackHalf2x16(uint packed) {
    return {floatOfHalf(packed & 0xffffu), floatOfHalf(packed >> 16u)};
}

inline uint bitfieldReverse(uint i) {
    uint reversed = 0;
    for (int bit = 0; bit < 32; ++bit) reversed |= (i >> bit & 1u) << (31 - bit);
    return reversed;
}

struct mat3 {
    vec3 columns[3];
    mat3(vec3 a, vec3 b, vec3 c) : columns{a, b, c} {}
    const vec3& operator[](int i) const { return columns[i]; }
};
inline vec3 operator*(const mat3& m, vec3 v) {
    return m[0] * v.x + m[1] * v.y + m[2] * v.z;
}

}  // namespace clerestory::rays::glsl
