// Levels are computed on the processor: the first glGenerateMipmap of a driver takes 50 to 145 ms.
#include "passes/gpu_environment.h"

#include <algorithm>
#include <bit>

namespace clerestory {
namespace {

gl::Texture uploaded(const EnvironmentMap& map) {
    const auto levels = static_cast<std::uint32_t>(std::bit_width(map.faceSize));
    gl::Texture texture({.kind = gl::TextureKind::cube,
                         .format = gl::TextureFormat::rgba16f,
                         .width = map.faceSize,
                         .height = map.faceSize,
                         .levels = levels});
    const std::size_t faceTexels = std::size_t{map.faceSize} * map.faceSize;
    std::vector<glm::vec4> rgba;
    for (std::uint32_t face = 0; face < 6; ++face) {
        const auto begin = map.texels.begin() + static_cast<std::ptrdiff_t>(face * faceTexels);
        std::vector<glm::vec3> texels(begin, begin + static_cast<std::ptrdiff_t>(faceTexels));
        for (std::uint32_t level = 0; level < levels; ++level) {
            if (level > 0) texels = halvedFace(texels, std::max(1u, map.faceSize >> (level - 1)));
            rgba.clear();
            for (const glm::vec3& texel : texels) rgba.emplace_back(texel, 1.0f);
            texture.upload(level, face, std::as_bytes(std::span(rgba)));
        }
    }
    return texture;
}

}  // namespace

std::vector<glm::vec3> halvedFace(const std::vector<glm::vec3>& face, std::uint32_t size) {
    const std::uint32_t half = std::max(1u, size / 2);
    std::vector<glm::vec3> result;
    result.reserve(std::size_t{half} * half);
    for (std::uint32_t y = 0; y < half; ++y) {
        for (std::uint32_t x = 0; x < half; ++x) {
            const auto at = [&](std::uint32_t dx, std::uint32_t dy) {
                return face[std::size_t{2 * y + dy} * size + 2 * x + dx];
            };
            result.push_back(0.25f * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1)));
        }
    }
    return result;
}

GpuEnvironment::GpuEnvironment(const EnvironmentMap& map)
    : source(uploaded(map)), harmonics(map.harmonics) {}

}  // namespace clerestory
