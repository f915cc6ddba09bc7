// Materials of the chapel. Without indoor shadows, a constant occlusion map reduces the light of
// the sky; vertex colours darken the corners.
#include "scene/builtin/chapel_parts.h"
#include "scene/builtin/modelling.h"

#include <glm/gtc/constants.hpp>

#include <cmath>

namespace clerestory::chapel_parts {
namespace {

using textures::hash;
using textures::noise;

const glm::vec3 kLead(0.03f);

// Ashlar: 4 x 8 blocks, every second course shifted by half a block.
glm::vec4 ashlar(float u, float v) {
    const float row = std::floor(v * 8.0f), shift = std::fmod(row, 2.0f) * 0.5f;
    const float column = std::floor(u * 4.0f + shift);
    const float fx = u * 4.0f + shift - column, fy = v * 8.0f - row;
    const float edge = std::min(std::min(fx, 1.0f - fx) * 2.0f, std::min(fy, 1.0f - fy));
    const float tone =
        0.10f * (hash(static_cast<std::uint32_t>(column) % 4u, static_cast<std::uint32_t>(row), 3) -
                 0.5f) +
        0.16f * (noise(u, v, 8, 5, 4) - 0.5f);
    const glm::vec3 stone = glm::vec3(0.76f, 0.70f, 0.61f) + tone * glm::vec3(1.0f, 0.97f, 0.9f);
    return glm::vec4(stone * (edge < 0.03f ? 0.80f : 1.0f), 1.0f);
}

// Two by two marble tiles with veins, and a thin dark joint.
glm::vec4 marble(float u, float v) {
    const int x = static_cast<int>(u * 2.0f), y = static_cast<int>(v * 2.0f);
    const float fx = u * 2.0f - static_cast<float>(x), fy = v * 2.0f - static_cast<float>(y);
    const auto seed = static_cast<std::uint32_t>(40 + x * 2 + y);
    const float bend = noise(fx, fy, 4, 5, seed);
    const float vein = std::pow(
        1.0f - std::abs(std::fmod(3.0f * (0.5f * fx + fy) + 2.6f * bend, 1.0f) - 0.5f) * 2.0f,
        8.0f);
    const float cloud = noise(fx, fy, 3, 4, seed + 9);
    const glm::vec3 pale = glm::mix(glm::vec3(0.86f, 0.83f, 0.78f), glm::vec3(0.70f, 0.66f, 0.61f),
                                    0.6f * cloud + 0.3f * vein);
    const glm::vec3 dark =
        glm::mix(glm::vec3(0.22f, 0.15f, 0.13f), glm::vec3(0.36f, 0.25f, 0.21f), cloud) +
        0.22f * vein;
    const float joint = std::min(std::min(fx, 1.0f - fx), std::min(fy, 1.0f - fy));
    return glm::vec4(((x + y) % 2 ? dark : pale) * (joint < 0.012f ? 0.5f : 1.0f), 1.0f);
}

glm::vec4 oak(float u, float v) {
    const float bend = noise(u, v, 2, 3, 60);
    const float band = std::abs(std::fmod(10.0f * (u + 0.12f * bend), 1.0f) - 0.5f) * 2.0f;
    return glm::vec4(glm::mix(glm::vec3(0.25f, 0.14f, 0.08f), glm::vec3(0.40f, 0.25f, 0.15f),
                              0.7f * band + 0.3f * noise(u * 4.0f, v, 16, 3, 61)),
                     1.0f);
}

// Cracks of heat in a dark crust.
glm::vec4 glowingCoal(float u, float v) {
    const float heat = std::pow(noise(u, v, 6, 4, 81), 1.8f);
    return glm::vec4(glm::min(glm::vec3(1.0f), heat * glm::vec3(1.25f, 0.56f, 0.08f)), 1.0f);
}

struct Palette {
    glm::vec3 ground, ground2, accent, accent2;
};
const Palette kPalettes[3] = {
    {{0.10f, 0.22f, 0.86f}, {0.07f, 0.42f, 0.92f}, {0.90f, 0.08f, 0.10f}, {0.98f, 0.78f, 0.22f}},
    {{0.72f, 0.05f, 0.10f}, {0.88f, 0.16f, 0.08f}, {0.12f, 0.30f, 0.88f}, {0.98f, 0.80f, 0.30f}},
    {{0.06f, 0.48f, 0.30f}, {0.10f, 0.62f, 0.52f}, {0.95f, 0.62f, 0.14f}, {0.86f, 0.10f, 0.16f}},
};
const glm::vec3 kPearl(0.96f, 0.93f, 0.82f);

// Hand-blown glass varies in tone.
glm::vec3 blown(const glm::vec3& color, float u, float v, std::uint32_t cell) {
    return color * (0.72f + 0.36f * hash(cell, 17u, 5u) + 0.22f * (noise(u, v, 32, 2, 70) - 0.5f));
}

// A lancet window four times as high as wide: a border, a lattice and five medallions in a column.
glm::vec3 lancet(const Palette& p, float u, float v) {
    const float x = u - 0.5f, y = 4.0f * v;
    const float side = 0.5f - std::abs(x);
    if (side < 0.02f) return kLead;
    if (side < 0.11f) {
        const float row = std::floor(y * 8.0f), f = y * 8.0f - row;
        if (f < 0.10f || side > 0.10f) return kLead;
        const auto cell = static_cast<std::uint32_t>(row) * 2u + (x > 0.0f ? 1u : 0u);
        return blown(cell % 4u < 2u ? p.accent : p.accent2, u, v, cell);
    }
    if (side < 0.135f) return kPearl * 0.9f;
    if (side < 0.145f) return kLead;
    const float k = std::floor(y / 0.8f), cy = y - (k + 0.5f) * 0.8f;
    const float r = std::sqrt(x * x + cy * cy),
                turn = std::atan2(cy, x) / glm::two_pi<float>() + 0.5f;
    const auto medallion = static_cast<std::uint32_t>(k);
    const float ring = 0.30f;
    if (r < ring) {
        if (r > ring - 0.012f || std::abs(r - 0.25f) < 0.008f || std::abs(r - 0.10f) < 0.008f)
            return kLead;
        if (r > 0.25f) return blown(kPearl, u, v, medallion);
        if (r < 0.10f) return blown(p.accent2, u, v, medallion + 50u);
        const float petal = turn * 8.0f, f = petal - std::floor(petal);
        if (f < 0.05f || f > 0.95f) return kLead;
        const auto cell = medallion * 8u + static_cast<std::uint32_t>(petal);
        return blown(cell % 2u ? p.accent : p.ground2, u, v, cell + 100u);
    }
    const float a = (x + y) * 9.0f, b = (x - y) * 9.0f;
    const float fa = a - std::floor(a), fb = b - std::floor(b);
    if (fa < 0.09f || fb < 0.09f) return kLead;
    const auto cell = static_cast<std::uint32_t>(static_cast<int>(std::floor(a)) * 37 +
                                                 static_cast<int>(std::floor(b)) + 4096);
    return blown(hash(cell, 2u, 8u) < 0.12f  ? p.accent2
                 : hash(cell, 3u, 8u) < 0.5f ? p.ground
                                             : p.ground2,
                 u, v, cell + 200u);
}

// Rings of petals around a centre.
glm::vec3 roseWindow(float u, float v) {
    const float x = 2.0f * u - 1.0f, y = 2.0f * v - 1.0f, r = std::sqrt(x * x + y * y);
    const float turn = std::atan2(y, x) / glm::two_pi<float>() + 0.5f;
    struct Ring {
        float outer;
        int petals;
        int palette;
    };
    const Ring rings[] = {{0.20f, 6, 0}, {0.52f, 12, 1}, {0.78f, 24, 0}, {1.01f, 24, 2}};
    float inner = 0.0f;
    for (const Ring& ring : rings) {
        if (r <= ring.outer) {
            const float petal = turn * static_cast<float>(ring.petals),
                        f = petal - std::floor(petal);
            const float across =
                std::min(f, 1.0f - f) * glm::two_pi<float>() * r / static_cast<float>(ring.petals);
            const float along = std::min(r - inner, ring.outer - r);
            if (across < 0.008f || along < 0.010f) return kLead;
            const auto cell =
                static_cast<std::uint32_t>(ring.petals * 100) + static_cast<std::uint32_t>(petal);
            const Palette& p = kPalettes[ring.palette];
            // A round light within each petal.
            const float middle = 0.5f * (inner + ring.outer), width = 0.30f * (ring.outer - inner);
            const float d = std::hypot(r - middle, (f - 0.5f) * glm::two_pi<float>() * r /
                                                       static_cast<float>(ring.petals));
            if (std::abs(d - width) < 0.008f) return kLead;
            if (d < width) return blown(cell % 2u ? p.accent2 : kPearl, u, v, cell + 7u);
            return blown(cell % 2u ? p.ground : p.accent, u, v, cell);
        }
        inner = ring.outer;
    }
    return kLead;
}

Index addMaterial(Scene& scene, Material material) {
    scene.materials.push_back(std::move(material));
    return static_cast<Index>(scene.materials.size() - 1);
}

TextureSlot slot(Index texture, float metresPerRepeat = 1.0f) {
    return {.texture = texture, .scale = glm::vec2(1.0f / metresPerRepeat)};
}

}  // namespace

Materials addMaterials(Scene& scene) {
    Materials m{};
    const Index indoors = textures::addConstant(scene, "indoors", 0.75f);
    const auto addIndoors = [&](Material material) {
        material.occlusionTexture.texture = indoors;
        return addMaterial(scene, std::move(material));
    };
    const auto textured = [&](const char* name, std::uint32_t size, float metres, float roughness,
                              glm::vec4 (*color)(float, float)) {
        const Index picture = textures::add(scene, name, size, size, ColorSpace::srgb, color);
        return addIndoors({.name = name,
                           .baseColorTexture = slot(picture, metres),
                           .metallic = 0.0f,
                           .roughness = roughness});
    };
    const auto plain = [&](const char* name, const glm::vec3& color, float metallic,
                           float roughness) {
        return addIndoors({.name = name,
                           .baseColor = glm::vec4(color, 1.0f),
                           .metallic = metallic,
                           .roughness = roughness});
    };
    const auto glowing = [&](const char* name, const glm::vec3& color, const glm::vec3& emissive,
                             float strength) {
        return addIndoors({.name = name,
                           .baseColor = glm::vec4(color, 1.0f),
                           .metallic = 0.0f,
                           .roughness = 0.9f,
                           .emissive = emissive,
                           .emissiveStrength = strength});
    };
    m.stone = textured("stone", 256, 3.2f, 0.85f, ashlar);
    m.dressedStone = plain("dressedStone", {0.58f, 0.50f, 0.40f}, 0.0f, 0.75f);
    m.floor = textured("floor", 512, 1.6f, 0.10f, marble);
    m.wood = textured("wood", 128, 1.2f, 0.45f, oak);
    m.brass = plain("brass", {0.94f, 0.62f, 0.26f}, 1.0f, 0.16f);
    m.iron = plain("iron", {0.16f, 0.15f, 0.14f}, 1.0f, 0.45f);
    m.gold = plain("gold", {1.0f, 0.72f, 0.29f}, 1.0f, 0.25f);
    // Nearly black and without reflection: the point light for their light is close.
    m.ember = glowing("ember", {0.004f, 0.003f, 0.003f}, glm::vec3(1.0f), 8.0f);
    scene.materials[m.ember].specular = 0.0f;
    scene.materials[m.ember].emissiveTexture =
        slot(textures::add(scene, "ember", 64, 64, ColorSpace::srgb, glowingCoal), 0.25f);
    m.flame = glowing("flame", {0.2f, 0.2f, 0.2f}, {1.0f, 0.58f, 0.18f}, 6.0f);
    m.wax = plain("wax", {0.86f, 0.80f, 0.66f}, 0.0f, 0.5f);
    m.cloth = plain("altarCloth", {0.80f, 0.78f, 0.74f}, 0.0f, 0.95f);
    // Outdoors: no occlusion map.
    m.paving = addMaterial(scene, {.name = "paving",
                                   .baseColor = {0.52f, 0.48f, 0.42f, 1.0f},
                                   .metallic = 0.0f,
                                   .roughness = 0.9f});
    m.leaves = addMaterial(scene, {.name = "leaves",
                                   .baseColor = {0.035f, 0.055f, 0.03f, 1.0f},
                                   .metallic = 0.0f,
                                   .roughness = 0.8f});
    m.glassBall = addIndoors({.name = "glassBall",
                              .baseColor = {0.75f, 0.92f, 0.95f, 1.0f},
                              .metallic = 0.0f,
                              .roughness = 0.0f,
                              .ior = 1.5f,
                              .transmission = 1.0f,
                              .thickness = 0.9f});

    // Stained glass scatters the daylight behind it; its emission represents this light.
    const auto glass = [&](const char* name, std::uint32_t width, std::uint32_t height,
                           float strength, const auto& color) {
        const Index picture =
            textures::add(scene, name, width, height, ColorSpace::srgb,
                          [&](float u, float v) { return glm::vec4(color(u, v), 1.0f); });
        return addIndoors({.name = name,
                           .baseColor = glm::vec4(glm::vec3(0.25f), 1.0f),
                           .baseColorTexture = slot(picture),
                           .metallic = 0.0f,
                           .roughness = 0.2f,
                           .emissive = glm::vec3(1.0f),
                           .emissiveStrength = strength,
                           .emissiveTexture = slot(picture),
                           .ior = 1.5f,
                           .transmission = 0.8f,
                           .thickness = 0.004f});
    };
    const char* names[] = {"glassBlue", "glassRuby", "glassGreen"};
    for (int i = 0; i < 3; ++i) {
        m.lancets[i] = glass(names[i], 128, 512, 1.5f,
                             [&](float u, float v) { return lancet(kPalettes[i], u, v); });
    }
    m.rose = glass("glassRose", 512, 512, 1.8f, roseWindow);
    return m;
}

}  // namespace clerestory::chapel_parts
