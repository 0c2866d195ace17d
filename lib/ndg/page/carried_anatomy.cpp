// SPDX-License-Identifier: Apache-2.0
#include "ndg/page/carried_anatomy.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/geometry/point_tree.h"

#include <algorithm>
#include <numeric>

namespace ndg {
namespace {

using Motions = std::vector<Eigen::Isometry3d>;

Eigen::Isometry3d rigid_motion(const AnatomyPart& part, const Points& from, const Eigen::Ref<const Points>& to)
{
    const int count = part.vertex_end - part.vertex_begin;
    const Eigen::Matrix3Xd a = from.middleRows(part.vertex_begin, count).transpose();
    const Eigen::Matrix3Xd b = to.middleRows(part.vertex_begin, count).transpose();
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.matrix() = Eigen::umeyama(a, b, false);
    return motion;
}

/// Posed anatomy and what could carry it, in the frames looked at.
struct Observed {
    const Template& body_template;
    Points rest;
    std::vector<Points> anatomy, embedded;  ///< a frame each, N_a x 3
    std::vector<Motions> motions;           ///< frames x motions

    Eigen::Vector3d moved(std::size_t frame, int motion, int vertex) const
    {
        return motions[frame][motion] * rest.row(vertex).transpose();
    }
};

/// Largest distance of a vertex from where `share` of a motion would have it.
double largest_error(const Observed& observed, int vertex, int motion, double share)
{
    double largest = 0.0;
    for (std::size_t f = 0; f < observed.anatomy.size(); ++f) {
        Eigen::Vector3d point = (1.0 - share) * observed.embedded[f].row(vertex).transpose();
        if (share > 0.0) point += share * observed.moved(f, motion, vertex);
        largest = std::max(largest, (point - observed.anatomy[f].row(vertex).transpose()).norm());
    }
    return largest;
}

/// The share by least squares.
double fitted_share(const Observed& observed, int vertex, int motion)
{
    double along = 0.0, squared = 0.0;
    for (std::size_t f = 0; f < observed.anatomy.size(); ++f) {
        const Eigen::Vector3d embedded = observed.embedded[f].row(vertex).transpose();
        const Eigen::Vector3d way = observed.moved(f, motion, vertex) - embedded;
        along += way.dot(observed.anatomy[f].row(vertex).transpose() - embedded);
        squared += way.squaredNorm();
    }
    return squared > 0.0 ? std::clamp(along / squared, 0.0, 1.0) : 0.0;
}

/// Bones that move alike get one motion. Returns the motion of each part, -1 for muscles.
std::vector<int> group_bones(Observed& observed, std::vector<int>& motion_parts)
{
    constexpr double alike = 2e-5;  // m, at the part's vertices
    const std::vector<AnatomyPart>& parts = observed.body_template.anatomy_parts;
    std::vector<int> order(parts.size()), motion_of_part(parts.size(), -1);
    std::iota(order.begin(), order.end(), 0);
    const auto size = [&](int p) { return parts[p].vertex_end - parts[p].vertex_begin; };
    // The largest part of a group tells its motion best.
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size(a) > size(b); });
    for (const int p : order) {
        if (parts[p].layer != AnatomyLayer::bone || size(p) < 3) continue;
        const auto follows = [&](int motion) {
            for (std::size_t f = 0; f < observed.anatomy.size(); ++f)
                for (int v = parts[p].vertex_begin; v < parts[p].vertex_end; v += std::max(1, size(p) / 16))
                    if ((observed.moved(f, motion, v) - observed.anatomy[f].row(v).transpose()).norm() > alike)
                        return false;
            return true;
        };
        const int num_motions = int(motion_parts.size());
        int motion = 0;
        while (motion < num_motions && !follows(motion)) ++motion;
        if (motion == num_motions) {
            motion_parts.push_back(p);
            for (std::size_t f = 0; f < observed.anatomy.size(); ++f)
                observed.motions[f].push_back(rigid_motion(parts[p], observed.rest, observed.anatomy[f]));
        }
        motion_of_part[p] = motion;
    }
    if (motion_parts.empty()) {
        motion_parts.push_back(-1);
        for (Motions& motions : observed.motions) motions.push_back(Eigen::Isometry3d::Identity());
    }
    return motion_of_part;
}

