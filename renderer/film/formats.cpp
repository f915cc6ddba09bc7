#include "film/formats.h"

namespace clerestory {

std::unique_ptr<Film> makeFilm(const FilmSettings& settings, FilmSink sink) {
    return settings.format == FilmFormat::mp4 ? makeMp4(settings, std::move(sink))
                                              : makeAnimatedWebp(settings, std::move(sink));
}

}  // namespace clerestory
