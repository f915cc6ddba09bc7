// Animated WebP of pictures that are WebP already: they are put together without decoding.
#include "film/formats.h"

#include <webp/mux.h>

#include <cmath>
#include <stdexcept>

namespace clerestory {
namespace {

class AnimatedWebp final : public Film {
public:
    AnimatedWebp(const FilmSettings& settings, FilmSink sink)
        : settings_(settings), sink_(std::move(sink)), mux_(WebPMuxNew(), WebPMuxDelete) {
        const WebPMuxAnimParams forever{.bgcolor = 0xff000000, .loop_count = 0};
        require(mux_ ? WebPMuxSetCanvasSize(mux_.get(), static_cast<int>(settings.width),
                                            static_cast<int>(settings.height))
                     : WEBP_MUX_MEMORY_ERROR);
        require(WebPMuxSetAnimationParams(mux_.get(), &forever));
    }

    bool add(std::string_view picture) override {
        bytes_ += picture.size();
        if (bytes_ > kMaxWebpFilmBytes) {
            throw std::runtime_error("animated WebP: the film has more than " +
                                     std::to_string(kMaxWebpFilmBytes >> 20) + " MiB");
        }
        const int begin = milliseconds(count_);
        WebPMuxFrameInfo frame{};
        frame.bitstream = {reinterpret_cast<const std::uint8_t*>(picture.data()), picture.size()};
        frame.duration = milliseconds(++count_) - begin;
        frame.id = WEBP_CHUNK_ANMF;
        frame.dispose_method = WEBP_MUX_DISPOSE_NONE;
        frame.blend_method = WEBP_MUX_NO_BLEND;
        require(WebPMuxPushFrame(mux_.get(), &frame, 1));
        return true;
    }

    bool end() override {
        WebPData film;
        WebPDataInit(&film);
        const std::unique_ptr<WebPData, void (*)(WebPData*)> owned(&film, WebPDataClear);
        require(WebPMuxAssemble(mux_.get(), &film));
        mux_.reset();
        return sink_({reinterpret_cast<const char*>(film.bytes), film.size});
    }

private:
    // Durations are whole milliseconds: rounded at each picture's time, so that errors do not add
    // up.
    int milliseconds(std::uint64_t index) const {
        return static_cast<int>(
            std::llround(1000.0 * static_cast<double>(index) / settings_.frameRate));
    }
    static void require(WebPMuxError error) {
        if (error == WEBP_MUX_OK) return;
        throw std::runtime_error("animated WebP: error " + std::to_string(error) +
                                 " of libwebpmux");
    }

    const FilmSettings settings_;
    const FilmSink sink_;
    std::unique_ptr<WebPMux, void (*)(WebPMux*)> mux_;
    std::uint64_t count_ = 0;
    std::size_t bytes_ = 0;
};

}  // namespace

std::unique_ptr<Film> makeAnimatedWebp(const FilmSettings& settings, FilmSink sink) {
    return std::make_unique<AnimatedWebp>(settings, std::move(sink));
}

}  // namespace clerestory
