// Films read by the decoders of libavcodec, libswscale and libwebp.
#pragma once

#include "image/image.h"

#include <string_view>
#include <vector>

namespace clerestory::test {

struct DecodedFilm {
    std::vector<Image> pictures;  // srgb8, 4 channels
    std::vector<double> times;    // seconds, of each picture
    double frameRate = 0.0;       // that an MP4 states
    double seconds = 0.0;         // to the end of the last picture
    // BT.709 colours in limited range, with the curve of sRGB; false for WebP.
    bool isTagged709 = false;
};

// Expects that the film is whole.
DecodedFilm decodedMp4(std::string_view film);
DecodedFilm decodedWebp(std::string_view film);

}  // namespace clerestory::test
