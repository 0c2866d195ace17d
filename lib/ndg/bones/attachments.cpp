// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/attachments.h"

#include <algorithm>

namespace ndg {

namespace {

/// 1 at bones and up to `full`, 0 from `none` on.
double share_of_bones(double distance)
{
    constexpr double full = 0.003, none = 0.012;  // m
    const double t = std::clamp((distance - full) / (none - full), 0.0, 1.0);
    return 1.0 - t * t * (3.0 - 2.0 * t);
}

}  // namespace

Attachments::Attachments(const BoneList& list, const Template& body_template)
{
    std::vector<int> candidates;
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != AnatomyLayer::muscle) continue;
        for (int v = part.vertex_begin; v < part.vertex_end; ++v)
            if (body_template.embedding.elements[v] >= 0) candidates.push_back(v);
    }
    const auto rows_of = [&](const std::vector<int>& vertices) {
        Points points(Eigen::Index(vertices.size()), 3);
        for (std::size_t i = 0; i < vertices.size(); ++i)
            points.row(Eigen::Index(i)) = body_template.anatomy_vertices.row(vertices[i]);
        return points;
    };
    constexpr double width = 0.003;  // narrow: a tendon belongs to the bone it lies at, not to the next
    const Points& rest = body_template.anatomy_vertices;
    const NearBones near = near_bones(list, body_template, rest, rows_of(candidates), width);
    BoneWeights& weights = weights_;
    weights.begins.push_back(0);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        const double share = share_of_bones(near.distances[Eigen::Index(i)]);
        if (share <= 0.0) continue;
        vertices_.push_back(candidates[i]);
        shares_.push_back(share);
        for (int k = near.weights.begins[i]; k < near.weights.begins[i + 1]; ++k) {
            weights.segments.push_back(near.weights.segments[k]);
            weights.weights.push_back(near.weights.weights[k]);
        }
        weights.begins.push_back(int(weights.segments.size()));
    }
}

void Attachments::hold(const Eigen::Ref<const Points>& anatomy_rest, const std::vector<Eigen::Isometry3d>& segments,
                       Points& anatomy) const
{
    Points rest(Eigen::Index(vertices_.size()), 3);
    for (std::size_t i = 0; i < vertices_.size(); ++i) rest.row(Eigen::Index(i)) = anatomy_rest.row(vertices_[i]);
    const Points held = dual_quaternion_blending(rest, weights_, segments);
    for (std::size_t i = 0; i < vertices_.size(); ++i)
        anatomy.row(vertices_[i]) += shares_[i] * (held.row(Eigen::Index(i)) - anatomy.row(vertices_[i]));
}

}  // namespace ndg
