// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_wrap.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/solver/sparse_cholesky.h"

#include <algorithm>
#include <array>
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

/// Of the influences that were added last, those of one point.
void put_heaviest_first(BoneWeights& weights)
{
    const std::ptrdiff_t begin = weights.begins.back();
    const auto first = weights.weights.begin() + begin, heaviest = std::max_element(first, weights.weights.end());
    std::iter_swap(weights.segments.begin() + begin, weights.segments.begin() + (heaviest - weights.weights.begin()));
    std::iter_swap(first, heaviest);
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
        put_heaviest_first(weights);
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
        put_heaviest_first(result);
        result.begins.push_back(int(result.segments.size()));
    }
    return result;
}

Points dual_quaternion_blending(const Eigen::Ref<const Points>& rest, const BoneWeights& weights,
                                const std::vector<Eigen::Isometry3d>& motions)
{
    require(weights.size() == rest.rows(), "{} points were given weights of {}", rest.rows(), weights.size());
    const Eigen::Index num_segments = Eigen::Index(motions.size());
    Eigen::Matrix4Xd reals(4, num_segments), duals(4, num_segments);  // x, y, z, w
    for (Eigen::Index s = 0; s < num_segments; ++s) {
        const Eigen::Quaterniond real = Eigen::Quaterniond(motions[s].linear()).normalized();
        const Eigen::Vector3d t = motions[s].translation();
        reals.col(s) = real.coeffs();
        duals.col(s) = 0.5 * (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * real).coeffs();
    }
    // q and -q are the same motion: what to multiply one by to bring it to the side of another.
    const Eigen::MatrixXd signs = (reals.transpose() * reals).unaryExpr([](double d) { return d < 0.0 ? -1.0 : 1.0; });
    Points posed(rest.rows(), 3);
    constexpr Eigen::Index block = 32;  // points, so that one loop sums and another one runs in vector instructions
#pragma omp parallel for schedule(static)
    for (Eigen::Index first = 0; first < rest.rows(); first += block) {
        const Eigen::Index count = std::min(block, rest.rows() - first);
        const int* const segments = weights.segments.data();
        std::array<std::array<double, block>, 8> sums;
        for (Eigen::Index i = 0; i < count; ++i) {
            const int begin = weights.begins[first + i], end = weights.begins[first + i + 1];
            const double* const to_first = signs.data() + num_segments * segments[begin];
            Eigen::Vector4d real = Eigen::Vector4d::Zero(), dual = Eigen::Vector4d::Zero();
            for (int k = begin; k < end; ++k) {
                const int segment = segments[k];
                const double weight = to_first[segment] * weights.weights[k];
                real += weight * reals.col(segment);
                dual += weight * duals.col(segment);
            }
            for (std::size_t c = 0; c < 4; ++c) {
                sums[c][std::size_t(i)] = real[Eigen::Index(c)];
                sums[4 + c][std::size_t(i)] = dual[Eigen::Index(c)];
            }
        }
        const Eigen::Index stride = rest.outerStride();
        const double* const from = rest.data() + stride * first;
        double* const to = posed.data() + 3 * first;
#pragma omp simd
        for (Eigen::Index i = 0; i < count; ++i) {
            const double rx = sums[0][i], ry = sums[1][i], rz = sums[2][i], rw = sums[3][i];
            const double dx = sums[4][i], dy = sums[5][i], dz = sums[6][i], dw = sums[7][i];
            const double x = from[stride * i], y = from[stride * i + 1], z = from[stride * i + 2];
            const double twice = 2.0 / (rx * rx + ry * ry + rz * rz + rw * rw);
            // x + 2 r x (r x x + w x) + 2 (w d - d_w r + r x d), for unit quaternions
            const double ax = ry * z - rz * y + rw * x, ay = rz * x - rx * z + rw * y, az = rx * y - ry * x + rw * z;
            to[3 * i] = x + twice * (ry * az - rz * ay + rw * dx - dw * rx + ry * dz - rz * dy);
            to[3 * i + 1] = y + twice * (rz * ax - rx * az + rw * dy - dw * ry + rz * dx - rx * dz);
            to[3 * i + 2] = z + twice * (rx * ay - ry * ax + rw * dz - dw * rz + rx * dy - ry * dx);
        }
    }
    return posed;
}

}  // namespace ndg
