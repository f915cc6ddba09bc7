#include "film/libav.h"

#include "film/film.h"

#include <dlfcn.h>

#include <stdexcept>
#include <string>

namespace clerestory {
namespace {

std::string dotted(unsigned version) {
    return std::to_string(AV_VERSION_MAJOR(version)) + "." +
           std::to_string(AV_VERSION_MINOR(version)) + "." +
           std::to_string(AV_VERSION_MICRO(version));
}

}  // namespace

Libav loadLibav(const std::string& library) {
    // Never closed: libraries with threads or thread-local memory do not all allow it.
    void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle) throw std::runtime_error("MP4 needs " + library + ", which cannot be loaded");
    Libav av;
    // Looked up in the library and in those that it needs.
    const auto load = [&](auto& function, const char* name) {
        function =
            reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(handle, name));
        if (!function) throw std::runtime_error(library + " has no function " + name);
    };
#define CLERESTORY_LOAD(name) load(av.name, #name);
    CLERESTORY_LIBAV(CLERESTORY_LOAD)
#undef CLERESTORY_LOAD
    av.av_log_set_level(AV_LOG_QUIET);
    av.x264 = av.avcodec_find_encoder_by_name("libx264");
    if (!av.x264) {
        throw std::runtime_error(
            "MP4 needs the encoder libx264, which the libavcodec of this "
            "machine does not have");
    }
    return av;
}

const Libav& libav() {
    static const Libav loaded =
        loadLibav("libavformat.so." + std::to_string(LIBAVFORMAT_VERSION_MAJOR));
    return loaded;
}

std::string libavformatBuilt() {
    return dotted(LIBAVFORMAT_VERSION_INT);
}

std::string libavformatLoaded() {
    return mp4Missing().empty() ? dotted(libav().avformat_version()) : "";
}

std::string mp4Missing() {
    try {
        libav();
        return {};
    } catch (const std::runtime_error& error) {
        return error.what();
    }
}

}  // namespace clerestory
