// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/isosurface.h"

#include "ndg/core/error.h"
#include "ndg/geometry/cgal_mesh.h"

#include <CGAL/Polygon_mesh_processing/remesh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace ndg {

namespace {

using Face = CgalMesh::Face_index;

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr int block_cells = 8;  // cells a side of the blocks that are skipped as a whole
constexpr unsigned int remesh_iterations = 4;

/// Values on the grid's nodes; NaN where the surface is far.
class GridValues {
public:
    GridValues(const ScalarField& field, const GridAxes& axes)
        : axes_(axes), nx_(axes.x.size()), ny_(axes.y.size()), nz_(axes.z.size()), values_(nx_ * ny_ * nz_, unknown)
    {
        const auto blocks = [](std::size_t nodes) { return static_cast<int>((nodes + block_cells - 2) / block_cells); };
        const int bx = blocks(nx_), by = blocks(ny_), bz = blocks(nz_);
#pragma omp parallel for schedule(dynamic)
        for (int b = 0; b < bx * by * bz; ++b) fill(field, b / (by * bz), b / bz % by, b % bz);
    }
    double at(std::size_t i, std::size_t j, std::size_t k) const
    {
        return values_[index(i, j, k)];
    }
    std::size_t index(std::size_t i, std::size_t j, std::size_t k) const
    {
        return (i * ny_ + j) * nz_ + k;
    }
    Eigen::Vector3d point(std::size_t node) const
    {
        return {axes_.x[node / (ny_ * nz_)], axes_.y[node / nz_ % ny_], axes_.z[node % nz_]};
    }
    double value(std::size_t node) const
    {
        return values_[node];
    }

private:
    /// Nodes of a block; blocks share their border nodes, which get the same values from each.
    void fill(const ScalarField& field, int bx, int by, int bz)
    {
        const auto range = [](int block, std::size_t nodes) {
            const std::size_t first = static_cast<std::size_t>(block) * block_cells;
            return std::make_pair(first, std::min(first + block_cells, nodes - 1));
        };
        const auto [x0, x1] = range(bx, nx_);
        const auto [y0, y1] = range(by, ny_);
        const auto [z0, z1] = range(bz, nz_);
        const Eigen::Vector3d low(axes_.x[x0], axes_.y[y0], axes_.z[z0]), high(axes_.x[x1], axes_.y[y1], axes_.z[z1]);
        if (std::abs(field(0.5 * (low + high))) > 1.5 * (high - low).norm()) return;
        // The last node of a block belongs to the next one, except at the end of the grid.
        const std::size_t ex = x1 == nx_ - 1 ? nx_ : x1, ey = y1 == ny_ - 1 ? ny_ : y1, ez = z1 == nz_ - 1 ? nz_ : z1;
        for (std::size_t i = x0; i < ex; ++i)
            for (std::size_t j = y0; j < ey; ++j)
                for (std::size_t k = z0; k < ez; ++k) {
                    const double value = field({axes_.x[i], axes_.y[j], axes_.z[k]});
                    // Never exactly zero: the surface then passes no node, and stays manifold.
                    values_[index(i, j, k)] = std::abs(value) < 1e-9 ? 1e-9 : value;
                }
    }

    const GridAxes& axes_;
    std::size_t nx_, ny_, nz_;
    std::vector<double> values_;
};

/// Collects triangles whose vertices lie on grid edges.
class Collector {
public:
    explicit Collector(const GridValues& grid) : grid_(grid) {}

