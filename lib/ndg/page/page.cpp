// SPDX-License-Identifier: Apache-2.0
#include "ndg/page/page.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/page/carried_anatomy.h"
#include "ndg/page/page_blocks.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

constexpr double carrier_tolerance = 1e-4;  // m
constexpr int max_fit_frames = 24, frames_per_block = 16;
constexpr double weight_unit = 16384.0;  // weights are stored as whole numbers of its inverse, in [-2, 2)
constexpr double full_share = 65535.0;

using Values = std::vector<std::uint16_t>;

/// The points of a page: those that all methods share (bone wrap, bone interior, skin beyond the cuts), then those of
/// a method (muscle wrap, skin wrap, stored anatomy).
struct PointOrder {
    int num_wrap = 0, num_interior = 0, num_stored = 0;
    std::vector<int> outer_skin;   ///< skin vertices beyond the cuts
    std::vector<int> skin_points;  ///< N_s, the point of each skin vertex

    explicit PointOrder(const Template& body_template, int stored)
        : num_wrap(body_template.num_wrap_vertices()),
          num_interior(int(body_template.rest.interior_vertices.rows())),
          num_stored(stored),
          skin_points(std::size_t(body_template.rest.skin_vertices.rows()), -1)
    {
        for (std::size_t s = 0, w = 0; s < skin_points.size(); ++s) {
            const auto& wrap = body_template.wrap_to_skin;
            const auto found = std::find(wrap.begin(), wrap.end(), int(s));
            if (found != wrap.end())
                skin_points[s] = int(found - wrap.begin());
            else
                outer_skin.push_back(int(s)), skin_points[s] = -1 - int(w++);
        }
        for (int& point : skin_points)
            point = point >= 0 ? num_common() + num_wrap + point : num_wrap + num_interior - 1 - point;
    }
    int num_common() const { return num_wrap + num_interior + int(outer_skin.size()); }
    /// Of a vertex of [volume; interior], the numbering of the embedding.
    int of_embedded(int vertex) const
    {
        if (vertex < num_wrap) return vertex;
        if (vertex < 3 * num_wrap) return num_common() + vertex - num_wrap;
        return num_wrap + vertex - 3 * num_wrap;
    }
    int of_stored(int k) const { return num_common() + 2 * num_wrap + k; }

    Points common(const Points& volume, const Points& interior, const Points& skin) const
    {
        Points points(num_common(), 3);
        points << volume.topRows(num_wrap), interior, skin(outer_skin, Eigen::all);
        return points;
    }
    Points of_method(const Points& volume, const Points& anatomy, const std::vector<int>& stored) const
    {
        Points points(2 * num_wrap + num_stored, 3);
        points << volume.bottomRows(2 * num_wrap), anatomy(stored, Eigen::all);
        return points;
    }
};

/// The embedding as the page has it: weights rounded, then made to sum to one again as the viewer does.
Embedding rounded(const Embedding& embedding)
{
    Embedding result = embedding;
    for (Eigen::Index v = 0; v < result.weights.rows(); ++v) {
        result.weights.row(v) = (result.weights.row(v) * weight_unit).array().round() / weight_unit;
        const double sum = result.weights.row(v).sum();
        if (sum > 0.0) result.weights.row(v) /= sum;
    }
    return result;
}

/// Parts of one layer: what stands in the head of the page about each, and the tables of their vertices.
class LayerBlocks {
public:
    LayerBlocks(AnatomyLayer layer, const Template& body_template, const CarriedAnatomy& carried,
                const PointOrder& order, const Quantiser& quantiser, const Eigen::RowVector3d& rest_origin)
    {
        int vertex = 0, triangle = 0;
        for (const AnatomyPart& part : body_template.anatomy_parts) {
            if (part.layer != layer) continue;
            for (int v = part.vertex_begin; v < part.vertex_end; ++v) add_vertex(v, body_template, carried, order);
            for (int t = part.triangle_begin; t < part.triangle_end; ++t)
                for (int k = 0; k < 3; ++k)
                    triangles_.push_back(index_value(body_template.anatomy_triangles(t, k) - part.vertex_begin));
            quantiser.append(carried.rest.middleRows(part.vertex_begin, part.vertex_end - part.vertex_begin),
                             rest_origin, rest_);
            const int vertex_end = vertex + part.vertex_end - part.vertex_begin;
            const int triangle_end = triangle + part.triangle_end - part.triangle_begin;
            parts_.push_back({{"name", part.name},
                              {"side", to_name(part.side)},
                              {"fma", part.fma_id},
                              {"vertices", {vertex, vertex_end}},
                              {"triangles", {triangle, triangle_end}}});
            vertex = vertex_end;
            triangle = triangle_end;
        }
    }

