// The functions of libavformat and its libraries that MP4 needs, loaded when the first film is
// made: with some 70 libraries of their own they would add 80 ms to every start of every process.
//
//     const Libav& av = libav();  // throws std::runtime_error that names what is missing
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/log.h>
}

#include <string>

namespace clerestory {

#define CLERESTORY_LIBAV(use)                                                                   \
    use(av_d2q) use(av_dict_free) use(av_dict_set) use(av_frame_alloc) use(av_frame_free)       \
        use(av_frame_get_buffer) use(av_frame_make_writable) use(av_free) use(av_log_set_level) \
            use(av_malloc) use(av_packet_alloc) use(av_packet_free) use(av_packet_rescale_ts)   \
                use(av_strerror) use(av_write_frame) use(av_write_trailer)                      \
                    use(avcodec_alloc_context3) use(avcodec_find_encoder_by_name)               \
                        use(avcodec_free_context) use(avcodec_open2)                            \
                            use(avcodec_parameters_from_context) use(avcodec_receive_packet)    \
                                use(avcodec_send_frame) use(avformat_alloc_output_context2)     \
                                    use(avformat_free_context) use(avformat_new_stream)         \
                                        use(avformat_version) use(avformat_write_header)        \
                                            use(avio_alloc_context) use(avio_context_free)      \
                                                use(avio_flush)

struct Libav {
#define CLERESTORY_MEMBER(name) decltype(&::name) name = nullptr;
    CLERESTORY_LIBAV(CLERESTORY_MEMBER)
#undef CLERESTORY_MEMBER
    const AVCodec* x264 = nullptr;
};

// Thread-safe. The version of the library is that of the headers.
const Libav& libav();

// The same for this library file; the result is not cached.
Libav loadLibav(const std::string& library);

}  // namespace clerestory
