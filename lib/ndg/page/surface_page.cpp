// SPDX-License-Identifier: Apache-2.0
#include "ndg/page/surface_page.h"

#include "ndg/core/error.h"
#include "ndg/page/page_blocks.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {

namespace {

using Values = std::vector<std::uint16_t>;

constexpr int frames_per_block = 16;

Eigen::RowVector3d middle_of(const Points& points, int count)
{
    const auto body = points.topRows(count);
    return (body.colwise().minCoeff() + body.colwise().maxCoeff()) / 2;
}

nlohmann::json flat(const Eigen::RowVector3d& point)
{
    return {point[0], point[1], point[2]};
}

}  // namespace

double write_surface_page(const std::string& path, const SurfacePageMotion& motion)
{
    const int num_methods = static_cast<int>(motion.methods.size());
    require(motion.num_frames > 0 && num_methods > 0, "{} would show no frames or no method", path);
    const Eigen::Index count = motion.rest.rows();
    require(motion.num_body_points > 0 && motion.num_body_points <= count, "{} of {} points are the body",
            motion.num_body_points, count);
    std::vector<Eigen::RowVector3d> origins;
    const Eigen::RowVector3d rest_origin = middle_of(motion.rest, motion.num_body_points);
    double reach = (motion.rest.rowwise() - rest_origin).cwiseAbs().maxCoeff();
    for (int f = 0; f < motion.num_frames; ++f) {
        for (int m = 0; m < num_methods; ++m) {
            const Points points = motion.points(m, f);
            require(points.rows() == count && points.allFinite(),
                    "{} gives {} points in frame {}, or some that are not finite; at rest there are {}",
                    motion.methods[static_cast<std::size_t>(m)], points.rows(), f, count);
            if (m == 0) origins.push_back(middle_of(points, motion.num_body_points));
            reach = std::max(reach, (points.rowwise() - origins.back()).cwiseAbs().maxCoeff());
        }
    }
    const Quantiser quantiser{1.02 * reach};
    // The viewer wants points that all methods share, and a motion: one of each that nothing uses.
    nlohmann::json head = {{"title", motion.title},
                           {"credits", motion.credits},
                           {"frame_rate", motion.frame_rate},
                           {"num_frames", motion.num_frames},
                           {"num_wrap", 0},
                           {"num_interior", 0},
                           {"num_common", 1},
                           {"num_method", count},
                           {"num_motions", 1},
                           {"num_body_triangles", motion.num_body_triangles},
                           {"span", quantiser.span},
                           {"rest_origin", flat(rest_origin)},
                           {"weight_unit", 1},
                           {"bones", nlohmann::json::array()},
                           {"muscles", nlohmann::json::array()},
                           {"methods", motion.methods},
                           {"opening", {{"layers", {{"skin", {{"shown", true}, {"opacity", 1.0}}}}}}}};
    for (const Eigen::RowVector3d& origin : origins) head["origins"].push_back(flat(origin));

    PageWriter writer(path, motion.title, motion.credits, head.dump());
    writer.block("wrap_triangles", {}, 3);
    writer.block("skin_triangles", triangle_values(motion.triangles), 3);
    Values skin_points;
    for (Eigen::Index i = 0; i < count; ++i) skin_points.push_back(index_value(1 + i));
    writer.block("skin_points", skin_points, 1);
    const auto common = [&](const Eigen::RowVector3d& origin, Values& values) {
        quantiser.append(Points(origin), origin, values);
    };
    Values rest;
    common(rest_origin, rest);
    quantiser.append(motion.rest, rest_origin, rest);
    writer.block("rest", rest, 3);
    double largest_error = 0;
    for (int begin = 0; begin < motion.num_frames;) {
        const int end = begin == 0 ? 1 : std::min(begin + frames_per_block, motion.num_frames);
        Values shared;
        std::vector<float> motions;
        for (int f = begin; f < end; ++f) {
            common(origins[static_cast<std::size_t>(f)], shared);
            motions.insert(motions.end(), {0, 0, 0, 1, 0, 0, 0});
        }
        writer.frames("common", begin, shared, 3, 3);
        writer.frames("motions", begin, motions, 7);
        for (int m = 0; m < num_methods; ++m) {
            Values values;
            for (int f = begin; f < end; ++f) {
                const Eigen::RowVector3d& origin = origins[static_cast<std::size_t>(f)];
                const Points points = motion.points(m, f);
                Values frame;
                quantiser.append(points, origin, frame);
                largest_error =
                    std::max(largest_error, (quantiser.points(frame, origin) - points).rowwise().norm().maxCoeff());
                values.insert(values.end(), frame.begin(), frame.end());
            }
            writer.frames(fmt::format("method_{}", m), begin, values, static_cast<std::size_t>(3 * count), 3);
        }
        begin = end;
    }
    writer.commit();
    return largest_error;
}

}  // namespace ndg
