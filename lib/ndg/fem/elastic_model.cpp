// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/elastic_model.h"

#include "ndg/core/error.h"
#include "ndg/fem/neo_hookean.h"
#include "ndg/fem/shell.h"
#include "ndg/geometry/triangle_mesh.h"

#include <Eigen/LU>

#include <algorithm>

namespace ndg {

namespace {

using Eigen::Vector3d;
using Matrix18 = Eigen::Matrix<double, 18, 18>;

Vector3d position(const Points& vertices, int vertex)
{
    return vertices.row(vertex).transpose();
}

Hinge gather_hinge(const Points& vertices, const std::array<int, 4>& v)
{
    return {position(vertices, v[0]), position(vertices, v[1]), position(vertices, v[2]), position(vertices, v[3])};
}

/// B^T H B, where B takes the prism's 18 coordinates to F.
Matrix18 pull_back(const PrismGradient& gradient, const Matrix9& hessian)
{
    Eigen::Matrix<double, 9, 18> operator_matrix = Eigen::Matrix<double, 9, 18>::Zero();
    for (int a = 0; a < 6; ++a) {
        for (int j = 0; j < 3; ++j) {
            for (int i = 0; i < 3; ++i) operator_matrix(i + 3 * j, i + 3 * a) = gradient(j, a);
        }
    }
    Eigen::Matrix<double, 9, 18> product;
    for (int a = 0; a < 6; ++a) {
        product.middleCols<3>(3 * a) = gradient(0, a) * hessian.leftCols<3>() +
                                       gradient(1, a) * hessian.middleCols<3>(3) +
                                       gradient(2, a) * hessian.rightCols<3>();
    }
    return operator_matrix.transpose().lazyProduct(product);
}

}  // namespace

ElasticModel::ElasticModel(const Template& body_template, const MaterialOptions& material)
    : material_(material),
      prisms_(body_template.prisms),
      num_vertices_(body_template.num_volume_vertices()),
      num_fixed_(body_template.num_wrap_vertices()),
      fat_begin_(body_template.fat_begin()),
      lame_{lame_parameters(material.young_muscle_pascal, material.poisson_ratio),
            lame_parameters(material.young_fat_pascal, material.poisson_ratio)},
      operators_(static_cast<std::size_t>(prisms_.rows())),
      weights_(static_cast<std::size_t>(prisms_.rows()))
{
    material_.check();
    // A hinge needs two triangles; edges on the cuts at head, hands and toes have one and carry no skin energy.
    const int skin_begin = 2 * num_fixed_;
    for (const MeshEdge& edge : mesh_edges(body_template.wrap_triangles, num_fixed_)) {
        if (edge.right_triangle < 0) continue;
        SkinEdge skin_edge;
        skin_edge.vertices = {skin_begin + edge.v0, skin_begin + edge.v1, skin_begin + edge.left_vertex,
                              skin_begin + edge.right_vertex};
        skin_edges_.push_back(skin_edge);
    }
    make_pattern();
    set_rest(body_template.rest.volume_vertices);
}

void ElasticModel::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    require(rest_vertices.rows() == num_vertices_, "the body has {} volume vertices, the template {}",
            rest_vertices.rows(), num_vertices_);
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        const PrismVertices prism = gather_prism(rest_vertices, prisms_, p);
        const double volume = prism_volume(prism);
        require(volume > 0, "rest prism {} has volume {} m^3", p, volume);
        operators_[static_cast<std::size_t>(p)] = prism_gradient_operator(prism);
        weights_[static_cast<std::size_t>(p)] = material_.flesh_stiffness * volume;
    }
    const Points rest = rest_vertices;
    for (SkinEdge& edge : skin_edges_) {
        const Hinge hinge = gather_hinge(rest, edge.vertices);
        const Vector3d along = hinge.x1 - hinge.x0;
        edge.rest_length = along.norm();
        edge.bend.left_area = 0.5 * along.cross(hinge.left - hinge.x0).norm();
        edge.bend.right_area = 0.5 * along.cross(hinge.right - hinge.x0).norm();
        require(edge.bend.left_area > 0 && edge.bend.right_area > 0,
                "the skin triangles at volume vertices {} and {} have rest areas {} and {} m^2", edge.vertices[0],
                edge.vertices[1], edge.bend.left_area, edge.bend.right_area);
        edge.bend.angle = dihedral_angle(hinge.x0, hinge.x1, hinge.left, hinge.right);
        edge.bend.weight = 3 * material_.bend_stiffness * edge.rest_length * edge.rest_length /
                           (edge.bend.left_area + edge.bend.right_area);
    }
}

