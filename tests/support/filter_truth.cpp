#include "tests/support/filter_truth.h"

#include <algorithm>
#include <cmath>
#include <complex>

namespace clerestory::test {
namespace {

double greatest(const Picture& picture) {
    double most = 0.0;
    for (const glm::dvec3& p : picture.pixels) most = std::max({most, p.x, p.y, p.z});
    return most;
}

// Between pixels, whose centres lie at halves; x to the right, y down, from the upper left corner.
glm::dvec3 between(const Picture& from, double x, double y) {
    glm::dvec3 sum(0.0);
    double weights = 0.0;
    for (int j = static_cast<int>(std::floor(y - 0.5)); j <= std::floor(y - 0.5) + 1; ++j) {
        for (int i = static_cast<int>(std::floor(x - 0.5)); i <= std::floor(x - 0.5) + 1; ++i) {
            const double weight = std::max(0.0, 1.0 - std::abs(x - (i + 0.5))) *
                                  std::max(0.0, 1.0 - std::abs(y - (j + 0.5)));
            sum += weight *
                   from.at(std::clamp(i, 0, from.width - 1), std::clamp(j, 0, from.height - 1));
            weights += weight;
        }
    }
    return sum / weights;
}

glm::dvec3 bright(const glm::dvec3& c, double threshold) {
    const double most = std::max({c.x, c.y, c.z});
    return most > threshold ? c * ((most - threshold) / most) : glm::dvec3(0.0);
}

// One of every two columns and rows: weights 1 3 3 1 in either direction.
Picture halved(const Picture& from) {
    constexpr std::array kWeights{0.125, 0.375, 0.375, 0.125};
    Picture to((from.width + 1) / 2, (from.height + 1) / 2);
    for (int y = 0; y < to.height; ++y) {
        for (int x = 0; x < to.width; ++x) {
            for (int j = 0; j < 4; ++j) {
                for (int i = 0; i < 4; ++i) {
                    // Rows are paired from the lowest one on.
                    const int row = from.height - 1 - (2 * (to.height - 1 - y) - 1 + j);
                    to.at(x, y) += kWeights[i] * kWeights[j] *
                                   from.at(std::clamp(2 * x - 1 + i, 0, from.width - 1),
                                           std::clamp(row, 0, from.height - 1));
                }
            }
        }
    }
    return to;
}

Picture doubled(const Picture& from, int width, int height) {
    Picture to(width, height);
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const double fromBelow = 0.5 * (height - 1 - y + 0.5);
            to.at(x, y) = between(from, 0.5 * (x + 0.5), from.height - fromBelow);
        }
    }
    return to;
}

}  // namespace

Picture::Picture(const Image& image)
    : Picture(static_cast<int>(image.width), static_cast<int>(image.height)) {
    const float* p = image.floats();
    for (glm::dvec3& pixel : pixels) {
        pixel = {p[0], p[1], p[2]};
        p += 3;
    }
}

glm::dvec3 Picture::sum() const {
    glm::dvec3 total(0.0);
    for (const glm::dvec3& pixel : pixels) total += pixel;
    return total;
}

Picture twirled(const Picture& from, double amount, double radius) {
    Picture to = from;
    const double middleX = 0.5 * from.width, middleY = 0.5 * from.height;
    for (int y = 0; y < from.height; ++y) {
        for (int x = 0; x < from.width; ++x) {
            const std::complex<double> arm(x + 0.5 - middleX, middleY - (y + 0.5));  // up is up
            const double distance = std::abs(arm);
            if (radius >= 0.0 && distance > radius) continue;
            const auto seen = arm * std::polar(1.0, amount * distance / from.height);
            to.at(x, y) = between(from, middleX + seen.real(), middleY - seen.imag());
        }
    }
    return to;
}

Picture convolved(const Picture& from, const std::array<double, 9>& kernel, bool repeat) {
    Picture to(from.width, from.height);
    const auto index = [&](int i, int size) {
        return repeat ? (i + size) % size : std::clamp(i, 0, size - 1);
    };
    for (int y = 0; y < from.height; ++y) {
        for (int x = 0; x < from.width; ++x) {
            for (int k = 0; k < 9; ++k) {
                to.at(x, y) +=
                    kernel[static_cast<std::size_t>(k)] *
                    from.at(index(x + k % 3 - 1, from.width), index(y + k / 3 - 1, from.height));
            }
            to.at(x, y) = glm::clamp(to.at(x, y), 0.0, 65504.0);
        }
    }
    return to;
}

Picture glowing(const Picture& from, double threshold, double strength, double radius) {
    // Every level alone, then their mean: not the renderer's running blend.
    Picture part = from;
    for (glm::dvec3& p : part.pixels) p = bright(p, threshold);
    const double octaves = std::log2(radius);
    Picture spread(from.width, from.height);
    std::vector<Picture> levels{part};
    for (int k = 0; k < octaves; ++k) {
        levels.push_back(halved(levels.back()));
        Picture whole = levels.back();
        for (int up = k; up >= 0; --up) {
            const auto size = static_cast<std::size_t>(up);
            whole = doubled(whole, levels[size].width, levels[size].height);
        }
        const double weight = std::min(1.0, octaves - k) / std::max(1.0, octaves);
        for (std::size_t i = 0; i < spread.pixels.size(); ++i) {
            spread.pixels[i] += weight * whole.pixels[i];
        }
    }
    if (octaves < 1.0) {
        for (std::size_t i = 0; i < spread.pixels.size(); ++i) {
            spread.pixels[i] += (1.0 - octaves) * part.pixels[i];
        }
    }
    Picture to = from;
    for (std::size_t i = 0; i < to.pixels.size(); ++i) {
        to.pixels[i] += strength * (spread.pixels[i] - part.pixels[i]);
    }
    return to;
}

double greatestDifference(const Picture& a, const Picture& b) {
    double most = 0.0;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
        const glm::dvec3 d = glm::abs(a.pixels[i] - b.pixels[i]);
        most = std::max({most, d.x, d.y, d.z});
    }
    return most / std::max({greatest(a), greatest(b), 1e-9});
}

}  // namespace clerestory::test
