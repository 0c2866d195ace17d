// SPDX-License-Identifier: Apache-2.0
// Pictures in motion: a body that moves, a camera that goes round it, or both.
#pragma once

#include "ndg/core/enum_names.h"
#include "ndg/core/options.h"
#include "ndg/scene/body_surfaces.h"
#include "ndg/scene/camera.h"
#include "ndg/scene/image.h"
#include "ndg/scene/render.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// What a frame shows of a body. layers: skin, muscle wrap, bone wrap, muscles and bones side by side in one pose, as
/// Figure 1 of the paper. anatomy: muscles and bones inside a faint skin. cut_away: without skin and fat in front of a
/// plane.
enum class Look { skin, layers, anatomy, cut_away };
template <>
inline constexpr EnumName<Look> enum_table<Look>[] = {
    {Look::skin, "skin"}, {Look::layers, "layers"}, {Look::anatomy, "anatomy"}, {Look::cut_away, "cut-away"}};

struct VideoSettings {
    Look look = Look::layers;
    int width = 1280, height = 720;  ///< pixels
    double seconds = 0;              ///< 0: every pose once, or six seconds round a body that stands still
    double frame_rate = 0;           ///< Hz; 0: that of the motion, 25 for a body that stands still
    double turn_degrees = 0;         ///< the camera's way round the body during the video
    int quality = 80;                ///< of lossy pictures, 0 to 100
    int samples_per_axis = 2;
    int occlusion_rays = 16, ground_rays = 8;  ///< less than in still pictures: nobody looks at one frame for long
};
void describe(OptionList& list, VideoSettings& settings);

/// A body at one moment.
struct VideoMoment {
    BodyGeometry geometry;
    ClipPlane cut;  ///< for Look::cut_away
};

/// What moves. `poses` are its moments at `pose_rate` Hz, played over and over.
struct VideoMotion {
    const Template* body_template = nullptr;
    int num_poses = 1;
    double pose_rate = 25;
    std::function<VideoMoment(int)> moment;
    /// The skin of a moment: plain, or coloured by what it suffers.
    std::function<SceneSurface(const VideoMoment&)> skin;
    View view = View::front;
};

/// The frames of a video, framed alike: the body stays inside the picture in all of them. A frame is what it is
/// whatever was asked for before.
class Video {
public:
    /// Asks for every moment once. Throws InputError for a video without a frame or with more than 100 000.
    Video(const VideoMotion& motion, const VideoSettings& settings);
    int num_frames() const { return num_frames_; }
    double frame_rate() const { return frame_rate_; }
    /// Frame num_frames() is the one that follows the last: the first again where the camera went round once and the
    /// motion ends as it began.
    Image frame(int frame_idx) const;

private:
    VideoMotion motion_;
    VideoSettings settings_;
    int num_frames_ = 1;
    double frame_rate_ = 25, heading_ = 0, ground_height_ = 0;
    Points hull_;  ///< what cameras frame
};

/// All frames, by video_writer.
void write_video(const std::string& path, const Video& video, int quality);

}  // namespace ndg
