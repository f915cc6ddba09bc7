#include "scene/packed_normals.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>

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

// For each image that is used only as a normal map: the metallic-roughness map that accompanies it
// in every material. kNoPartner or kNone for others.
std::vector<Index> partnersOf(const Scene& scene) {
    std::vector<Index> partners(scene.images.size(), kNone);
    const auto imageOf = [&](const TextureSlot& slot) {
        return scene.textures[slot.texture].image;
    };
    for (const Material& m : scene.materials) {
        for (const TextureSlot* slot :
             {&m.baseColorTexture, &m.metallicRoughnessTexture, &m.occlusionTexture,
              &m.emissiveTexture, &m.transmissionTexture, &m.thicknessTexture}) {
            if (slot->present()) partners[imageOf(*slot)] = kNoPartner;
        }
        if (!m.normalTexture.present()) continue;
        Index& partner = partners[imageOf(m.normalTexture)];
        const Index other = readAlike(scene, m.normalTexture, m.metallicRoughnessTexture)
                                ? imageOf(m.metallicRoughnessTexture)
                                : kNoPartner;
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

void packNormals(Scene& scene) {
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
