// OpenEXR, version 2, one part of uncompressed float scan lines: a header of named attributes, a
// table of offsets, and for each line its channels in alphabetical order.
// https://openexr.com/en/latest/OpenEXRFileLayout.html
#include "image/encode.h"

#include <array>
#include <bit>

namespace clerestory {
namespace {

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

}  // namespace

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

}  // namespace clerestory
