#include "measures/measured_pixels.h"

#include "scene/classification.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

namespace clerestory {
namespace {

// The channel's values are integers; adding one half rounds.
Mask maskWhere(const Image& values, const std::function<bool(std::uint32_t)>& included) {
    if (values.channels != 1 || values.type != PixelType::float32) {
        throw std::runtime_error("a mask requires an image with one float channel");
    }
    Mask mask{.width = values.width, .height = values.height};
    mask.inside.resize(std::size_t(values.width) * values.height);
    for (std::size_t i = 0; i < mask.inside.size(); ++i) {
        const float value = values.floats()[i];
        const bool valid =
            value >= 0.0f && value < 16777216.0f;  // 2^24: greatest range of exact integers
        mask.inside[i] = valid && included(static_cast<std::uint32_t>(value + 0.5f));
    }
    return mask;
}

void requireComparable(const Image& actual, const Image& reference, const Mask* mask) {
    if (actual.width != reference.width || actual.height != reference.height) {
        throw std::runtime_error(
            "images of different sizes cannot be compared: " + std::to_string(actual.width) +
            " x " + std::to_string(actual.height) + " and " + std::to_string(reference.width) +
            " x " + std::to_string(reference.height));
    }
    if (actual.channels < 3 || reference.channels < 3) {
        throw std::runtime_error("comparison requires 3 or 4 channels");
    }
    if (mask && (mask->width != actual.width || mask->height != actual.height)) {
        throw std::runtime_error("the mask differs in size from the images");
    }
}

double sampleOf(const Image& image, std::size_t pixel, std::size_t channel) {
    const std::size_t i = pixel * image.channels + channel;
    return image.type == PixelType::float32 ? double(image.floats()[i]) : image.bytes()[i] / 255.0;
}

}  // namespace

std::uint64_t Mask::pixels() const {
    return static_cast<std::uint64_t>(
        std::count_if(inside.begin(), inside.end(), [](std::uint8_t in) { return in != 0; }));
}

FrameRequest maskRequest(FrameRequest request) {
    request.effects = {};
    request.accuracy.planar = PlanarMethod::mirror;
    request.accuracy.curved = CurvedMethod::probe;
    request.accuracy.glass = GlassMethod::backdrop;
    request.output.channel = Channel::through;
    request.output.format = OutputFormat::npy;
    return request;
}

Mask maskOf(const Image& through, Effect effect) {
    return maskWhere(through, [effect](std::uint32_t value) {
        switch (effect) {
            case Effect::base:
            case Effect::shadows:
            case Effect::indirectLight:
                return value == throughDirect;
            case Effect::refraction:
                return value == throughGlass;
            case Effect::planarReflection:
                return value >= throughFirstMirror;
            case Effect::environmentReflection:
                return value == throughCubeOrRays || value == throughEnvironment;
            case Effect::emission:
            case Effect::materialLayers:
            case Effect::filters:
                break;
        }
        return false;
    });
}

namespace {

// Pixels of instances of which a surface has the property.
Mask instanceMask(const Image& objectIds, const Scene& scene, const MaterialBindings& materials,
                  const std::function<bool(const Surface&)>& has) {
    std::vector<std::uint8_t> chosen(scene.instances.size(), 0);
    for (const Surface& surface : surfacesOf(scene, materials)) {
        if (has(surface)) chosen[surface.instance] = 1;
    }
    return maskWhere(objectIds, [&](std::uint32_t id) {
        return id > 0 && id <= chosen.size() && chosen[id - 1] != 0;
    });
}

}  // namespace

Mask emissionMask(const Image& objectIds, const Scene& scene, const MaterialBindings& materials) {
    return instanceMask(objectIds, scene, materials, [](const Surface& s) { return s.emitter; });
}

Mask layersMask(const Image& objectIds, const Scene& scene, const MaterialBindings& materials) {
    return instanceMask(objectIds, scene, materials, [&](const Surface& s) {
        return hasLayers(materials.material(scene, s.material));
    });
}

Mask modelMask(const Image& objectIds) {
    return maskWhere(objectIds, [](std::uint32_t id) { return id > 0; });
}

ComparedPair comparedPair(const Image& actual, const Image& reference, const Mask* mask) {
    requireComparable(actual, reference, mask);
    const std::size_t pixels = std::size_t(actual.width) * actual.height;
    ComparedPair pair;
    for (std::size_t c = 0; c < 3; ++c) {
        pair.actual[c] = {actual.width, actual.height, std::vector<double>(pixels)};
        pair.reference[c] = pair.actual[c];
    }
    pair.counted.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        bool finite = true;
        for (std::size_t c = 0; c < 3; ++c) {
            finite &=
                std::isfinite(sampleOf(actual, i, c)) && std::isfinite(sampleOf(reference, i, c));
        }
        const bool inside = !mask || mask->inside[i] != 0;
        pair.counted[i] = inside && finite;
        pair.pixels += inside && finite;
        pair.nonFinite += inside && !finite;
        if (!finite) continue;
        for (std::size_t c = 0; c < 3; ++c) {
            pair.actual[c].values[i] = sampleOf(actual, i, c);
            pair.reference[c].values[i] = sampleOf(reference, i, c);
        }
    }
    return pair;
}