    const nlohmann::json& parts() const { return parts_; }

    void write(PageWriter& writer, const std::string& layer) const
    {
        writer.block(layer + "_rest", rest_, 3);
        writer.block(layer + "_motions", motions_, 1);
        writer.block(layer + "_shares", shares_, 1);
        writer.block(layer + "_carriers", carriers_, 6);
        writer.block(layer + "_weights", weights_, 6);
        writer.block(layer + "_triangles", triangles_, 3);
    }

private:
    void add_vertex(int v, const Template& body_template, const CarriedAnatomy& carried, const PointOrder& order)
    {
        motions_.push_back(index_value(carried.motions[v]));
        const double share = carried.shares[v];
        shares_.push_back(std::uint16_t(std::lround(full_share * share)));
        const auto stored = std::lower_bound(carried.stored.begin(), carried.stored.end(), v);
        const bool is_stored = stored != carried.stored.end() && *stored == v;
        for (int k = 0; k < 6; ++k) {
            double weight = share < 1.0 ? body_template.embedding.weights(v, k) : 0.0;
            int point = weight != 0.0 || share < 1.0 ? order.of_embedded(body_template.embedding.vertices(v, k)) : 0;
            if (is_stored) {
                weight = k == 0 ? 1.0 : 0.0;
                point = k == 0 ? order.of_stored(int(stored - carried.stored.begin())) : 0;
            }
            require(std::abs(weight) < 2.0, "the embedding of anatomy vertex {} has a weight of {}", v, weight);
            carriers_.push_back(index_value(point));
            weights_.push_back(std::uint16_t(std::int16_t(std::lround(weight_unit * weight))));
        }
    }

    nlohmann::json parts_ = nlohmann::json::array();
    Values rest_, motions_, shares_, carriers_, weights_, triangles_;
};

std::vector<float> motion_values(const std::vector<Eigen::Isometry3d>& motions)
{
    std::vector<float> values;
    for (const Eigen::Isometry3d& motion : motions) {
        Eigen::Quaterniond q(motion.linear());
        if (q.w() < 0.0) q.coeffs() *= -1.0;
        for (int k = 0; k < 4; ++k) values.push_back(float(q.coeffs()[k]));
        for (int k = 0; k < 3; ++k) values.push_back(float(motion.translation()[k]));
    }
    return values;
}

Points anatomy_of(const PageMethod& method, const PosedBody& posed, const Points& rest, const Points& volume)
{
    return method.anatomy ? method.anatomy(posed, rest, volume) : posed.anatomy(rest, volume);
}

/// Writes the frames and measures what was kept.
class FrameBlocks {
public:
    FrameBlocks(const PageMotion& motion, const BodyPoser& poser, const CarriedAnatomy& carried,
                const PointOrder& order, const Quantiser& quantiser)
        : motion_(motion),
          poser_(poser),
          carried_(carried),
          order_(order),
          quantiser_(quantiser),
          embedding_(rounded(poser.body_template().embedding))
    {
    }

