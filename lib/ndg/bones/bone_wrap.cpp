// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_wrap.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

/// Triangles of all bones of one segment and the box around them.
struct SegmentSurface {
    std::vector<Eigen::RowVector3i> triangles;
    Eigen::AlignedBox3d box;
    std::unique_ptr<TriangleTree> tree;
};

std::vector<SegmentSurface> segment_surfaces(const BoneList& list, const Template& body_template,
                                             const Eigen::Ref<const Points>& anatomy_rest)
{
    std::vector<SegmentSurface> surfaces(list.num_segments);
    for (const BoneList::Bone& bone : list.bones) {
        SegmentSurface& surface = surfaces[bone.segment];
        for (int t = bone.triangle_begin; t < bone.triangle_end; ++t)
            surface.triangles.push_back(body_template.anatomy_triangles.row(t));
        for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) surface.box.extend(anatomy_rest.row(v).transpose());
    }
    for (SegmentSurface& surface : surfaces) {
        Triangles triangles(Eigen::Index(surface.triangles.size()), 3);
        for (std::size_t t = 0; t < surface.triangles.size(); ++t)
            triangles.row(Eigen::Index(t)) = surface.triangles[t];
        surface.tree = std::make_unique<TriangleTree>(anatomy_rest, triangles);
    }
    return surfaces;
}

}  // namespace

NearBones near_bones(const BoneList& list, const Template& body_template, const Eigen::Ref<const Points>& anatomy_rest,
                     const Eigen::Ref<const Points>& points, double width)
{
    require(list.num_segments > 0, "no bones to follow");
    const std::vector<SegmentSurface> surfaces = segment_surfaces(list, body_template, anatomy_rest);
    std::vector<std::vector<std::pair<int, double>>> influences(points.rows());
    NearBones result;
    result.distances.resize(points.rows());
#pragma omp parallel for schedule(dynamic, 64)
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const Eigen::Vector3d point = points.row(i).transpose();
        std::vector<std::pair<double, int>> boxes;
        for (int s = 0; s < list.num_segments; ++s) boxes.emplace_back(surfaces[s].box.exteriorDistance(point), s);
        std::sort(boxes.begin(), boxes.end());
        double nearest = std::numeric_limits<double>::infinity();
        std::vector<std::pair<int, double>>& found = influences[i];
        for (const auto& [box_distance, s] : boxes) {
            if (box_distance > width + 2.0 * nearest) break;
            const double distance = surfaces[s].tree->closest(point).distance;
            nearest = std::min(nearest, distance);
            found.emplace_back(s, distance);
        }
        double sum = 0.0;
        for (auto& [s, value] : found) {
            const double t = std::min((value - nearest) / (width + nearest), 1.0);
            value = (1.0 - t * t) * (1.0 - t * t);
            sum += value;
        }
        for (auto& [s, value] : found) value /= sum;
        result.distances[i] = nearest;
    }
    BoneWeights& weights = result.weights;
    weights.begins.push_back(0);
    for (const auto& found : influences) {
        for (const auto& [s, value] : found) {
            if (value <= 0.0) continue;
            weights.segments.push_back(s);
            weights.weights.push_back(value);
        }
        weights.begins.push_back(int(weights.segments.size()));
    }
    return result;
}