ComparedPair comparedPair(const Image& actual, const Image& reference, const Mask* mask,
                          PixelType type) {
    if (actual.type != type || reference.type != type) {
        throw std::runtime_error(type == PixelType::float32 ? "linear errors require float images"
                                                            : "these errors require 8-bit images");
    }
    return comparedPair(actual, reference, mask);
}

double meanOf(const Layer& layer, const ComparedPair& pair) {
    double sum = 0.0;
    for (std::size_t i = 0; i < layer.values.size(); ++i) {
        if (pair.counted[i]) sum += layer.values[i];
    }
    return pair.pixels ? sum / double(pair.pixels) : 0.0;
}

std::vector<double> gaussian(double sigma, int radius) {
    std::vector<double> weights;
    double sum = 0.0;
    for (int x = -radius; x <= radius; ++x) {
        weights.push_back(std::exp(-0.5 * x * x / (sigma * sigma)));
        sum += weights.back();
    }
    for (double& weight : weights) weight /= sum;  // the sum is at least 1
    return weights;
}

Layer filtered(const Layer& layer, std::span<const double> alongX, std::span<const double> alongY) {
    const auto width = static_cast<std::ptrdiff_t>(layer.width);
    const auto height = static_cast<std::ptrdiff_t>(layer.height);
    const auto radiusX = static_cast<std::ptrdiff_t>(alongX.size() / 2);
    const auto radiusY = static_cast<std::ptrdiff_t>(alongY.size() / 2);
    Layer rows = layer, result = layer;
    const auto index = [width](std::ptrdiff_t x, std::ptrdiff_t y) {
        return static_cast<std::size_t>(y * width + x);
    };
    for (std::ptrdiff_t y = 0; y < height; ++y) {
        for (std::ptrdiff_t x = 0; x < width; ++x) {
            double sum = 0.0;
            for (std::ptrdiff_t k = -radiusX; k <= radiusX; ++k) {
                const std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(x + k, 0, width - 1);
                sum += alongX[static_cast<std::size_t>(k + radiusX)] * layer.values[index(from, y)];
            }
            rows.values[index(x, y)] = sum;
        }
    }
    // Adds whole rows, which are contiguous in memory.
    std::fill(result.values.begin(), result.values.end(), 0.0);
    for (std::ptrdiff_t y = 0; y < height; ++y) {
        for (std::ptrdiff_t k = -radiusY; k <= radiusY; ++k) {
            const std::ptrdiff_t from = std::clamp<std::ptrdiff_t>(y + k, 0, height - 1);
            const double weight = alongY[static_cast<std::size_t>(k + radiusY)];
            for (std::ptrdiff_t x = 0; x < width; ++x) {
                result.values[index(x, y)] += weight * rows.values[index(x, from)];
            }
        }
    }
    return result;
}

}  // namespace clerestory
