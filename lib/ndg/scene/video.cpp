// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/video.h"

#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/scene/cut_away.h"
#include "ndg/scene/video_file.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// Of a body that stands still.
constexpr double still_rate = 25, still_seconds = 6;

std::vector<std::vector<SceneSurface>> shown_columns(const VideoMotion& motion, const VideoMoment& moment, Look look)
{
    const Template& body_template = *motion.body_template;
    const BodyGeometry& geometry = moment.geometry;
    if (look == Look::skin) return {{motion.skin(moment)}};
    if (look == Look::cut_away) return {cut_away_surfaces(body_template, geometry, moment.cut)};
    const SceneSurface shell = skin_shell(body_template, geometry);
    std::vector<SceneSurface> anatomy = anatomy_surfaces(body_template, geometry);
    anatomy.push_back(shell);
    if (look == Look::anatomy) return {anatomy};
    return {{motion.skin(moment)},
            {muscle_wrap_surface(body_template, geometry), shell},
            anatomy,
            {bone_wrap_surface(body_template, geometry), shell}};
}

/// Two circles about the axis through the middle of a box of points, as wide as they reach: seen alike from all sides.
Points cylinder_about(const Points& points)
{
    const Eigen::RowVector3d low = points.colwise().minCoeff(), high = points.colwise().maxCoeff();
    const double x = 0.5 * (low.x() + high.x()), z = 0.5 * (low.z() + high.z());
    double radius = 0;
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        radius = std::max(radius, std::hypot(points(i, 0) - x, points(i, 2) - z));
    constexpr int sides = 72;
    Points circles(2 * sides, 3);
    for (int k = 0; k < sides; ++k) {
        const double angle = 2 * M_PI * k / sides;
        circles.row(2 * k) << x + radius * std::cos(angle), low.y(), z + radius * std::sin(angle);
        circles.row(2 * k + 1) = circles.row(2 * k);
        circles(2 * k + 1, 1) = high.y();
    }
    return circles;
}

}  // namespace

void describe(OptionList& list, VideoSettings& settings)
{
    list.add("show", settings.look, "What --video shows of the body");
    list.add("video-width", settings.width, "Pixels of --video", 16, 8192);
    list.add("video-height", settings.height, "Pixels of --video", 16, 8192);
    list.add("seconds", settings.seconds,
             "How long --video is, its motion over and over; 0: every pose once, or 6 s round a body that stands still",
             0.0, 3600.0);
    list.add("video-rate", settings.frame_rate, "Frames a second of --video; 0: those of the motion", 0.0, 240.0);
    list.add("turn", settings.turn_degrees, "Degrees that the camera goes round the body during --video", -36000.0,
             36000.0);
    list.add("quality", settings.quality, "Of a lossy --video", 0, 100);
}

Video::Video(const VideoMotion& motion, const VideoSettings& settings) : motion_(motion), settings_(settings)
{
    const bool still = motion.num_poses == 1;
    frame_rate_ = settings.frame_rate > 0 ? settings.frame_rate : still ? still_rate : motion.pose_rate;
    double seconds = settings.seconds;
    if (seconds == 0)
        seconds = !still ? motion.num_poses / motion.pose_rate : settings.turn_degrees != 0 ? still_seconds : 0;
    const double frames = std::max(1.0, std::round(seconds * frame_rate_));
    require_input(motion.num_poses > 0 && frames <= 100000, "a video of {} poses and {} frames is not possible",
                  motion.num_poses, frames);
    num_frames_ = int(frames);

    std::vector<Points> skins;
    Eigen::Index num_points = 0;
    for (int pose = 0; pose < motion.num_poses; ++pose) {
        const BodyGeometry geometry = motion.moment(pose).geometry;
        if (pose == 0) heading_ = geometry.heading;
        skins.push_back(geometry.skin_vertices);
        num_points += skins.back().rows();
    }
    hull_.resize(num_points, 3);
    Eigen::Index row = 0;
    for (const Points& skin : skins) {
        hull_.middleRows(row, skin.rows()) = skin;
        row += skin.rows();
    }
    ground_height_ = hull_.col(1).minCoeff();
    if (settings.turn_degrees != 0) hull_ = cylinder_about(hull_);
}

Image Video::frame(int frame_idx) const
{
    const double time = frame_idx / frame_rate_;
    const int pose = motion_.num_poses == 1 ? 0 : int(std::floor(time * motion_.pose_rate + 1e-6)) % motion_.num_poses;
    const double turn = settings_.turn_degrees * M_PI / 180.0 * frame_idx / num_frames_;
    const VideoMoment moment = motion_.moment(pose);
    const auto columns = shown_columns(motion_, moment, settings_.look);

    RenderSettings render_with;
    render_with.samples_per_axis = settings_.samples_per_axis;
    render_with.occlusion_rays = settings_.occlusion_rays;
    render_with.ground_height = ground_height_;
    render_with.ground_rays = settings_.ground_rays;
    Image image(settings_.width, settings_.height);
    const int num_columns = int(columns.size());
    for (int c = 0; c < num_columns; ++c) {
        const int left = settings_.width * c / num_columns;
        render_with.width = settings_.width * (c + 1) / num_columns - left;
        render_with.height = settings_.height;
        const double aspect = double(render_with.width) / render_with.height;
        const Camera camera =
            frame_points(hull_, view_direction(motion_.view, heading_ + std::remainder(turn, 2 * M_PI)), aspect, 0.04);
        paste(image, render(columns[c], camera, render_with), left, 0);
    }
    return image;
}

void write_video(const std::string& path, const Video& video, int quality)
{
    const auto writer = video_writer(path, video.num_frames(), video.frame_rate(), quality);
    Progress progress("frames", std::size_t(video.num_frames()));
    for (int i = 0; i < video.num_frames(); ++i) {
        writer->add(video.frame(i));
        progress.advance();
    }
    writer->finish();
}

}  // namespace ndg
