// Images, and the formats that need no library: EXR and NPY.
#include "image/image.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <stdexcept>

namespace clerestory {
namespace {

// OpenEXR, version 2, one part of uncompressed float scan lines: a header of named attributes, a
// table of offsets, and for each line its channels in alphabetical order.
// https://openexr.com/en/latest/OpenEXRFileLayout.html

static_assert(std::endian::native == std::endian::little, "the format is little-endian");

template <class T>
void put(Bytes& to, const T& value) {
    to.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void putName(Bytes& to, std::string_view name) {
    to.append(name);
    to += '\0';
}

void putAttribute(Bytes& to, std::string_view name, std::string_view type, const Bytes& value) {
    putName(to, name);
    putName(to, type);
    put(to, static_cast<std::int32_t>(value.size()));
    to += value;
}

// A channel's name and its index in an Image's pixel.
struct Channel {
    char name;
    std::uint32_t offset;
};

std::vector<Channel> channelsOf(const Image& image) {
    if (image.channels == 1) return {{'Y', 0}};
    if (image.channels == 3) return {{'B', 2}, {'G', 1}, {'R', 0}};
    return {{'A', 3}, {'B', 2}, {'G', 1}, {'R', 0}};
}

Bytes channelList(const std::vector<Channel>& channels) {
    Bytes list;
    for (const Channel& channel : channels) {
        putName(list, std::string_view(&channel.name, 1));
        put(list, std::int32_t{2});  // 32-bit float
        put(list, std::int32_t{0});  // not perceptually linear, and three reserved bytes
        put(list, std::int32_t{1});  // every column
        put(list, std::int32_t{1});  // every row
    }
    list += '\0';
    return list;
}

template <class... T>
Bytes packed(const T&... values) {
    Bytes bytes;
    (put(bytes, values), ...);
    return bytes;
}

// NumPy's array file, version 1.0: magic, header length, a Python dictionary, the values.
// https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html

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

Image makeImage(std::uint32_t width, std::uint32_t height, std::uint32_t channels, PixelType type) {
    Image image;
    reshape(image, width, height, channels, type);
    return image;
}

void reshape(Image& image, std::uint32_t width, std::uint32_t height, std::uint32_t channels,
             PixelType type) {
    if (channels != 1 && channels != 3 && channels != 4) {
        throw std::runtime_error("an image has 1, 3 or 4 channels, not " +
                                 std::to_string(channels));
    }
    const std::size_t sample = type == PixelType::float32 ? sizeof(float) : 1;
    image.width = width;
    image.height = height;
    image.channels = channels;
    image.type = type;
    image.data.resize(std::size_t(width) * height * channels * sample);
}

void requireImage(const Image& image, const std::string& format, PixelType type,
                  std::initializer_list<std::uint32_t> channels, std::uint32_t maxEdge) {
    const auto fail = [&](const std::string& why) {
        throw std::runtime_error(format + ": cannot encode an image " + why);
    };
    if (image.width == 0 || image.height == 0) fail("without pixels");
    if (image.width > maxEdge || image.height > maxEdge) {
        fail("with an edge above " + std::to_string(maxEdge));
    }
    if (image.type != type) {
        fail(type == PixelType::srgb8 ? "of type float; 8 bits are required"
                                      : "of 8 bits; float is required");
    }
    if (std::find(channels.begin(), channels.end(), image.channels) == channels.end()) {
        fail("with " + std::to_string(image.channels) + " channels");
    }
    const std::size_t sample = type == PixelType::float32 ? sizeof(float) : 1;
    if (image.data.size() != std::size_t(image.width) * image.height * image.channels * sample) {
        fail("whose data size is not width * height * channels");
    }
}

void requireDecodable(const std::string& format, std::uint64_t width, std::uint64_t height) {
    if (width == 0 || height == 0 || width > kMaxDecodedPixels / height) {
        throw std::runtime_error(format + ": cannot decode " + std::to_string(width) + " x " +
                                 std::to_string(height) + " pixels: too large or empty");
    }
}

Bytes encodeExr(const Image& image) {
    requireImage(image, "EXR", PixelType::float32, {1, 3, 4}, 1u << 20);
    const std::vector<Channel> channels = channelsOf(image);
    const Bytes window =
        packed(std::int32_t{0}, std::int32_t{0}, static_cast<std::int32_t>(image.width) - 1,
               static_cast<std::int32_t>(image.height) - 1);
    Bytes bytes = packed(std::int32_t{20000630}, std::int32_t{2});  // magic, version
    putAttribute(bytes, "channels", "chlist", channelList(channels));
    putAttribute(bytes, "compression", "compression", Bytes(1, '\0'));
    putAttribute(bytes, "dataWindow", "box2i", window);
    putAttribute(bytes, "displayWindow", "box2i", window);
    putAttribute(bytes, "lineOrder", "lineOrder", Bytes(1, '\0'));  // top row first
    putAttribute(bytes, "pixelAspectRatio", "float", packed(1.0f));
    putAttribute(bytes, "screenWindowCenter", "v2f", packed(0.0f, 0.0f));
    putAttribute(bytes, "screenWindowWidth", "float", packed(1.0f));
    bytes += '\0';

    const std::size_t lineBytes = std::size_t(image.width) * image.channels * sizeof(float);
    const std::size_t blockBytes = 2 * sizeof(std::int32_t) + lineBytes;
    const std::size_t firstBlock = bytes.size() + image.height * sizeof(std::uint64_t);
    bytes.reserve(firstBlock + image.height * blockBytes);
    for (std::size_t y = 0; y < image.height; ++y) {
        put(bytes, static_cast<std::uint64_t>(firstBlock + y * blockBytes));
    }
    for (std::uint32_t y = 0; y < image.height; ++y) {
        put(bytes, static_cast<std::int32_t>(y));
        put(bytes, static_cast<std::int32_t>(lineBytes));
        const float* row = image.floats() + std::size_t(y) * image.width * image.channels;
        for (const Channel& channel : channels) {
            for (std::uint32_t x = 0; x < image.width; ++x) {
                put(bytes, row[std::size_t(x) * image.channels + channel.offset]);
            }
        }
    }
    return bytes;
}

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
