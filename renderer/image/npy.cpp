// NumPy's array file, version 1.0: magic, header length, a Python dictionary, the values.
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
#include "image/encode.h"

#include <bit>
#include <charconv>
#include <cstring>
#include <stdexcept>

namespace clerestory {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays are written as '<f4'");

constexpr std::string_view kMagic{"\x93NUMPY\x01\x00", 8};
constexpr std::size_t kAlignment = 64;        // of the first value, from the start of the file
constexpr std::uint32_t kMaxEdge = 1u << 16;  // prevents overflow for malicious shapes

std::string dictionary(const Image& image) {
    return "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(image.height) +
           ", " + std::to_string(image.width) + ", " + std::to_string(image.channels) + "), }";
}

[[noreturn]] void fail(const char* why) {
    throw std::runtime_error(std::string("NPY: cannot read: ") + why);
}

// Removes `expected` from the start of the text; fails if it is not there.
void skip(std::string_view& text, std::string_view expected) {
    if (!text.starts_with(expected)) fail("it was not written by encodeNpy");
    text.remove_prefix(expected.size());
}

std::uint32_t number(std::string_view& text) {
    std::uint32_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || value > kMaxEdge) fail("the shape is out of range");
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    return value;
}

}  // namespace

Bytes encodeNpy(const Image& image) {
    requireImage(image, "NPY", PixelType::float32, {1, 3, 4}, kMaxEdge);
    std::string header = dictionary(image);
    const std::size_t used = kMagic.size() + 2 + header.size() + 1;
    header.append((kAlignment - used % kAlignment) % kAlignment, ' ');
    header += '\n';
    Bytes bytes(kMagic);
    bytes += static_cast<char>(header.size() & 0xff);
    bytes += static_cast<char>(header.size() >> 8);
    bytes += header;
    bytes.append(reinterpret_cast<const char*>(image.data.data()), image.data.size());
    return bytes;
}

Image decodeNpy(std::string_view bytes) {
    skip(bytes, kMagic);
    if (bytes.size() < 2) fail("it is truncated");
    const std::size_t length = static_cast<std::uint8_t>(bytes[0]) |
                               static_cast<std::size_t>(static_cast<std::uint8_t>(bytes[1])) << 8;
    bytes.remove_prefix(2);
    if (bytes.size() < length) fail("it is truncated");
    std::string_view header = bytes.substr(0, length);
    bytes.remove_prefix(length);
    skip(header, "{'descr': '<f4', 'fortran_order': False, 'shape': (");
    const std::uint32_t height = number(header);
    skip(header, ", ");
    const std::uint32_t width = number(header);
    skip(header, ", ");
    const std::uint32_t channels = number(header);
    // The size is checked against the file before anything is allocated.
    if (bytes.size() != std::size_t(width) * height * channels * sizeof(float)) {
        fail("its size does not match its shape");
    }
    Image image = makeImage(width, height, channels, PixelType::float32);
    if (!bytes.empty()) std::memcpy(image.data.data(), bytes.data(), bytes.size());
    return image;
}

}  // namespace clerestory