/// Bones next to points at rest.
class BonesNearby {
public:
    BonesNearby(const Observed& observed, const std::vector<int>& motion_of_part)
    {
        for (std::size_t p = 0; p < motion_of_part.size(); ++p)
            if (motion_of_part[p] >= 0) {
                const AnatomyPart& part = observed.body_template.anatomy_parts[p];
                motions_.insert(motions_.end(), std::size_t(part.vertex_end - part.vertex_begin), motion_of_part[p]);
                begins_.push_back(part.vertex_begin);
                ends_.push_back(part.vertex_end);
            }
        if (motions_.empty()) return;
        Points points(Eigen::Index(motions_.size()), 3);
        Eigen::Index row = 0;
        for (std::size_t k = 0; k < begins_.size(); ++k) {
            points.middleRows(row, ends_[k] - begins_[k]) = observed.rest.middleRows(begins_[k], ends_[k] - begins_[k]);
            row += ends_[k] - begins_[k];
        }
        tree_ = std::make_unique<PointTree>(points);
    }
    /// The motions of the nearest bones, nearest first; at least one.
    std::vector<int> near(const Eigen::Vector3d& point) const
    {
        std::vector<int> motions;
        if (!tree_) return {0};
        for (const PointTree::Neighbour& neighbour : tree_->nearest(point, 40)) {
            const int motion = motions_[neighbour.idx];
            if (std::find(motions.begin(), motions.end(), motion) == motions.end()) motions.push_back(motion);
        }
        return motions;
    }

private:
    std::vector<int> motions_, begins_, ends_;
    std::unique_ptr<PointTree> tree_;
};

Observed observe(const std::vector<PosedBody>& frames, const std::vector<Points>& volumes,
                 const std::vector<Points>& anatomies)
{
    const Template& body_template = frames[0].body_template();
    Observed observed{body_template, anatomy_at_rest(body_template, frames[0].body()), anatomies, {}, {}};
    for (std::size_t f = 0; f < frames.size(); ++f) {
        observed.embedded.push_back(apply_embedding(body_template.embedding, volumes[f], frames[f].bone_interior()));
    }
    observed.motions.resize(frames.size());
    return observed;
}

}  // namespace

CarriedAnatomy find_carriers(const std::vector<PosedBody>& frames, const std::vector<Points>& volumes,
                             const std::vector<Points>& anatomies, double tolerance)
{
    require(!frames.empty() && frames.size() == volumes.size() && frames.size() == anatomies.size(),
            "{} poses, {} volumes and {} anatomies to find carriers in", frames.size(), volumes.size(),
            anatomies.size());
    const Template& body_template = frames[0].body_template();
    Observed observed = observe(frames, volumes, anatomies);
    CarriedAnatomy carried;
    const std::vector<int> motion_of_part = group_bones(observed, carried.motion_parts);
    const BonesNearby bones(observed, motion_of_part);
    const int num_vertices = int(observed.rest.rows());
    carried.motions.assign(num_vertices, 0);
    carried.shares.assign(num_vertices, 0.0);
    for (std::size_t p = 0; p < body_template.anatomy_parts.size(); ++p) {
        const AnatomyPart& part = body_template.anatomy_parts[p];
        for (int v = part.vertex_begin; v < part.vertex_end; ++v) {
            const bool embedded = body_template.embedding.elements[v] >= 0;
            std::vector<int> candidates = motion_of_part[p] >= 0 ? std::vector<int>{motion_of_part[p]}
                                                                 : bones.near(observed.rest.row(v).transpose());
            carried.motions[v] = candidates[0];
            double best = embedded && part.layer == AnatomyLayer::muscle ? largest_error(observed, v, 0, 0.0)
                                                                         : std::numeric_limits<double>::infinity();
            for (const int motion : candidates) {
                if (best <= tolerance) break;
                const double share =
                    embedded && part.layer == AnatomyLayer::muscle ? fitted_share(observed, v, motion) : 1.0;
                const double error = largest_error(observed, v, motion, share);
                if (error >= best) continue;
                best = error;
                carried.motions[v] = motion;
                carried.shares[v] = share;
            }
            // Bones that do not move as rigid bodies may still be carried by the volume.
            if (best > tolerance && embedded && largest_error(observed, v, 0, 0.0) <= tolerance) {
                carried.shares[v] = best = 0.0;
            }
            if (best > tolerance) carried.stored.push_back(v);
        }
    }
    carried.rest = std::move(observed.rest);
    return carried;
}

std::vector<Eigen::Isometry3d> rigid_motions(const CarriedAnatomy& carried, const Template& body_template,
                                             const Eigen::Ref<const Points>& anatomy)
{
    Motions motions;
    for (const int p : carried.motion_parts)
        motions.push_back(p < 0 ? Eigen::Isometry3d::Identity()
                                : rigid_motion(body_template.anatomy_parts[p], carried.rest, anatomy));
    return motions;
}

Points carried_points(const CarriedAnatomy& carried, const Embedding& embedding,
                      const Eigen::Ref<const Points>& volume_vertices,
                      const Eigen::Ref<const Points>& interior_vertices, const std::vector<Eigen::Isometry3d>& motions,
                      const Eigen::Ref<const Points>& anatomy)
{
    Points points = apply_embedding(embedding, volume_vertices, interior_vertices);
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const double share = carried.shares[v];
        if (share > 0.0)
            points.row(v) = (1.0 - share) * points.row(v) +
                            share * (motions[carried.motions[v]] * carried.rest.row(v).transpose()).transpose();
    }
    for (const int v : carried.stored) points.row(v) = anatomy.row(v);
    return points;
}

}  // namespace ndg
