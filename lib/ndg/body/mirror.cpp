// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/mirror.h"

#include "ndg/core/error.h"
#include "ndg/geometry/point_tree.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

namespace ndg {
namespace {

constexpr int max_seeds = 50;
constexpr double max_skin_residual = 0.01, max_weight_residual = 0.5;

Eigen::RowVector3d mirrored_point(const Eigen::RowVector3d& point)
{
    return {-point.x(), point.y(), point.z()};
}

std::vector<int> opposite_joints(const Skeleton& skeleton)
{
    std::vector<int> joints;
    for (const std::string& name : skeleton.joint_names) {
        std::string other = name;
        if (name.rfind("left_", 0) == 0) other = "right_" + name.substr(5);
        if (name.rfind("right_", 0) == 0) other = "left_" + name.substr(6);
        const auto found = std::find(skeleton.joint_names.begin(), skeleton.joint_names.end(), other);
        require_input(found != skeleton.joint_names.end(), "the skeleton has a joint {} but no {}", name, other);
        joints.push_back(static_cast<int>(found - skeleton.joint_names.begin()));
    }
    return joints;
}

/// Vertices and triangles opposite each other, -1 where none was reached.
struct Matching {
    std::vector<int> vertices, triangles;
    int num_triangles = 0;

    bool is_mirror() const
    {
        for (std::size_t v = 0; v < vertices.size(); ++v)
            if (vertices[v] < 0 || vertices[vertices[v]] != static_cast<int>(v)) return false;
        return num_triangles == static_cast<int>(triangles.size());
    }
};

/// Walks over a connected surface and its mirror image at once. An edge is named by the corner it starts at, 3 triangle
/// + place; a mirror turns the order of corners round, so edge a-b lies opposite an edge b'-a'.
class SurfaceWalk {
public:
    /// Keeps references.
    SurfaceWalk(const Points& vertices, const Triangles& triangles) : vertices_(vertices), triangles_(triangles)
    {
        for (int t = 0; t < triangles.rows(); ++t)
            for (int k = 0; k < 3; ++k) corner_of_edge_[{triangles(t, k), triangles(t, (k + 1) % 3)}] = 3 * t + k;
    }

    /// Edges that lie best on edges when mirrored, best first, and those edges.
    std::vector<std::pair<int, int>> seeds() const
    {
        const PointTree tree(vertices_);
        std::vector<PointTree::Neighbour> nearest;
        for (Eigen::Index v = 0; v < vertices_.rows(); ++v)
            nearest.push_back(tree.nearest(mirrored_point(vertices_.row(v)).transpose()));
        std::vector<std::pair<double, std::pair<int, int>>> found;
        for (const auto& [edge, corner] : corner_of_edge_) {
            const PointTree::Neighbour &a = nearest[edge.first], &b = nearest[edge.second];
            const auto opposite = corner_of_edge_.find({b.idx, a.idx});
            if (opposite == corner_of_edge_.end()) continue;
            found.push_back({std::max(a.squared_distance, b.squared_distance), {corner, opposite->second}});
        }
        std::sort(found.begin(), found.end());
        std::vector<std::pair<int, int>> best;
        for (std::size_t i = 0; i < std::min<std::size_t>(found.size(), max_seeds); ++i)
            best.push_back(found[i].second);
        return best;
    }

    /// What follows when one edge lies opposite another, up to the first contradiction.
    Matching from(int edge, int opposite_edge) const
    {
        Matching matching;
        matching.vertices.assign(vertices_.rows(), -1);
        matching.triangles.assign(triangles_.rows(), -1);
        std::vector<std::pair<int, int>> open = {{edge, opposite_edge}};
        while (!open.empty()) {
            const auto [corner, opposite] = open.back();
            open.pop_back();
            int& matched = matching.triangles[corner / 3];
            if (matched == opposite / 3) continue;
            if (matched >= 0) return matching;
            for (const auto& [own, other] : {std::pair(0, 1), std::pair(1, 0), std::pair(2, 2)}) {
                int& vertex = matching.vertices[vertex_at(corner, own)];
                const int image = vertex_at(opposite, other);
                if (vertex >= 0 && vertex != image) return matching;
                vertex = image;
            }
            matched = opposite / 3;
            ++matching.num_triangles;
            for (const auto& [own, other] : {std::pair(0, 0), std::pair(1, 2), std::pair(2, 1)}) {
                const int next = across(corner, own), next_opposite = across(opposite, other);
                if ((next < 0) != (next_opposite < 0)) return matching;
                if (next >= 0) open.emplace_back(next, next_opposite);
            }
        }
        return matching;
    }

private:
    int vertex_at(int corner, int step) const { return triangles_(corner / 3, (corner % 3 + step) % 3); }
    /// Edge `step` places on, as the triangle on its other side has it; -1 at a border.
    int across(int corner, int step) const
    {
        const auto found = corner_of_edge_.find({vertex_at(corner, step + 1), vertex_at(corner, step)});
        return found == corner_of_edge_.end() ? -1 : found->second;
    }

