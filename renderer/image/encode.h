// Encodes images to file bytes, and decodes what tests and the loader need. Thread-safe: no shared
// state. All functions throw std::runtime_error with the cause.
#pragma once

#include "image/image.h"

namespace clerestory {

using Bytes = std::string;  // file content

// srgb8 images of 3 or 4 channels; alpha is ignored. quality 1..100.
Bytes encodeJpeg(const Image& image, int quality, bool subsample420);
Bytes encodePng(const Image& image);  // srgb8, 1, 3 or 4 channels
Bytes encodeNpy(const Image& image);  // float32, shape H x W x C (NPY version 1.0)
Bytes encodeExr(const Image& image);  // float32; channels named Y, or R G B (A)

Image decodeJpeg(std::string_view bytes);  // 3 channels
Image decodePng(std::string_view bytes);   // 4 channels
Image decodeNpy(std::string_view bytes);   // only files written by encodeNpy

}  // namespace clerestory
