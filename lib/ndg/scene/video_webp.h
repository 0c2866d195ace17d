// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/video_file.h"

namespace ndg {

/// Lossy, played over and over. A frame that differs little from the one before costs little.
std::unique_ptr<VideoWriter> webp_writer(const std::string& path, double frame_rate, int quality);

}  // namespace ndg
