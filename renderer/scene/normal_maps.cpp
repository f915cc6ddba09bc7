#include "scene/normal_maps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

namespace clerestory {
namespace {

constexpr Index kNoPartner = kNone - 1;

bool readAlike(const Scene& scene, TextureSlot a, const TextureSlot& b) {
    if (!a.present() || !b.present()) return false;
    const Texture &t = scene.textures[a.texture], &u = scene.textures[b.texture];
    a.texture = b.texture;
    return a == b && t.wrapU == u.wrapU && t.wrapV == u.wrapV && t.magnify == u.magnify &&
           t.minify == u.minify && t.useLevels == u.useLevels;
}

// For each material whether a clip moves its normal map or its metallic-roughness map.
std::vector<bool> mapsThatMove(const Scene& scene) {
    std::vector<bool> moves(scene.materials.size());
    for (const Clip& clip : scene.clips) {
        for (const Track& t : clip.tracks) {
            const bool either = t.field.starts_with("normalTexture.") ||
                                t.field.starts_with("metallicRoughnessTexture.");
            if (t.property == AnimatedProperty::material && either) moves[t.target] = true;
        }
    }
    return moves;
}

// For each image that is used only as a normal map: the metallic-roughness map that accompanies it
// in every material. kNoPartner or kNone for others.
std::vector<Index> partnersOf(const Scene& scene) {
    std::vector<Index> partners(scene.images.size(), kNone);
    const auto imageOf = [&](const TextureSlot& slot) {
        return scene.textures[slot.texture].image;
    };
    const std::vector<bool> moves = mapsThatMove(scene);
    for (std::size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& m = scene.materials[i];
        for (const TextureSlot* slot : textureSlots(m)) {
            if (slot->present() && slot != &m.normalTexture) partners[imageOf(*slot)] = kNoPartner;
        }
        if (!m.normalTexture.present()) continue;
        Index& partner = partners[imageOf(m.normalTexture)];
        const bool together =
            !moves[i] && readAlike(scene, m.normalTexture, m.metallicRoughnessTexture);
        const Index other = together ? imageOf(m.metallicRoughnessTexture) : kNoPartner;
        partner = partner == kNone || partner == other ? other : kNoPartner;
    }
    return partners;
}

bool ofOneKind(const TextureImage& a, const TextureImage& b) {
    return a.width == b.width && a.height == b.height && a.texels.size() == b.texels.size() &&
           a.colorSpace == ColorSpace::linear && b.colorSpace == ColorSpace::linear;
}

void join(TextureImage& normals, const TextureImage& numbers) {
    for (std::size_t i = 0; i < normals.texels.size(); i += 4) {
        std::uint8_t* texel = &normals.texels[i];
        const float x = 2.0f * texel[0] - 255.0f, y = 2.0f * texel[1] - 255.0f,
                    z = std::max(2.0f * texel[2] - 255.0f, 0.0f);
        const float perLength = 1.0f / std::sqrt(x * x + y * y + z * z);  // odd numbers: never 0
        texel[0] = static_cast<std::uint8_t>((x * perLength + 1.0f) * 127.5f + 0.5f);
        texel[1] = numbers.texels[i + 1];
        texel[2] = numbers.texels[i + 2];
        texel[3] = static_cast<std::uint8_t>((y * perLength + 1.0f) * 127.5f + 0.5f);
    }
    normals.mean = numbers.mean;
    normals.leastGreen = numbers.leastGreen;
    normals.packedNormal = true;
}

// Removes images that materials no longer use; keeps images that were unused before.
void forget(Scene& scene, const std::vector<bool>& joined) {
    std::vector<bool> removed = joined;
    for (const Material& m : scene.materials) {
        for (const TextureSlot* slot : textureSlots(m)) {
            if (slot->present()) removed[scene.textures[slot->texture].image] = false;
        }
    }
    std::vector<Index> newIndex(scene.images.size());
    std::vector<TextureImage> remaining;
    for (std::size_t i = 0; i < removed.size(); ++i) {
        newIndex[i] = static_cast<Index>(remaining.size());
        if (!removed[i]) remaining.push_back(std::move(scene.images[i]));
    }
    scene.images = std::move(remaining);
    std::vector<Index> textureMoved(scene.textures.size());
    std::vector<Texture> textures;
    for (std::size_t i = 0; i < scene.textures.size(); ++i) {
        textureMoved[i] = static_cast<Index>(textures.size());
        if (removed[scene.textures[i].image]) continue;
        textures.push_back(scene.textures[i]);
        textures.back().image = newIndex[textures.back().image];
    }
    scene.textures = std::move(textures);
    for (Material& m : scene.materials) {
        for (TextureSlot* slot : textureSlots(m)) {
            if (slot->present()) slot->texture = textureMoved[slot->texture];
        }
    }
}

}  // namespace

namespace {

// Squared, less what the rounding of a flat normal gives.
float slopeOf(const TextureImage& image) {
    constexpr double kRounding = 1e-4, kLeastZ = 0.1;
    const std::size_t texels = std::size_t{image.width} * image.height;
    double sum = 0.0;
    for (std::size_t i = 0; i < 4 * texels; i += 4) {
        const auto along = [&](std::size_t k) { return image.texels[i + k] / 127.5 - 1.0; };
        const double x = along(0), y = along(1), z = std::max(along(2), kLeastZ);
        sum += (x * x + y * y) / (z * z);
    }
    const double mean = texels > 0 ? sum / static_cast<double>(texels) : 0.0;
    return static_cast<float>(std::sqrt(std::max(mean - kRounding, 0.0)));
}

void measureSlopes(Scene& scene) {
    std::vector<bool> measured(scene.images.size());
    for (const Material& m : scene.materials) {
        for (const TextureSlot* slot : {&m.normalTexture, &m.clearcoatNormalTexture}) {
            if (!slot->present()) continue;
            const Index image = scene.textures[slot->texture].image;
            if (!measured[image]) scene.images[image].slope = slopeOf(scene.images[image]);
            measured[image] = true;
        }
    }
}

}  // namespace

void packNormals(Scene& scene) {
    measureSlopes(scene);
    const std::vector<Index> partners = partnersOf(scene);
    std::vector<Index> pairs;  // the normal maps
    for (Index i = 0; i < partners.size(); ++i) {
        if (partners[i] < kNoPartner && ofOneKind(scene.images[i], scene.images[partners[i]])) {
            pairs.push_back(i);
        }
    }
    if (pairs.empty()) return;
    std::atomic<std::size_t> next = 0;
    const auto work = [&] {
        for (std::size_t i = next++; i < pairs.size(); i = next++) {
            join(scene.images[pairs[i]], scene.images[partners[pairs[i]]]);
        }
    };
    {
        const std::jthread another(work);
        work();
    }
    std::vector<bool> joined(scene.images.size());
    for (const Index pair : pairs) joined[partners[pair]] = true;
    for (Material& m : scene.materials) {
        if (m.normalTexture.present() &&
            scene.images[scene.textures[m.normalTexture.texture].image].packedNormal) {
            m.metallicRoughnessTexture = m.normalTexture;
        }
    }
    forget(scene, joined);
}

}  // namespace clerestory