BoneWeights smoothed_weights(const BoneWeights& weights, const Eigen::Ref<const Points>& vertices,
                             const Eigen::Ref<const Triangles>& triangles, double spread)
{
    const std::vector<MeshEdge> edges = mesh_edges(triangles, int(vertices.rows()));
    double squared_length = 0.0;
    for (const MeshEdge& edge : edges)
        squared_length += (vertices.row(edge.v0) - vertices.row(edge.v1)).squaredNorm() / double(edges.size());
    // Diffusion over the graph of the edges: a random walk of as many edges has this spread along each direction of the
    // surface. A few implicit steps make its kernel nearly a normal distribution.
    constexpr int steps = 4;
    const double walked = 2.0 * spread * spread / squared_length / steps;
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::VectorXd degrees = Eigen::VectorXd::Zero(vertices.rows());
    for (const MeshEdge& edge : edges) {
        for (const int v : {edge.v0, edge.v1}) degrees[v] += 1.0;
        entries.emplace_back(std::max(edge.v0, edge.v1), std::min(edge.v0, edge.v1), -walked);
    }
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        degrees[v] = std::max(degrees[v], 1.0);
        entries.emplace_back(v, v, (1.0 + walked) * degrees[v]);
    }
    Eigen::SparseMatrix<double> matrix(vertices.rows(), vertices.rows());
    matrix.setFromTriplets(entries.begin(), entries.end());
    SparseCholesky solver;
    solver.analyze(matrix);
    require(solver.factorize(matrix), "the diffusion of the weights of a wrap is not positive definite");

    const int num_segments = 1 + *std::max_element(weights.segments.begin(), weights.segments.end());
    Eigen::MatrixXd of_segments = Eigen::MatrixXd::Zero(vertices.rows(), num_segments);
    for (Eigen::Index v = 0; v < weights.size(); ++v)
        for (int k = weights.begins[v]; k < weights.begins[v + 1]; ++k)
            of_segments(v, weights.segments[k]) = weights.weights[k];
    for (int step = 0; step < steps; ++step) of_segments = solver.solve(degrees.asDiagonal() * of_segments);

    constexpr double least = 0.02;
    BoneWeights result;
    result.begins.push_back(0);
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        double sum = 0.0;
        for (int s = 0; s < num_segments; ++s) sum += of_segments(v, s) >= least ? of_segments(v, s) : 0.0;
        for (int s = 0; s < num_segments; ++s) {
            if (of_segments(v, s) < least) continue;
            result.segments.push_back(s);
            result.weights.push_back(of_segments(v, s) / sum);
        }
        result.begins.push_back(int(result.segments.size()));
    }
    return result;
}

Points dual_quaternion_blending(const Eigen::Ref<const Points>& rest, const BoneWeights& weights,
                                const std::vector<Eigen::Isometry3d>& motions)
{
    require(weights.size() == rest.rows(), "{} points were given weights of {}", rest.rows(), weights.size());
    using Dual = Eigen::Matrix<double, 8, 1>;  // real part x, y, z, w; dual part
    std::vector<Dual> duals;
    for (const Eigen::Isometry3d& motion : motions) {
        const Eigen::Quaterniond real = Eigen::Quaterniond(motion.linear()).normalized();
        const Eigen::Vector3d t = motion.translation();
        Dual dual;
        dual.head<4>() = real.coeffs();
        dual.tail<4>() = 0.5 * (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * real).coeffs();
        duals.push_back(dual);
    }
    Points posed(rest.rows(), 3);
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < rest.rows(); ++i) {
        const int begin = weights.begins[i], end = weights.begins[i + 1];
        const auto heaviest = std::max_element(weights.weights.begin() + begin, weights.weights.begin() + end);
        const auto reference = duals[weights.segments[heaviest - weights.weights.begin()]].head<4>();
        Dual sum = Dual::Zero();
        for (int k = begin; k < end; ++k) {
            const Dual& dual = duals[weights.segments[k]];
            // q and -q are the same motion.
            sum += (dual.head<4>().dot(reference) < 0.0 ? -weights.weights[k] : weights.weights[k]) * dual;
        }
        sum /= sum.head<4>().norm();
        const Eigen::Vector3d real = sum.head<3>(), dual = sum.segment<3>(4), x = rest.row(i).transpose();
        const Eigen::Vector3d turned = x + 2.0 * real.cross(real.cross(x) + sum[3] * x);
        posed.row(i) = (turned + 2.0 * (sum[3] * dual - sum[7] * real + real.cross(dual))).transpose();
    }
    return posed;
}

}  // namespace ndg
