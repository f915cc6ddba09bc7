#include "tests/support/compare_images.h"

#include "image/image.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

namespace clerestory::test {
namespace {

bool sameShape(const Image& a, const Image& b) {
    return a.width == b.width && a.height == b.height && a.channels == b.channels &&
           a.type == b.type && a.data.size() == b.data.size();
}

double sampleOf(const Image& image, std::size_t i) {
    return image.type == PixelType::float32 ? double(image.floats()[i]) : image.bytes()[i] / 255.0;
}

// Floats as displayed; bytes unchanged.
std::uint8_t shown(const Image& image, std::size_t i) {
    if (image.type == PixelType::srgb8) return image.bytes()[i];
    const double x = sampleOf(image, i);
    if (!std::isfinite(x)) return 255;
    return static_cast<std::uint8_t>(255.0 * std::pow(std::clamp(x, 0.0, 1.0), 1.0 / 2.2) + 0.5);
}

std::string writePicture(const Image& actual, const Image& expected) {
    const auto* running = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name =
        running ? std::string(running->test_suite_name()) + "." + running->name() : "images";
    std::replace(name.begin(), name.end(), '/', '_');
    const std::filesystem::path path =
        std::filesystem::path(CLERESTORY_TEST_OUTPUT) / (name + ".png");
    std::filesystem::create_directories(path.parent_path());
    const Bytes png = encodePng(sideBySide(actual, expected));
    std::ofstream(path, std::ios::binary)
        .write(png.data(), static_cast<std::streamsize>(png.size()));
    return path.string();
}

}  // namespace

Difference difference(const Image& actual, const Image& expected, double bound) {
    Difference d{.sameShape = sameShape(actual, expected)};
    if (!d.sameShape) return d;
    double sum = 0.0, worst = -1.0;
    std::uint64_t over = 0;
    std::size_t i = 0;
    for (std::uint32_t y = 0; y < actual.height; ++y) {
        for (std::uint32_t x = 0; x < actual.width; ++x) {
            bool pixelOver = false;
            for (std::uint32_t c = 0; c < actual.channels; ++c, ++i) {
                const double a = sampleOf(actual, i), e = sampleOf(expected, i);
                const bool finite = std::isfinite(a) && std::isfinite(e);
                // A non-finite sample is worse than any difference, but not part of the mean.
                const double apart = finite ? std::abs(a - e) : HUGE_VAL;
                if (apart > worst) {
                    worst = apart;
                    d.worstX = x;
                    d.worstY = y;
                }
                pixelOver |= apart > bound;
                if (finite) {
                    d.max = std::max(d.max, apart);
                    sum += apart;
                } else {
                    ++d.nonFinite;
                }
            }
            over += pixelOver;
        }
    }
    const double pixels = double(actual.width) * actual.height;
    if (i > d.nonFinite) d.mean = sum / double(i - d.nonFinite);
    if (pixels > 0.0) d.shareOver = double(over) / pixels;
    return d;
}

Image sideBySide(const Image& actual, const Image& expected) {
    const double max = std::max(difference(actual, expected, 0.0).max, 1e-30);
    Image picture = makeImage(3 * actual.width, actual.height, 3, PixelType::srgb8);
    for (std::uint32_t y = 0; y < actual.height; ++y) {
        for (std::uint32_t x = 0; x < actual.width; ++x) {
            const std::size_t from = (std::size_t(y) * actual.width + x) * actual.channels;
            for (std::uint32_t c = 0; c < 3; ++c) {
                const std::size_t i = from + std::min(c, actual.channels - 1);
                const double apart = std::abs(sampleOf(actual, i) - sampleOf(expected, i));
                const auto put = [&](std::uint32_t column, std::uint8_t value) {
                    picture
                        .bytes()[(std::size_t(y) * picture.width + column * actual.width + x) * 3 +
                                 c] = value;
                };
                put(0, shown(actual, i));
                put(1, shown(expected, i));
                put(2, std::isfinite(apart) ? static_cast<std::uint8_t>(255.0 * apart / max) : 255);
            }
        }
    }
    return picture;
}

::testing::AssertionResult imagesMatch(const Image& actual, const Image& expected,
                                       const Tolerance& tolerance) {
    const Difference d = difference(actual, expected, tolerance.bound);
    if (!d.sameShape) {
        return ::testing::AssertionFailure()
               << "the images have different shapes: " << actual.width << " x " << actual.height
               << " x " << actual.channels << " and " << expected.width << " x " << expected.height
               << " x " << expected.channels << ", or different types";
    }
    if (d.nonFinite == 0 && d.shareOver <= tolerance.shareOver) {
        return ::testing::AssertionSuccess();
    }
    return ::testing::AssertionFailure()
           << "beyond '" << tolerance.name << "' (" << tolerance.bound << " but for "
           << tolerance.shareOver << " of the pixels): greatest difference " << d.max << ", mean "
           << d.mean << ", " << d.shareOver << " of the pixels over, " << d.nonFinite
           << " samples not finite, worst at column " << d.worstX << ", row " << d.worstY
           << "; actual, expected and difference: " << writePicture(actual, expected);
}

}  // namespace clerestory::test