    void write(PageWriter& writer, int begin, int end)
    {
        Values common;
        std::vector<float> motions;
        std::vector<Values> methods(motion_.methods.size());
        for (int f = begin; f < end; ++f) add(f, common, motions, methods);
        writer.frames("common", begin, common, common.size() / std::size_t(end - begin), 3);
        writer.frames("motions", begin, motions, motions.size() / std::size_t(end - begin));
        for (std::size_t m = 0; m < methods.size(); ++m)
            writer.frames(fmt::format("method_{}", m), begin, methods[m], methods[m].size() / std::size_t(end - begin),
                          3);
    }

    double largest_error() const { return largest_error_; }

private:
    void add(int frame_idx, Values& common, std::vector<float>& motions, std::vector<Values>& methods)
    {
        const PosedBody posed = poser_.pose(*motion_.body, motion_.poses[frame_idx]);
        const Eigen::RowVector3d origin = frame_origin(posed);
        for (std::size_t m = 0; m < methods.size(); ++m) {
            const Points volume = motion_.methods[m].volume(frame_idx);
            const Points anatomy = anatomy_of(motion_.methods[m], posed, carried_.rest, volume);
            const std::vector<Eigen::Isometry3d> moved = rigid_motions(carried_, poser_.body_template(), anatomy);
            if (m == 0) {
                quantiser_.append(order_.common(volume, posed.bone_interior(), posed.display_skin(volume)), origin,
                                  common);
                const std::vector<float> values = motion_values(moved);
                motions.insert(motions.end(), values.begin(), values.end());
            }
            Values values;
            const Points of_method = order_.of_method(volume, anatomy, carried_.stored);
            quantiser_.append(of_method, origin, values);
            methods[m].insert(methods[m].end(), values.begin(), values.end());
            const Points kept = quantiser_.points(values, origin);
            Points kept_volume = volume, kept_anatomy = anatomy;
            kept_volume.bottomRows(2 * order_.num_wrap) = kept.topRows(2 * order_.num_wrap);
            for (int k = 0; k < order_.num_stored; ++k)
                kept_anatomy.row(carried_.stored[k]) = kept.row(2 * order_.num_wrap + k);
            const Points shown =
                carried_points(carried_, embedding_, kept_volume, posed.bone_interior(), moved, kept_anatomy);
            largest_error_ = std::max({largest_error_, (kept - of_method).rowwise().norm().maxCoeff(),
                                       anatomy.rows() > 0 ? (shown - anatomy).rowwise().norm().maxCoeff() : 0.0});
        }
    }

public:
    static Eigen::RowVector3d frame_origin(const PosedBody& posed)
    {
        return (posed.world_from_rest()[0] * posed.body().joint_positions.row(0).transpose()).transpose();
    }

private:
    const PageMotion& motion_;
    const BodyPoser& poser_;
    const CarriedAnatomy& carried_;
    const PointOrder& order_;
    const Quantiser& quantiser_;
    Embedding embedding_;
    double largest_error_ = 0.0;
};

/// Reach of the body about the origins of its frames, m, and those origins.
double reach(const BodyPoser& poser, const PageMotion& motion, std::vector<Eigen::RowVector3d>& origins)
{
    const Eigen::RowVector3d rest_origin = motion.body->joint_positions.row(0);
    double largest = (motion.body->skin_vertices.rowwise() - rest_origin).cwiseAbs().maxCoeff();
    for (std::size_t f = 0; f < motion.poses.size(); ++f) {
        const PosedBody posed = poser.pose(*motion.body, motion.poses[f]);
        origins.push_back(FrameBlocks::frame_origin(posed));
        largest = std::max(largest, (posed.skinned_skin().rowwise() - origins.back()).cwiseAbs().maxCoeff());
        for (const PageMethod& method : motion.methods) {
            const Points volume = method.volume(int(f));
            require(volume.rows() == poser.body_template().num_volume_vertices() && volume.allFinite(),
                    "{} gives {} volume vertices in frame {}, or some that are not finite; the template has {}",
                    method.name, volume.rows(), f, poser.body_template().num_volume_vertices());
            largest = std::max(largest, (volume.rowwise() - origins.back()).cwiseAbs().maxCoeff());
        }
    }
    return largest;
}

