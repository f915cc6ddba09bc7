// The tone curves of tonemap.glsl for eight pixels at a time.
#include "display/display.h"
#include "image/bands.h"

#include <algorithm>
#include <bit>

// Vectors stay within this file.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace clerestory::display {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
namespace lanes {
namespace {

constexpr std::uint32_t kLanes = 8;
using Values = float __attribute__((vector_size(4 * kLanes)));
using Words = std::uint32_t __attribute__((vector_size(4 * kLanes)));
using Integers = std::int32_t __attribute__((vector_size(4 * kLanes)));
using Pixels = std::uint64_t __attribute__((vector_size(8 * kLanes)));

// GLSL's float and vec3, one of each for every lane.
struct Lanes {
    Values v;
    Lanes() = default;
    Lanes(const Values& values) : v(values) {}
    Lanes(float x) : v(Values{} + x) {}
};
Lanes operator+(const Lanes& a, const Lanes& b) {
    return a.v + b.v;
}
Lanes operator-(const Lanes& a, const Lanes& b) {
    return a.v - b.v;
}
Lanes operator*(const Lanes& a, const Lanes& b) {
    return a.v * b.v;
}
Lanes operator/(const Lanes& a, const Lanes& b) {
    return a.v / b.v;
}
Lanes min(const Lanes& a, const Lanes& b) {
    return b.v < a.v ? b.v : a.v;
}
Lanes max(const Lanes& a, const Lanes& b) {
    return a.v < b.v ? b.v : a.v;
}
struct Colors {
    Lanes x, y, z;
    Colors() = default;
    explicit Colors(const Lanes& grey) : x(grey), y(grey), z(grey) {}
    Colors(const Lanes& r, const Lanes& g, const Lanes& b) : x(r), y(g), z(b) {}
};
Colors operator+(const Colors& a, const Lanes& b) {
    return {a.x + b, a.y + b, a.z + b};
}
Colors operator-(const Colors& a, const Lanes& b) {
    return {a.x - b, a.y - b, a.z - b};
}
Colors operator*(const Colors& a, const Colors& b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
Colors operator*(const Lanes& a, const Colors& b) {
    return {a * b.x, a * b.y, a * b.z};
}
Colors operator*(const Colors& a, const Lanes& b) {
    return b * a;
}
Colors operator/(const Colors& a, const Colors& b) {
    return {a.x / b.x, a.y / b.y, a.z / b.z};
}
Lanes dot(const Colors& a, const Colors& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Colors min(const Colors& a, const Colors& b) {
    return {min(a.x, b.x), min(a.y, b.y), min(a.z, b.z)};
}
Colors clamp(const Colors& c, const Colors& low, const Colors& high) {
    return min(Colors(max(c.x, low.x), max(c.y, low.y), max(c.z, low.z)), high);
}
Colors mix(const Colors& a, const Colors& b, const Lanes& share) {
    const Lanes rest = 1.0f - share;
    return {a.x * rest + b.x * share, a.y * rest + b.y * share, a.z * rest + b.z * share};
}

// As in optics.glsl. Halves hold no value beyond its limits except those that decode() omits.
Colors radianceFinite(const Colors& c) {
    return clamp(c, Colors(0.0f), Colors(65504.0f));
}

#define float Lanes
#define vec3 Colors
#include "shaders/include/tonemap.glsl"
#undef float
#undef vec3

// Halves to floats: the exponent moves by 112. Infinity and NaN become 0.
Lanes decode(const Words& half) {
    const Words magnitude = half & 0x7fffu;
    const Words finite = magnitude < 0x7c00u ? magnitude << 13 : Words{};
    const Values value = std::bit_cast<Values>(finite | ((half & 0x8000u) << 16));
    return value * 0x1p112f;
}

Colors decode(const Pixels& rgba) {
    const Words redGreen = __builtin_convertvector(rgba, Words);
    const Words blue = __builtin_convertvector(rgba >> 32, Words);
    return {decode(redGreen & 0xffffu), decode(redGreen >> 16), decode(blue & 0xffffu)};
}

Values squareRoot(const Values& x) {
    Values result;
    for (std::uint32_t i = 0; i < kLanes; ++i) result[i] = __builtin_sqrtf(x[i]);
    return result;
}

// 0..1 to 0..255, rounded.
Words quantized(const Values& x) {
    return std::bit_cast<Words>(__builtin_convertvector(x * 255.0f + 0.5f, Integers));
}

// Code of 8 bits. IEC 61966-2-1 with its power as a polynomial in the fourth root: at most 2e-6
// off, so that one code in 4,000 is rounded to its neighbour.
Words srgbCode(const Lanes& light) {
    const Lanes root = squareRoot(squareRoot(light.v));
    Lanes power = 0.0700272545f;
    power = power * root - 0.325414032f;
    power = power * root + 0.668039858f;
    power = power * root - 0.8616063f;
    power = power * root + 1.36964238f;
    power = power * root + 0.138787851f;
    power = power * root - 0.0594755374f;
    return quantized(light.v <= 0.0031308f ? light.v * 12.92f : power.v);
}

// kLanes pixels.
template <Colors (*curve)(Colors)>
void convert(const std::uint64_t* radiance, float exposureFactor, std::uint8_t* rgba,
             std::uint8_t* brightness) {
    Pixels pixels;
    __builtin_memcpy(&pixels, radiance, sizeof pixels);
    const Colors display = curve(decode(pixels) * Lanes(exposureFactor));
    const Words codes =
        srgbCode(display.x) | srgbCode(display.y) << 8 | srgbCode(display.z) << 16 | 0xff000000u;
    __builtin_memcpy(rgba, &codes, sizeof codes);
    if (!brightness) return;
    // luminance() of optics.glsl.
    const Lanes luminance = dot(display, Colors(0.2126f, 0.7152f, 0.0722f));
    using Bytes = std::uint8_t __attribute__((vector_size(kLanes)));
    const Bytes code = __builtin_convertvector(quantized(squareRoot(luminance.v)), Bytes);
    __builtin_memcpy(brightness, &code, sizeof code);
}

struct Row {
    const std::uint64_t* radiance;
    std::uint32_t width;
    float exposureFactor;
    std::uint8_t* rgba;
    std::uint8_t* brightness;  // null: not wanted
};

template <Colors (*curve)(Colors)>
[[gnu::always_inline]] inline void convert(const Row& row) {
    std::uint32_t x = 0;
    for (; x + kLanes <= row.width; x += kLanes) {
        convert<curve>(row.radiance + x, row.exposureFactor, row.rgba + 4 * x,
                       row.brightness ? row.brightness + x : nullptr);
    }
    if (x == row.width) return;
    std::uint64_t radiance[kLanes] = {};
    std::uint8_t rgba[4 * kLanes], brightness[kLanes];
    std::copy(row.radiance + x, row.radiance + row.width, radiance);
    convert<curve>(radiance, row.exposureFactor, rgba, brightness);
    std::copy_n(rgba, 4 * (row.width - x), row.rgba + 4 * x);
    if (row.brightness) std::copy_n(brightness, row.width - x, row.brightness + x);
}

// flatten compiles everything that is called for the instructions of the function.
template <Colors (*curve)(Colors)>
[[gnu::flatten]] void convertPortably(const Row& row) {
    convert<curve>(row);
}

#ifdef __x86_64__
template <Colors (*curve)(Colors)>
[[gnu::flatten, gnu::target("avx2")]] void convertWithAvx2(const Row& row) {
    convert<curve>(row);
}
#endif

using ConvertRow = void (*)(const Row&);

template <Colors (*curve)(Colors)>
ConvertRow converterOf() {
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2")) return convertWithAvx2<curve>;
#endif
    return convertPortably<curve>;
}

ConvertRow converterOf(ToneMap curve) {
    switch (curve) {
        case ToneMap::neutral:
            return converterOf<toneMapNeutral>();
        case ToneMap::aces:
            return converterOf<toneMapAces>();
        case ToneMap::linear:
            break;
    }
    return converterOf<toneMapLinear>();
}

}  // namespace
}  // namespace lanes
#pragma GCC diagnostic pop

void toneMap(const Radiance& radiance, ToneMap curve, float exposureFactor, bool brightness,
             Picture& picture) {
    const std::size_t width = radiance.width, height = radiance.height;
    reshape(picture.image, radiance.width, radiance.height, 4, PixelType::srgb8);
    picture.brightness.resize(brightness ? width * height : 0);
    picture.compressed = curve != ToneMap::linear;
    const lanes::ConvertRow convert = lanes::converterOf(curve);
    forEachBand(radiance.height, 16, [&](std::uint32_t first, std::uint32_t end) {
        for (std::size_t y = first; y < end; ++y) {
            convert({.radiance = radiance.pixels.data() + width * (height - 1 - y),
                     .width = radiance.width,
                     .exposureFactor = exposureFactor,
                     .rgba = picture.image.bytes() + 4 * width * y,
                     .brightness = brightness ? picture.brightness.data() + width * y : nullptr});
        }
    });
}

}  // namespace clerestory::display
