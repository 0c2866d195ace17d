// SPDX-License-Identifier: Apache-2.0
// Frames one after the other, as a file that plays or as numbered pictures.
#pragma once

#include "ndg/scene/image.h"

#include <functional>
#include <memory>
#include <string>

namespace ndg {

/// Where frames go; files appear under their name when they are finished.
class VideoWriter {
public:
    virtual ~VideoWriter() = default;
    virtual void add(const Image& frame) = 0;
    virtual void finish() = 0;
};

/// The writer for a file name. ".png": pictures, numbered where the name holds "{}" or "{:04}"; ".webp": an animated
/// picture; ".mp4", ".mkv", ".mov", ".webm", ".gif": by the program ffmpeg. `quality` from 0 to 100 of lossy ones.
/// Throws InputError for another extension, for several frames and a ".png" without a place for the number, and where
/// ffmpeg is needed and missing.
std::unique_ptr<VideoWriter> video_writer(const std::string& path, int num_frames, double frame_rate, int quality);

/// The files that the writer of this name writes.
std::vector<std::string> video_files(const std::string& path, int num_frames);

}  // namespace ndg
