// Films: pictures of one size at a constant rate, as MP4 (H.264) or as animated WebP.
//
//     const auto film = makeFilm({.format = FilmFormat::mp4, .width = 640, .height = 360}, sink);
//     for (const Bytes& picture : pictures) {
//         if (!film->add(picture)) return;  // the sink refused
//     }
//     film->end();
//
// The same settings and pictures give the same bytes, with the same version of the libraries: a
// film contains no date, and is encoded by one thread, the caller's.
//
// MP4 is sent in fragments of about one second, so that a film begins before its last picture is
// known. The memory of its encoder does not depend on the number of pictures. An animated WebP
// states its length first: it is sent whole by end(), and holds at most kMaxWebpFilmBytes.
#pragma once

#include "image/image.h"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace clerestory {

enum class FilmFormat { mp4, webp };

struct FilmSettings {
    FilmFormat format = FilmFormat::mp4;
    std::uint32_t width = 0, height = 0;  // of MP4 even, and at most kMaxMp4Pixels together
    double frameRate = 30.0;              // pictures per second, 0.001 to 1000
    std::uint32_t quality = 85;           // of MP4, 1 to 100; the pictures of WebP have their own
};

// Frame size of level 5.2 of H.264 (ITU-T H.264, table A-1): 36864 blocks of 16 x 16.
inline constexpr std::uint64_t kMaxMp4Pixels = 36'864 * 256;
// Pixels of all pictures of an animated WebP, and bytes of the film.
inline constexpr std::uint64_t kMaxWebpFilmPixels = 1u << 28;
inline constexpr std::size_t kMaxWebpFilmBytes = 128 << 20;

// Returns false if nothing more can be sent.
using FilmSink = std::function<bool(std::string_view piece)>;

class Film {
public:
    virtual ~Film() = default;
    // A PNG for MP4, a lossy WebP for WebP, of the size of the film. Both return false once the
    // sink has refused, and throw std::runtime_error if the picture cannot be encoded.
    virtual bool add(std::string_view picture) = 0;
    virtual bool end() = 0;
};

// `sink` is called during add() and end() only. Throws std::runtime_error if mp4Missing() says why,
// or the encoder refuses the settings.
std::unique_ptr<Film> makeFilm(const FilmSettings& settings, FilmSink sink);

// What a machine lacks for MP4, with the name of the library; empty: nothing.
std::string mp4Missing();

// The version of libavformat, "59.27.100": of the headers, and of the library that is loaded; empty
// if mp4Missing() says why.
std::string libavformatBuilt();
std::string libavformatLoaded();

}  // namespace clerestory