    const Points& vertices_;
    const Triangles& triangles_;
    std::map<std::pair<int, int>, int> corner_of_edge_;
};

Matching match_wrap(const Template& body_template)
{
    const Triangles& triangles = body_template.wrap_triangles;
    const Points skin = body_template.rest.volume_vertices.bottomRows(body_template.num_wrap_vertices());
    const SurfaceWalk walk(skin, triangles);
    int most = 0;
    for (const auto& [edge, opposite] : walk.seeds()) {
        const Matching matching = walk.from(edge, opposite);
        if (matching.is_mirror()) return matching;
        most = std::max(most, matching.num_triangles);
    }
    throw InputError(fmt::format(
        "the template has no mirror image of itself: at best {} of the {} triangles of a wrap have one opposite", most,
        triangles.rows()));
}

}  // namespace

Points TemplateMirror::mirrored(const Eigen::Ref<const Points>& volume_vertices) const
{
    require(volume_vertices.rows() == static_cast<Eigen::Index>(vertices.size()),
            "{} volume vertices, the template has {}", volume_vertices.rows(), vertices.size());
    Points image(volume_vertices.rows(), 3);
    for (Eigen::Index v = 0; v < image.rows(); ++v) image.row(vertices[v]) = mirrored_point(volume_vertices.row(v));
    return image;
}

Pose TemplateMirror::mirrored(const Pose& pose) const
{
    require(pose.parent_from_joint.size() == joints.size(), "a pose of {} joints, the template has {}",
            pose.parent_from_joint.size(), joints.size());
    const Eigen::DiagonalMatrix<double, 3> reflection(-1, 1, 1);
    Pose image = pose;
    for (std::size_t j = 0; j < joints.size(); ++j)
        image.parent_from_joint[joints[j]] = reflection * pose.parent_from_joint[j] * reflection;
    image.root_translation.x() *= -1;
    return image;
}

TemplateMirror find_mirror(const Template& body_template)
{
    TemplateMirror mirror;
    mirror.joints = opposite_joints(body_template.skeleton);
    const Matching matching = match_wrap(body_template);
    const int num_wrap = body_template.num_wrap_vertices();
    for (int wrap = 0; wrap < 3; ++wrap)
        for (int v = 0; v < num_wrap; ++v) mirror.vertices.push_back(wrap * num_wrap + matching.vertices[v]);
    const int num_triangles = static_cast<int>(matching.triangles.size());
    for (int layer = 0; layer < 2; ++layer)
        for (int t = 0; t < num_triangles; ++t) mirror.prisms.push_back(layer * num_triangles + matching.triangles[t]);

    const Points& rest = body_template.rest.volume_vertices;
    const Eigen::VectorXd distances = (mirror.mirrored(rest) - rest).rowwise().norm();
    mirror.skin_residual = distances.tail(num_wrap).maxCoeff();
    mirror.wrap_residual = distances.head(2 * num_wrap).maxCoeff();
    const RowMatrix weights = dense_weights(select_weights(body_template.skin_weights, body_template.wrap_to_skin),
                                            body_template.skeleton.num_joints());
    for (int v = 0; v < num_wrap; ++v)
        for (Eigen::Index j = 0; j < weights.cols(); ++j) {
            const double difference = std::abs(weights(v, j) - weights(matching.vertices[v], mirror.joints[j]));
            mirror.weight_residual = std::max(mirror.weight_residual, difference);
        }
    require_input(mirror.skin_residual <= max_skin_residual && mirror.weight_residual <= max_weight_residual,
                  "the template has no mirror image of itself: that of its skin lies up to {:.1f} mm off and skinning "
                  "weights differ by up to {:.2f}, where {:.0f} mm and {:.1f} are allowed",
                  1e3 * mirror.skin_residual, mirror.weight_residual, 1e3 * max_skin_residual, max_weight_residual);
    return mirror;
}

}  // namespace ndg
