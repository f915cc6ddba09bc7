// A sequence as a film: what it must be, and the pictures that its frames become.
#pragma once

#include "film/film.h"
#include "server/api/sequence_request.h"

#include <optional>
#include <string>
#include <string_view>

namespace clerestory {

const char* mediaType(FilmFormat format);
// Of an Accept header that names one; the first in the order of FilmFormat.
std::optional<FilmFormat> filmFormatIn(const std::string& accept);
// Of the name of a file that ends with .mp4 or .webp.
std::optional<FilmFormat> filmFormatOf(std::string_view file);

// Changes the sequence so that the only pictures of its frames are those that Film::add() takes.
// Throws RequestError (422) that lists every field that a film cannot have: another channel than
// colour, no frame rate, frames that differ in size or output, a size that the format does not
// have, or MP4 on a machine that lacks its libraries.
FilmSettings makeFilmSequence(Sequence& sequence, FilmFormat format);

}  // namespace clerestory
