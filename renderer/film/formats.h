// The two kinds of film, for makeFilm().
#pragma once

#include "film/film.h"

namespace clerestory {

std::unique_ptr<Film> makeMp4(const FilmSettings& settings, FilmSink sink);
std::unique_ptr<Film> makeAnimatedWebp(const FilmSettings& settings, FilmSink sink);

}  // namespace clerestory