CarriedAnatomy carriers(const BodyPoser& poser, const PageMotion& motion)
{
    std::vector<PosedBody> frames;
    std::vector<Points> volumes, anatomies;
    const Points rest = anatomy_at_rest(poser.body_template(), *motion.body);
    const int num_frames = int(motion.poses.size()), num_methods = int(motion.methods.size());
    const int count = std::min(num_frames, std::max(2, max_fit_frames / num_methods));
    for (int k = 0; k < count; ++k) {
        const int f = count == 1 ? 0 : k * (num_frames - 1) / (count - 1);
        for (const PageMethod& method : motion.methods) {
            frames.push_back(poser.pose(*motion.body, motion.poses[f]));
            volumes.push_back(method.volume(f));
            anatomies.push_back(anatomy_of(method, frames.back(), rest, volumes.back()));
        }
    }
    return find_carriers(frames, volumes, anatomies, carrier_tolerance);
}

nlohmann::json flat(const Eigen::RowVector3d& point)
{
    return {point[0], point[1], point[2]};
}

}  // namespace

PageFigures write_page(const std::string& path, const BodyPoser& poser, const PageMotion& motion)
{
    require(motion.body && !motion.poses.empty() && !motion.methods.empty(),
            "{} would show no body, no frames or no method", path);
    const Template& body_template = poser.body_template();
    std::vector<Eigen::RowVector3d> origins;
    const Quantiser quantiser{1.02 * reach(poser, motion, origins)};
    const CarriedAnatomy carried = carriers(poser, motion);
    const PointOrder order(body_template, int(carried.stored.size()));
    const Body& body = *motion.body;
    const Eigen::RowVector3d rest_origin = body.joint_positions.row(0);
    const LayerBlocks bones(AnatomyLayer::bone, body_template, carried, order, quantiser, rest_origin);
    const LayerBlocks muscles(AnatomyLayer::muscle, body_template, carried, order, quantiser, rest_origin);

    nlohmann::json head = {{"title", motion.title},
                           {"credits", motion.credits},
                           {"frame_rate", motion.frame_rate},
                           {"num_frames", motion.poses.size()},
                           {"num_wrap", order.num_wrap},
                           {"num_interior", order.num_interior},
                           {"num_common", order.num_common()},
                           {"num_method", 2 * order.num_wrap + order.num_stored},
                           {"num_motions", carried.motion_parts.size()},
                           {"span", quantiser.span},
                           {"rest_origin", flat(rest_origin)},
                           {"weight_unit", weight_unit},
                           {"bones", bones.parts()},
                           {"muscles", muscles.parts()}};
    for (const PageMethod& method : motion.methods) head["methods"].push_back(method.name);
    for (const Eigen::RowVector3d& origin : origins) head["origins"].push_back(flat(origin));

    PageWriter writer(path, motion.title, motion.credits, head.dump());
    writer.block("wrap_triangles", triangle_values(body_template.wrap_triangles), 3);
    writer.block("skin_triangles", triangle_values(body_template.skin_triangles), 3);
    Values skin_points;
    for (const int point : order.skin_points) skin_points.push_back(index_value(point));
    writer.block("skin_points", skin_points, 1);
    Values rest;
    quantiser.append(order.common(body.volume_vertices, body.interior_vertices, body.skin_vertices), rest_origin, rest);
    quantiser.append(order.of_method(body.volume_vertices, carried.rest, carried.stored), rest_origin, rest);
    writer.block("rest", rest, 3);
    // The first frame and what it needs come before the other frames: it is seen while they arrive.
    FrameBlocks frames(motion, poser, carried, order, quantiser);
    frames.write(writer, 0, 1);
    bones.write(writer, "bone");
    muscles.write(writer, "muscle");
    for (int begin = 1; begin < int(motion.poses.size()); begin += frames_per_block)
        frames.write(writer, begin, std::min(begin + frames_per_block, int(motion.poses.size())));
    writer.commit();
    return {frames.largest_error(), int(carried.motion_parts.size()), order.num_stored, int(carried.rest.rows())};
}

}  // namespace ndg
