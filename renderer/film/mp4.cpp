// MP4 in fragments, with H.264 by x264 through libavcodec.
#include "film/bt709.h"
#include "film/formats.h"
#include "film/libav.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace clerestory {
namespace {

constexpr int kBufferBytes = 1 << 16;

// x264's constant rate factor: 18, which it calls visually lossless, for the default quality 85.
std::string rateFactor(std::uint32_t quality) {
    return std::to_string(
        std::clamp(18.0 + (85.0 - static_cast<double>(quality)) * 0.5, 0.0, 51.0));
}

class Mp4 final : public Film {
public:
    Mp4(const FilmSettings& settings, FilmSink sink) : settings_(settings), sink_(std::move(sink)) {
        try {
            openEncoder();
            openFile();
        } catch (...) {
            close();
            throw;
        }
    }
    ~Mp4() override { close(); }
    Mp4(const Mp4&) = delete;
    Mp4& operator=(const Mp4&) = delete;

    bool add(std::string_view picture) override {
        const Image image = decodePng(picture);
        if (image.width != settings_.width || image.height != settings_.height) {
            throw std::runtime_error("MP4: the pictures differ in size");
        }
        require(av_.av_frame_make_writable(frame_), "a picture");
        std::array<ImagePlane, 3> planes;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            planes[i] = {frame_->data[i], frame_->linesize[i]};
        }
        toBt709(image, planes);
        frame_->pts = next_++;
        require(av_.avcodec_send_frame(encoder_, frame_), "encoding");
        return writePackets();
    }

    bool end() override {
        require(av_.avcodec_send_frame(encoder_, nullptr), "encoding the end");
        if (!writePackets()) return false;
        const int ended = av_.av_write_trailer(file_);
        if (!left_) require(ended, "writing the end");
        return !left_;
    }

private:
    void openEncoder() {
        encoder_ = av_.avcodec_alloc_context3(av_.x264);
        frame_ = av_.av_frame_alloc();
        packet_ = av_.av_packet_alloc();
        if (!encoder_ || !frame_ || !packet_) throw std::bad_alloc();
        const AVRational rate = av_.av_d2q(settings_.frameRate, 1'000'000);
        encoder_->width = frame_->width = static_cast<int>(settings_.width);
        encoder_->height = frame_->height = static_cast<int>(settings_.height);
        encoder_->framerate = rate;
        encoder_->time_base = {rate.den, rate.num};
        encoder_->gop_size = std::clamp(static_cast<int>(std::lround(settings_.frameRate)), 1, 250);
        encoder_->thread_count = 1;
        encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
        encoder_->pix_fmt = AV_PIX_FMT_YUV420P;
        encoder_->color_range = AVCOL_RANGE_MPEG;
        encoder_->colorspace = AVCOL_SPC_BT709;
        encoder_->color_primaries = AVCOL_PRI_BT709;
        encoder_->color_trc = AVCOL_TRC_IEC61966_2_1;  // the values are coded as sRGB
        encoder_->chroma_sample_location = AVCHROMA_LOC_LEFT;
        frame_->format = encoder_->pix_fmt;
        // Each picture leaves at once: without pictures that wait, memory is that of a few.
        AVDictionary* options = nullptr;
        av_.av_dict_set(&options, "preset", "medium", 0);
        av_.av_dict_set(&options, "tune", "zerolatency", 0);
        av_.av_dict_set(&options, "crf", rateFactor(settings_.quality).c_str(), 0);
        const int opened = av_.avcodec_open2(encoder_, av_.x264, &options);
        av_.av_dict_free(&options);
        require(opened, "x264");
        require(av_.av_frame_get_buffer(frame_, 0), "a picture");
    }

    void openFile() {
        require(av_.avformat_alloc_output_context2(&file_, nullptr, "mp4", nullptr), "the file");
        file_->flags |= AVFMT_FLAG_BITEXACT | AVFMT_FLAG_CUSTOM_IO;
        auto* buffer = static_cast<unsigned char*>(av_.av_malloc(kBufferBytes));
        file_->pb =
            av_.avio_alloc_context(buffer, kBufferBytes, 1, this, nullptr, &Mp4::write, nullptr);
        stream_ = av_.avformat_new_stream(file_, nullptr);
        if (!file_->pb || !stream_) throw std::bad_alloc();
        stream_->time_base = encoder_->time_base;
        stream_->avg_frame_rate = encoder_->framerate;
        require(av_.avcodec_parameters_from_context(stream_->codecpar, encoder_), "the stream");
        AVDictionary* options = nullptr;
        av_.av_dict_set(&options, "movflags", "frag_keyframe+empty_moov+default_base_moof", 0);
        const int begun = av_.avformat_write_header(file_, &options);
        av_.av_dict_free(&options);
        if (!left_) require(begun, "the head of the file");
        av_.avio_flush(file_->pb);
    }

    bool writePackets() {
        while (!left_) {
            const int received = av_.avcodec_receive_packet(encoder_, packet_);
            if (received == AVERROR(EAGAIN) || received == AVERROR_EOF) break;
            require(received, "encoding");
            packet_->stream_index = stream_->index;
            packet_->duration = 1;
            av_.av_packet_rescale_ts(packet_, encoder_->time_base, stream_->time_base);
            const int written = av_.av_write_frame(file_, packet_);
            if (!left_) require(written, "writing");
        }
        return !left_;
    }

#if LIBAVFORMAT_VERSION_MAJOR >= 61
    using WriteBytes = const std::uint8_t*;
#else
    using WriteBytes = std::uint8_t*;
#endif
    // Once the sink has refused nothing is written, not even the end of the file.
    static int write(void* self, WriteBytes bytes, int size) {
        auto* mp4 = static_cast<Mp4*>(self);
        if (!mp4->left_) {
            mp4->left_ =
                !mp4->sink_({reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size)});
        }
        return mp4->left_ ? AVERROR_EXIT : size;
    }

    void require(int result, const char* what) const {
        if (result >= 0) return;
        char text[AV_ERROR_MAX_STRING_SIZE] = {};
        av_.av_strerror(result, text, sizeof text);
        throw std::runtime_error(std::string("MP4: ") + what + ": " + text);
    }

    // Sends nothing.
    void close() {
        left_ = true;
        if (file_ && file_->pb) {
            void* buffer = file_->pb->buffer;
            av_.avio_context_free(&file_->pb);
            av_.av_free(buffer);
        }
        av_.avformat_free_context(file_);
        av_.avcodec_free_context(&encoder_);
        av_.av_frame_free(&frame_);
        av_.av_packet_free(&packet_);
    }

    const Libav& av_ = libav();
    const FilmSettings settings_;
    const FilmSink sink_;
    bool left_ = false;
    AVCodecContext* encoder_ = nullptr;
    AVFrame* frame_ = nullptr;
    AVPacket* packet_ = nullptr;
    AVFormatContext* file_ = nullptr;
    AVStream* stream_ = nullptr;
    std::int64_t next_ = 0;
};

}  // namespace

std::unique_ptr<Film> makeMp4(const FilmSettings& settings, FilmSink sink) {
    return std::make_unique<Mp4>(settings, std::move(sink));
}

}  // namespace clerestory
