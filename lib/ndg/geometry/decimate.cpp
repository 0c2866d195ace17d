// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/decimate.h"

#include "ndg/geometry/dynamic_mesh.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <tuple>

namespace ndg {
namespace {

constexpr double least_turn_cosine = 0.3;  ///< between the normals of a triangle before and after
constexpr double least_angle = 0.2;        ///< radians; narrower triangles are made only where there were some before
constexpr double feature_weight = 10.0;    ///< of a feature's own quadrics against those of the triangles

/// Squared distances to planes (Garland and Heckbert 1997).
struct Quadric {
    Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    double c = 0.0;

    void add_plane(const Eigen::Vector3d& normal, const Eigen::Vector3d& point, double weight)
    {
        const double offset = -normal.dot(point);
        a += weight * normal * normal.transpose();
        b += weight * offset * normal;
        c += weight * offset * offset;
    }
    void add(const Quadric& other)
    {
        a += other.a;
        b += other.b;
        c += other.c;
    }
    double at(const Eigen::Vector3d& point) const { return point.dot(a * point) + 2.0 * b.dot(point) + c; }
};

class Decimation {
public:
    Decimation(const TriangleMesh& source, const std::vector<int>& labels, const std::vector<char>& removable)
        : mesh_(source.vertices, source.triangles, labels),
          quadrics_(static_cast<std::size_t>(source.vertices.rows())),
          version_(quadrics_.size(), 0),
          fixed_(quadrics_.size(), 0)
    {
        for (std::size_t v = 0; v < removable.size(); ++v) fixed_[v] = removable[v] != 0 ? 0 : 1;
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            const auto& corners = mesh_.triangle(t);
            const double area = 0.5 * (mesh_.position(corners[1]) - mesh_.position(corners[0]))
                                          .cross(mesh_.position(corners[2]) - mesh_.position(corners[0]))
                                          .norm();
            for (const int v : corners) {
                quadrics_[index(v)].add_plane(mesh_.normal(t), mesh_.position(v), area);
                if (mesh_.label(t) == 0) fixed_[index(v)] = 1;
            }
            remaining_ += mesh_.label(t) > 0 ? 1 : 0;
        }
        for (const auto& [a, b] : mesh_.edges()) {
            if (!mesh_.is_feature(a, b)) continue;
            // The two planes through the edge that hold it in place.
            const Eigen::Vector3d along = mesh_.position(b) - mesh_.position(a);
            if (!(along.norm() > 0.0)) continue;
            const Eigen::Vector3d u = along.normalized().unitOrthogonal(), w = along.normalized().cross(u);
            for (const int v : {a, b})
                for (const auto& normal : {u, w})
                    quadrics_[index(v)].add_plane(normal, mesh_.position(a), feature_weight * along.squaredNorm());
        }
    }

    LabelledMesh run(std::size_t target)
    {
        for (const auto& [a, b] : mesh_.edges()) propose(a, b);
        while (remaining_ > target && !queue_.empty()) {
            const auto [cost, removed, kept, version] = queue_.top();
            queue_.pop();
            if (version != version_[index(removed)] + version_[index(kept)]) continue;
            if (mesh_.triangles_of(removed).empty() || mesh_.triangles_of(kept).empty()) continue;
            if (!mesh_.can_collapse(removed, kept) || !sound(removed, kept)) continue;
            for (const int t : mesh_.edge_triangles(removed, kept)) remaining_ -= t >= 0 ? 1 : 0;
            mesh_.collapse(removed, kept);
            quadrics_[index(kept)].add(quadrics_[index(removed)]);
            ++version_[index(kept)];
            for (const int other : mesh_.neighbours(kept)) propose(kept, other);
        }
        LabelledMesh result;
        mesh_.compact(result.mesh.vertices, result.mesh.triangles, result.triangle_labels);
        return result;
    }

private:
    using Candidate = std::tuple<double, int, int, int>;  ///< cost, removed, kept, sum of versions

    static std::size_t index(int v) { return static_cast<std::size_t>(v); }

    void propose(int a, int b)
    {
        const int version = version_[index(a)] + version_[index(b)];
        for (const auto& [removed, kept] : {std::pair{a, b}, std::pair{b, a}}) {
            if (fixed_[index(removed)] != 0) continue;
            const double cost =
                quadrics_[index(removed)].at(mesh_.position(kept)) + quadrics_[index(kept)].at(mesh_.position(kept));
            queue_.push({cost, removed, kept, version});
        }
    }

    bool sound(int removed, int kept) const
    {
        double angle_before = M_PI, angle_after = M_PI;
        for (const int t : mesh_.triangles_of(removed)) {
            auto corners = mesh_.triangle(t);
            const auto angle = [&] {
                return DynamicMesh::min_angle(mesh_.position(corners[0]), mesh_.position(corners[1]),
                                              mesh_.position(corners[2]));
            };
            angle_before = std::min(angle_before, angle());
            if (std::find(corners.begin(), corners.end(), kept) != corners.end()) continue;
            std::replace(corners.begin(), corners.end(), removed, kept);
            angle_after = std::min(angle_after, angle());
            const Eigen::Vector3d normal = (mesh_.position(corners[1]) - mesh_.position(corners[0]))
                                               .cross(mesh_.position(corners[2]) - mesh_.position(corners[0]));
            if (normal.dot(mesh_.normal(t)) < least_turn_cosine * normal.norm()) return false;
        }
        return angle_after >= std::min(least_angle, angle_before);
    }

    DynamicMesh mesh_;
    std::vector<Quadric> quadrics_;
    std::vector<int> version_;
    std::vector<char> fixed_;
    std::size_t remaining_ = 0;
    std::priority_queue<Candidate, std::vector<Candidate>, std::greater<Candidate>> queue_;
};

}  // namespace

LabelledMesh decimate_labelled(const TriangleMesh& mesh, const std::vector<int>& triangle_labels,
                               std::size_t target_triangles, const std::vector<char>& removable)
{
    return Decimation(mesh, triangle_labels, removable).run(target_triangles);
}

}  // namespace ndg
