#include "scene/import/textures/texture_store.h"

#include "scene/import/textures/image_decoder.h"
#include "scene/normal_maps.h"
#include "scene/texture_images.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <thread>

namespace clerestory {
namespace {

constexpr unsigned kDecodeThreads = 2;

bool sameSampling(const Texture& a, const Texture& b) {
    return a.image == b.image && a.wrapU == b.wrapU && a.wrapV == b.wrapV &&
           a.magnify == b.magnify && a.minify == b.minify && a.useLevels == b.useLevels;
}

// Sets the image's alpha from `coverage`; sizes may differ.
void setCoverage(TextureImage& image, const TextureImage& coverage) {
    for (std::uint32_t y = 0; y < image.height; ++y) {
        for (std::uint32_t x = 0; x < image.width; ++x) {
            const std::size_t row = std::uint64_t{y} * coverage.height / image.height;
            const std::size_t column = std::uint64_t{x} * coverage.width / image.width;
            image.texels[4 * (std::size_t{y} * image.width + x) + 3] =
                coverage.texels[4 * (row * coverage.width + column)];
        }
    }
}

}  // namespace

Index TextureStore::texture(const ImageSource& source, ColorSpace colorSpace,
                            const Texture& sampling) {
    const auto [entry, isNew] =
        requestOf_.try_emplace({source.key, colorSpace}, static_cast<Index>(requests_.size()));
    if (isNew) {
        requests_.push_back({source, colorSpace});
    }
    return textureOf(entry->second, sampling);
}

Index TextureStore::texture(const ConvertedSource& source, const Texture& sampling) {
    const bool isColor = source.result == ConvertedTo::baseColor;
    const auto& first = isColor ? source.diffuse : source.specular;
    const auto& named = first ? first : isColor ? source.specular : source.diffuse;
    requests_.push_back({{.name = named ? named->name : "", .key = {}, .embedded = {}},
                         isColor ? ColorSpace::srgb : ColorSpace::linear,
                         source});
    return textureOf(static_cast<Index>(requests_.size() - 1), sampling);
}

Index TextureStore::textureOf(Index request, const Texture& sampling) {
    Texture texture = sampling;
    texture.image = request;
    const auto known = std::find_if(textures_.begin(), textures_.end(), [&](const Texture& other) {
        return sameSampling(other, texture);
    });
    if (known != textures_.end()) {
        return static_cast<Index>(known - textures_.begin());
    }
    textures_.push_back(texture);
    return static_cast<Index>(textures_.size() - 1);
}

void TextureStore::finish(Scene& scene, const ProgressCallback& progress) {
    struct Outcome {
        std::optional<TextureImage> image;
        std::optional<ImportWarning> warning;
    };
    std::vector<Outcome> outcomes(requests_.size());
    std::atomic<std::size_t> next{0};
    std::atomic<std::uint64_t> pixelsLeft{4 * limits_.maxImagePixels};
    std::atomic<bool> outOfMemory{false};
    std::mutex progressMutex;
    std::size_t done = 0;

    const auto decodedFile = [&](const std::string& name) {
        const std::string file = folder_.read(name);
        return decodedImage({reinterpret_cast<const unsigned char*>(file.data()), file.size()},
                            limits_.maxImagePixels, pixelsLeft);
    };
    const auto decoded = [&](const ImageSource& source) {
        TextureImage image =
            source.embedded.empty()
                ? decodedFile(source.name)
                : decodedImage(source.embedded, limits_.maxImagePixels, pixelsLeft);
        if (!source.coverage.empty()) setCoverage(image, decodedFile(source.coverage));
        return image;
    };
    const auto warningOf = [](const ImageSource& source, const ImportError& error) {
        const bool missing = error.reason() == ImportError::Reason::notFound;
        return ImportWarning{missing ? "missingTexture" : "brokenTexture", source.name,
                             error.what()};
    };
    const auto convertedFrom = [&](const ConvertedSource& source, Outcome& outcome) {
        const auto one =
            [&](const std::optional<ImageSource>& from) -> std::optional<TextureImage> {
            try {
                if (from) return decoded(*from);
            } catch (const ImportError& error) {
                outcome.warning = warningOf(*from, error);
            }
            return std::nullopt;
        };
        const auto diffuse = one(source.diffuse), specular = one(source.specular);
        return converted(diffuse ? &*diffuse : nullptr, specular ? &*specular : nullptr,
                         source.factors, source.result);
    };
    auto work = [&] {
        for (std::size_t i = next++; i < requests_.size(); i = next++) {
            const ImageSource& source = requests_[i].source;
            const auto& conversion = requests_[i].converted;
            try {
                TextureImage image =
                    conversion ? convertedFrom(*conversion, outcomes[i]) : decoded(source);
                image.name = source.name;
                image.colorSpace = requests_[i].colorSpace;
                buildLevels(image);
                outcomes[i].image = std::move(image);
            } catch (const ImportError& error) {
                outcomes[i].warning = warningOf(source, error);
            } catch (const std::bad_alloc&) {
                outOfMemory = true;
            }
            if (progress) {
                const std::lock_guard lock(progressMutex);
                ++done;
                progress({"textures", 0.3 + 0.6 * static_cast<double>(done) /
                                                static_cast<double>(requests_.size())});
            }
        }
    };
    std::vector<std::jthread> threads;
    for (unsigned t = 1; t < std::min<std::size_t>(kDecodeThreads, requests_.size()); ++t) {
        threads.emplace_back(work);
    }
    work();
    threads.clear();
    if (outOfMemory) {
        throw std::bad_alloc();
    }

    std::vector<Index> imageOf(requests_.size(), kNone);
    for (std::size_t i = 0; i < outcomes.size(); ++i) {
        if (outcomes[i].warning) scene.warnings.push_back(*outcomes[i].warning);
        if (!outcomes[i].image) continue;
        imageOf[i] = static_cast<Index>(scene.images.size());
        scene.images.push_back(*std::move(outcomes[i].image));
    }
    std::vector<Index> textureOf(textures_.size(), kNone);
    for (std::size_t i = 0; i < textures_.size(); ++i) {
        if (imageOf[textures_[i].image] != kNone) {
            textureOf[i] = static_cast<Index>(scene.textures.size());
            scene.textures.push_back(textures_[i]);
            scene.textures.back().image = imageOf[textures_[i].image];
        }
    }
    for (Material& material : scene.materials) {
        for (TextureSlot* slot : textureSlots(material)) {
            if (slot->present()) {
                slot->texture = textureOf[slot->texture];
            }
        }
    }
    packNormals(scene);
}

}  // namespace clerestory