    void add_tetrahedron(const std::array<std::size_t, 4>& nodes)
    {
        std::array<std::size_t, 4> in{}, out{};
        int num_in = 0, num_out = 0;
        for (const std::size_t node : nodes) (grid_.value(node) < 0.0 ? in[num_in++] : out[num_out++]) = node;
        if (num_in == 0 || num_out == 0) return;
        if (num_in == 1) add({vertex(in[0], out[0]), vertex(in[0], out[1]), vertex(in[0], out[2])}, in[0]);
        if (num_in == 3) add({vertex(in[0], out[0]), vertex(in[1], out[0]), vertex(in[2], out[0])}, in[0]);
        if (num_in == 2) {
            const int a = vertex(in[0], out[0]), b = vertex(in[0], out[1]), c = vertex(in[1], out[1]),
                      d = vertex(in[1], out[0]);
            add({a, b, c}, in[0]);
            add({a, c, d}, in[0]);
        }
    }
    TriangleMesh take() const
    {
        TriangleMesh mesh;
        mesh.vertices.resize(static_cast<Eigen::Index>(points_.size()), 3);
        for (std::size_t v = 0; v < points_.size(); ++v)
            mesh.vertices.row(static_cast<Eigen::Index>(v)) = points_[v].transpose();
        mesh.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
        for (std::size_t t = 0; t < triangles_.size(); ++t)
            for (int k = 0; k < 3; ++k) mesh.triangles(static_cast<Eigen::Index>(t), k) = triangles_[t][k];
        return mesh;
    }

private:
    int vertex(std::size_t a, std::size_t b)
    {
        const auto [low, high] = std::minmax(a, b);
        // The end of an edge is one of seven neighbours of its beginning: 2^20 is more than any of their offsets.
        const auto [found, fresh] = vertices_.try_emplace((static_cast<std::uint64_t>(low) << 24) + (high - low),
                                                          static_cast<int>(points_.size()));
        if (fresh) {
            const double va = grid_.value(low), vb = grid_.value(high);
            const double t = std::clamp(va / (va - vb), 0.02, 0.98);
            points_.push_back((1.0 - t) * grid_.point(low) + t * grid_.point(high));
        }
        return found->second;
    }
    /// Orients away from a node inside.
    void add(std::array<int, 3> v, std::size_t inside)
    {
        const auto p = [&](std::size_t k) -> const Eigen::Vector3d& { return points_[v[k]]; };
        if ((p(1) - p(0)).cross(p(2) - p(0)).dot(grid_.point(inside) - p(0)) > 0.0) std::swap(v[1], v[2]);
        triangles_.push_back(v);
    }

    const GridValues& grid_;
    std::unordered_map<std::uint64_t, int> vertices_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<std::array<int, 3>> triangles_;
};

}  // namespace

TriangleMesh marching_tetrahedra(const ScalarField& field, const GridAxes& axes)
{
    for (const auto* axis : {&axes.x, &axes.y, &axes.z}) {
        require(axis->size() >= 2 && axis->size() < 4000, "A grid axis has {} planes", axis->size());
        for (std::size_t i = 1; i < axis->size(); ++i)
            require((*axis)[i] > (*axis)[i - 1], "The planes of a grid axis do not ascend at index {}", i);
    }
    const GridValues grid(field, axes);
    Collector collector(grid);
    // Kuhn's six tetrahedra around the cell's diagonal; neighbouring cells agree on the diagonals of their faces.
    constexpr std::array<std::array<int, 3>, 6> orders = {
        {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    for (std::size_t i = 0; i + 1 < axes.x.size(); ++i)
        for (std::size_t j = 0; j + 1 < axes.y.size(); ++j)
            for (std::size_t k = 0; k + 1 < axes.z.size(); ++k) {
                bool known = true, negative = false, positive = false;
                for (int corner = 0; corner < 8; ++corner) {
                    const double value = grid.at(i + (corner & 1), j + ((corner >> 1) & 1), k + ((corner >> 2) & 1));
                    known = known && !std::isnan(value);
                    negative = negative || value < 0.0;
                    positive = positive || value > 0.0;
                }
                if (!known || !negative || !positive) continue;
                for (const auto& order : orders) {
                    std::array<std::size_t, 3> at = {i, j, k};
                    std::array<std::size_t, 4> nodes{};
                    nodes[0] = grid.index(at[0], at[1], at[2]);
                    for (std::size_t step = 0; step < 3; ++step) {
                        ++at[order[step]];
                        nodes[step + 1] = grid.index(at[0], at[1], at[2]);
                    }
                    collector.add_tetrahedron(nodes);
                }
            }
    return collector.take();
}

TriangleMesh remesh_graded(const TriangleMesh& mesh, std::vector<int>& labels, const std::vector<double>& edge_lengths)
{
    require(static_cast<Eigen::Index>(labels.size()) == mesh.triangles.rows(), "{} labels were given for {} triangles",
            labels.size(), mesh.triangles.rows());
    CgalMesh surface = to_cgal(mesh);
    auto label_map = surface.add_property_map<Face, int>("f:label", 0).first;
    for (const Face face : surface.faces()) label_map[face] = labels[face.idx()];
    for (std::size_t label = 0; label < edge_lengths.size(); ++label) {
        std::vector<Face> faces;
        for (const Face face : surface.faces())
            if (label_map[face] == static_cast<int>(label)) faces.push_back(face);
        if (faces.empty()) continue;
        CGAL::Polygon_mesh_processing::isotropic_remeshing(faces, edge_lengths[label], surface,
                                                           CGAL::parameters::number_of_iterations(remesh_iterations)
                                                               .face_patch_map(label_map)
                                                               .number_of_relaxation_steps(1));
    }
    TriangleMesh result = from_cgal(surface);
    labels.clear();
    for (const Face face : surface.faces()) labels.push_back(label_map[face]);
    return result;
}

}  // namespace ndg