std::array<int, 6> ElasticModel::prism_vertices(Eigen::Index prism_idx) const
{
    std::array<int, 6> vertices{};
    for (int a = 0; a < 6; ++a) vertices[static_cast<std::size_t>(a)] = prisms_(prism_idx, a);
    return vertices;
}

Eigen::Matrix3d ElasticModel::deformation(const Points& vertices, Eigen::Index prism_idx) const
{
    PrismVertices prism;
    for (int a = 0; a < 6; ++a) prism.row(a) = vertices.row(prisms_(prism_idx, a));
    return prism.transpose().lazyProduct(operators_[static_cast<std::size_t>(prism_idx)].transpose());
}

double ElasticModel::energy(const Points& vertices) const
{
    double total = 0;
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        total += weights_[static_cast<std::size_t>(p)] *
                 neo_hookean_energy(deformation(vertices, p), lame_[p >= fat_begin_]);
    }
    for (const SkinEdge& edge : skin_edges_) {
        const Hinge hinge = gather_hinge(vertices, edge.vertices);
        total += material_.stretch_stiffness * stretch_energy(hinge.x0, hinge.x1, edge.rest_length);
        total += bend_energy(hinge, edge.bend);
    }
    return total;
}

void ElasticModel::gradient(const Points& vertices, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const
{
    gradient.setZero(num_dofs());
    absolute.setZero(num_dofs());
    const auto add = [&](int vertex, const Vector3d& force) {
        if (vertex < num_fixed_) return;
        gradient.segment<3>(3 * (vertex - num_fixed_)) += force;
        absolute.segment<3>(3 * (vertex - num_fixed_)) += force.cwiseAbs();
    };
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        const auto idx = static_cast<std::size_t>(p);
        const Eigen::Matrix3d stress = neo_hookean_stress(deformation(vertices, p), lame_[p >= fat_begin_]);
        const Eigen::Matrix<double, 3, 6> forces = (weights_[idx] * stress).lazyProduct(operators_[idx]);
        for (int a = 0; a < 6; ++a) add(prisms_(p, a), forces.col(a));
    }
    for (const SkinEdge& edge : skin_edges_) {
        const Hinge hinge = gather_hinge(vertices, edge.vertices);
        const Vector6 stretch = material_.stretch_stiffness * stretch_gradient(hinge.x0, hinge.x1, edge.rest_length);
        add(edge.vertices[0], stretch.head<3>());
        add(edge.vertices[1], stretch.tail<3>());
        const Vector12 bend = bend_gradient(hinge, edge.bend);
        for (int a = 0; a < 4; ++a) add(edge.vertices[static_cast<std::size_t>(a)], bend.segment<3>(3 * a));
    }
}

void ElasticModel::make_pattern()
{
    const int num_free = num_vertices_ - num_fixed_;
    block_rows_.assign(static_cast<std::size_t>(num_free), {});
    for (int v = 0; v < num_free; ++v) block_rows_[static_cast<std::size_t>(v)].push_back(v);
    const auto connect = [&](const auto& vertices) {
        for (const int row : vertices) {
            for (const int column : vertices) {
                if (column < num_fixed_ || row <= column) continue;
                block_rows_[static_cast<std::size_t>(column - num_fixed_)].push_back(row - num_fixed_);
            }
        }
    };
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) connect(prism_vertices(p));
    for (const SkinEdge& edge : skin_edges_) connect(edge.vertices);

    block_begin_.clear();
    num_values_ = 0;
    for (std::vector<int>& rows : block_rows_) {
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        block_begin_.push_back(num_values_);
        num_values_ += 9 * static_cast<int>(rows.size());
    }
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) prism_places_.push_back(find_places(prism_vertices(p)));
    for (const SkinEdge& edge : skin_edges_) edge_places_.push_back(find_places(edge.vertices));
}

