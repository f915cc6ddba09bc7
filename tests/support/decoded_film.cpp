#include "tests/support/decoded_film.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}
#include <webp/demux.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>

namespace clerestory::test {
namespace {

int readPiece(void* rest, std::uint8_t* to, int size) {
    auto& from = *static_cast<std::string_view*>(rest);
    if (from.empty()) return AVERROR_EOF;
    const std::size_t n = std::min(from.size(), static_cast<std::size_t>(size));
    std::memcpy(to, from.data(), n);
    from.remove_prefix(n);
    return static_cast<int>(n);
}

Image pictureOf(const AVFrame& frame) {
    Image image = makeImage(static_cast<std::uint32_t>(frame.width),
                            static_cast<std::uint32_t>(frame.height), 4, PixelType::srgb8);
    SwsContext* scaler = sws_alloc_context();
    const auto set = [&](const char* name, std::int64_t value) {
        EXPECT_EQ(av_opt_set_int(scaler, name, value, 0), 0) << name;
    };
    set("srcw", frame.width);
    set("srch", frame.height);
    set("src_format", frame.format);
    set("dstw", frame.width);
    set("dsth", frame.height);
    set("dst_format", AV_PIX_FMT_RGBA);
    set("sws_flags", SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT);
    // AVCHROMA_LOC_LEFT, in 1/256 pixel; otherwise it assumes the middle of both columns.
    set("src_h_chr_pos", 0);
    set("src_v_chr_pos", 128);
    EXPECT_GE(sws_init_context(scaler, nullptr, nullptr), 0);
    const int* table = sws_getCoefficients(SWS_CS_ITU709);
    sws_setColorspaceDetails(scaler, table, 0, table, 1, 0, 1 << 16, 1 << 16);
    std::uint8_t* to[] = {image.bytes()};
    const int stride[] = {4 * frame.width};
    sws_scale(scaler, frame.data, frame.linesize, 0, frame.height, to, stride);
    sws_freeContext(scaler);
    return image;
}

}  // namespace

DecodedFilm decodedMp4(std::string_view film) {
    DecodedFilm decoded;
    std::string_view rest = film;
    constexpr int kBuffer = 4096;
    AVFormatContext* file = avformat_alloc_context();
    AVIOContext* io = avio_alloc_context(static_cast<std::uint8_t*>(av_malloc(kBuffer)), kBuffer, 0,
                                         &rest, readPiece, nullptr, nullptr);
    file->pb = io;
    const auto closeIo = [&] {
        av_freep(&io->buffer);
        avio_context_free(&io);
    };
    if (avformat_open_input(&file, "film.mp4", nullptr, nullptr) < 0) {
        ADD_FAILURE() << "no MP4";
        closeIo();
        return decoded;
    }
    EXPECT_EQ(file->nb_streams, 1u);
    const AVStream& stream = *file->streams[0];
    EXPECT_EQ(stream.codecpar->codec_id, AV_CODEC_ID_H264);
    AVCodecContext* decoder = avcodec_alloc_context3(avcodec_find_decoder(AV_CODEC_ID_H264));
    avcodec_parameters_to_context(decoder, stream.codecpar);
    EXPECT_EQ(avcodec_open2(decoder, decoder->codec, nullptr), 0);
    AVFrame* frame = av_frame_alloc();
    const auto take = [&] {
        while (avcodec_receive_frame(decoder, frame) == 0) {
            decoded.pictures.push_back(pictureOf(*frame));
            decoded.times.push_back(static_cast<double>(frame->pts) * av_q2d(stream.time_base));
            decoded.isTagged709 = frame->colorspace == AVCOL_SPC_BT709 &&
                                  frame->color_primaries == AVCOL_PRI_BT709 &&
                                  frame->color_trc == AVCOL_TRC_IEC61966_2_1 &&
                                  frame->color_range == AVCOL_RANGE_MPEG &&
                                  frame->chroma_location == AVCHROMA_LOC_LEFT;
        }
    };
    AVPacket* packet = av_packet_alloc();
    while (av_read_frame(file, packet) == 0) {
        EXPECT_EQ(avcodec_send_packet(decoder, packet), 0);
        decoded.seconds =
            static_cast<double>(packet->pts + packet->duration) * av_q2d(stream.time_base);
        av_packet_unref(packet);
        take();
    }
    avcodec_send_packet(decoder, nullptr);
    take();
    decoded.frameRate = av_q2d(decoder->framerate);
    av_packet_free(&packet);
    av_frame_free(&frame);
    avcodec_free_context(&decoder);
    avformat_close_input(&file);
    closeIo();
    return decoded;
}

DecodedFilm decodedWebp(std::string_view film) {
    DecodedFilm decoded;
    const WebPData data{reinterpret_cast<const std::uint8_t*>(film.data()), film.size()};
    const std::unique_ptr<WebPAnimDecoder, void (*)(WebPAnimDecoder*)> decoder(
        WebPAnimDecoderNew(&data, nullptr), WebPAnimDecoderDelete);
    WebPAnimInfo info;
    if (!decoder || !WebPAnimDecoderGetInfo(decoder.get(), &info)) {
        ADD_FAILURE() << "no animated WebP";
        return decoded;
    }
    EXPECT_EQ(info.loop_count, 0u) << "it repeats";
    while (WebPAnimDecoderHasMoreFrames(decoder.get())) {
        std::uint8_t* rgba = nullptr;
        int end = 0;  // of the picture, milliseconds
        EXPECT_TRUE(WebPAnimDecoderGetNext(decoder.get(), &rgba, &end));
        Image image = makeImage(info.canvas_width, info.canvas_height, 4, PixelType::srgb8);
        std::copy_n(rgba, image.data.size(), image.bytes());
        decoded.pictures.push_back(std::move(image));
        decoded.times.push_back(decoded.seconds);
        decoded.seconds = end / 1000.0;
    }
    EXPECT_EQ(decoded.pictures.size(), info.frame_count);
    return decoded;
}

}  // namespace clerestory::test
