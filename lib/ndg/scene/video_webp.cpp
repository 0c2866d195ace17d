// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/video_webp.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <webp/encode.h>
#include <webp/mux.h>

#include <cmath>
#include <string_view>

namespace ndg {
namespace {

class WebpWriter : public VideoWriter {
public:
    WebpWriter(const std::string& path, double frame_rate, int quality) : path_(path), frame_rate_(frame_rate)
    {
        require(WebPConfigPreset(&config_, WEBP_PRESET_DRAWING, float(quality)) != 0, "libwebp: no settings");
        config_.method = 4;
    }
    ~WebpWriter() override { WebPAnimEncoderDelete(encoder_); }

    void add(const Image& frame) override
    {
        if (encoder_ == nullptr) start(frame.width, frame.height);
        WebPPicture picture;
        require(WebPPictureInit(&picture) != 0, "libwebp has another version than its headers");
        picture.use_argb = 1;
        picture.width = frame.width;
        picture.height = frame.height;
        const bool done = WebPPictureImportRGB(&picture, frame.pixels[0].data(), 3 * frame.width) != 0 &&
                          WebPAnimEncoderAdd(encoder_, &picture, milliseconds(num_frames_), &config_) != 0;
        WebPPictureFree(&picture);
        require(done, "{}: frame {}: {}", path_, num_frames_, WebPAnimEncoderGetError(encoder_));
        ++num_frames_;
    }
    void finish() override
    {
        WebPData data;
        WebPDataInit(&data);
        const bool done = WebPAnimEncoderAdd(encoder_, nullptr, milliseconds(num_frames_), nullptr) != 0 &&
                          WebPAnimEncoderAssemble(encoder_, &data) != 0;
        const std::string bytes(reinterpret_cast<const char*>(data.bytes), done ? data.size : 0);
        WebPDataClear(&data);
        require(done, "{}: {}", path_, WebPAnimEncoderGetError(encoder_));
        write_file(path_, bytes);
    }

private:
    void start(int width, int height)
    {
        WebPAnimEncoderOptions options;
        require(WebPAnimEncoderOptionsInit(&options) != 0, "libwebp has another version than its headers");
        options.anim_params.loop_count = 0;  // for ever
        options.minimize_size = 1;
        encoder_ = WebPAnimEncoderNew(width, height, &options);
        require(encoder_ != nullptr, "{}: libwebp cannot write {} x {} pixels", path_, width, height);
    }
    int milliseconds(int frame_idx) const { return int(std::lround(1000.0 * frame_idx / frame_rate_)); }

    std::string path_;
    double frame_rate_;
    WebPConfig config_{};
    WebPAnimEncoder* encoder_ = nullptr;
    int num_frames_ = 0;
};

}  // namespace

std::unique_ptr<VideoWriter> webp_writer(const std::string& path, double frame_rate, int quality)
{
    return std::make_unique<WebpWriter>(path, frame_rate, quality);
}

}  // namespace ndg