template <std::size_t Size>
ElasticModel::Places<Size> ElasticModel::find_places(const std::array<int, Size>& vertices) const
{
    Places<Size> places;
    places.fill(-1);
    for (std::size_t b = 0; b < Size; ++b) {
        if (vertices[b] < num_fixed_) continue;
        const auto column = static_cast<std::size_t>(vertices[b] - num_fixed_);
        const std::vector<int>& rows = block_rows_[column];
        for (std::size_t a = 0; a < Size; ++a) {
            if (vertices[a] < vertices[b]) continue;
            const auto found = std::lower_bound(rows.begin(), rows.end(), vertices[a] - num_fixed_);
            places[a + Size * b] = block_begin_[column] + 3 * static_cast<int>(found - rows.begin());
        }
    }
    return places;
}

Eigen::SparseMatrix<double> ElasticModel::hessian_pattern() const
{
    Eigen::SparseMatrix<double> matrix(num_dofs(), num_dofs());
    matrix.resizeNonZeros(num_values_);
    int value = 0;
    for (std::size_t v = 0; v < block_rows_.size(); ++v) {
        for (int j = 0; j < 3; ++j) {
            matrix.outerIndexPtr()[3 * v + static_cast<std::size_t>(j)] = value;
            for (const int row : block_rows_[v]) {
                for (int i = 0; i < 3; ++i) {
                    matrix.innerIndexPtr()[value] = 3 * row + i;
                    matrix.valuePtr()[value++] = 0;
                }
            }
        }
    }
    matrix.outerIndexPtr()[num_dofs()] = value;
    return matrix;
}

template <std::size_t Size>
void ElasticModel::add_block_matrix(
    const std::array<int, Size>& vertices, const Places<Size>& places,
    const Eigen::Matrix<double, 3 * static_cast<int>(Size), 3 * static_cast<int>(Size)>& element, double* values) const
{
    for (std::size_t b = 0; b < Size; ++b) {
        if (vertices[b] < num_fixed_) continue;
        const auto stride =
            static_cast<std::ptrdiff_t>(3 * block_rows_[static_cast<std::size_t>(vertices[b] - num_fixed_)].size());
        for (std::size_t a = 0; a < Size; ++a) {
            const int place = places[a + Size * b];
            if (place < 0) continue;
            for (int j = 0; j < 3; ++j) {
                const double* source = element.data() + 3 * a + (3 * b + static_cast<std::size_t>(j)) * 3 * Size;
                double* target = values + place + j * stride;
                for (int i = 0; i < 3; ++i) target[i] += source[i];
            }
        }
    }
}

void ElasticModel::hessian(const Points& vertices, bool projected, Eigen::SparseMatrix<double>& hessian) const
{
    require(hessian.rows() == num_dofs() && hessian.nonZeros() == num_values_,
            "the matrix given does not have the pattern of this model");
    double* values = hessian.valuePtr();
    std::fill_n(values, num_values_, 0.0);
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        const auto idx = static_cast<std::size_t>(p);
        const Lame& lame = lame_[p >= fat_begin_];
        const Eigen::Matrix3d f = deformation(vertices, p);
        const Matrix9 block =
            weights_[idx] * (projected ? neo_hookean_projected_hessian(f, lame) : neo_hookean_hessian(f, lame));
        add_block_matrix<6>(prism_vertices(p), prism_places_[idx], pull_back(operators_[idx], block), values);
    }
    for (std::size_t e = 0; e < skin_edges_.size(); ++e) {
        const SkinEdge& edge = skin_edges_[e];
        const Hinge hinge = gather_hinge(vertices, edge.vertices);
        Matrix12 element = projected ? bend_projected_hessian(hinge, edge.bend) : bend_hessian(hinge, edge.bend);
        element.topLeftCorner<6, 6>() +=
            material_.stretch_stiffness * (projected ? stretch_projected_hessian(hinge.x0, hinge.x1, edge.rest_length)
                                                     : stretch_hessian(hinge.x0, hinge.x1, edge.rest_length));
        add_block_matrix<4>(edge.vertices, edge_places_[e], element, values);
    }
}

}  // namespace ndg
