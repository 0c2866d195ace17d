// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/elastic_system.h"

#include "ndg/core/error.h"
#include "ndg/fem/neo_hookean.h"
#include "ndg/fem/shell.h"
#include "ndg/fem/volume_guard.h"

#include <Eigen/LU>

#include <algorithm>
#include <numeric>

namespace ndg {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d position(const Points& positions, int vertex)
{
    return positions.row(vertex).transpose();
}

Hinge gather_hinge(const Points& positions, const std::array<int, 4>& v)
{
    return {position(positions, v[0]), position(positions, v[1]), position(positions, v[2]), position(positions, v[3])};
}

Matrix3d deformation(const Points& positions, const FleshElement& element)
{
    Matrix3d f = Matrix3d::Zero();
    for (int a = 0; a < 6; ++a) {
        f.noalias() +=
            position(positions, element.vertices[static_cast<std::size_t>(a)]) * element.gradient.col(a).transpose();
    }
    return f;
}

std::vector<int> all_free_vertices(const ElasticModel& model)
{
    std::vector<int> vertices(static_cast<std::size_t>(model.num_vertices() - model.num_fixed_vertices()));
    std::iota(vertices.begin(), vertices.end(), model.num_fixed_vertices());
    return vertices;
}

/// Elements with at least one of the vertices, ascending.
std::vector<int> elements_at(const std::vector<int>& vertices, const std::vector<std::vector<int>>& around)
{
    std::vector<int> elements;
    for (const int vertex : vertices) {
        const std::vector<int>& here = around[static_cast<std::size_t>(vertex)];
        elements.insert(elements.end(), here.begin(), here.end());
    }
    std::sort(elements.begin(), elements.end());
    elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
    return elements;
}

/// Adds the 3 x 3 block `value` to a matrix whose columns are `stride` values apart.
void add_block(const Matrix3d& value, double* target, std::ptrdiff_t stride)
{
    for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) target[i + j * stride] += value(i, j);
    }
}

Matrix3d cross_matrix(const Vector3d& v)
{
    Matrix3d m;
    m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return m;
}

/// Blocks of B^T H B, where B takes the prism's 18 coordinates to F and H is the exact Hessian of the flesh energy:
/// w (mu (g_a . g_b) I + lambda c_a c_b^T - p [F (g_a x g_b)]), c_a = cof(F) g_a the gradient of det F,
/// p = lambda (det F - 1) - mu, [.] the cross product matrix.
class ExactPrismHessian {
public:
    ExactPrismHessian(const FleshElement& element, const Matrix3d& f) : element_(element), f_(f)
    {
        Matrix3d cofactors;
        cofactors << f.col(1).cross(f.col(2)), f.col(2).cross(f.col(0)), f.col(0).cross(f.col(1));
        volume_gradient_ = cofactors.lazyProduct(element.gradient);
        pressure_ = element.lame.lambda * (f.determinant() - 1) - element.lame.mu;
    }
    Matrix3d block(int a, int b) const
    {
        const Vector3d g_a = element_.gradient.col(a), g_b = element_.gradient.col(b);
        Matrix3d block =
            element_.weight * element_.lame.lambda * volume_gradient_.col(a) * volume_gradient_.col(b).transpose();
        block -= cross_matrix(element_.weight * pressure_ * (f_ * g_a.cross(g_b)));
        block.diagonal().array() += element_.weight * element_.lame.mu * g_a.dot(g_b);
        return block;
    }

private:
    const FleshElement& element_;
    const Matrix3d& f_;
    PrismGradient volume_gradient_;
    double pressure_ = 0;
};

/// The same of the projected Hessian M M^T.
class ProjectedPrismHessian {
public:
    ProjectedPrismHessian(const FleshElement& element, const Matrix3d& f)
    {
        const Matrix9 modes = std::sqrt(element.weight) * neo_hookean_projected_modes(f, element.lame);
        for (int a = 0; a < 6; ++a) {
            rows_.middleRows<3>(3 * a) = element.gradient(0, a) * modes.topRows<3>() +
                                         element.gradient(1, a) * modes.middleRows<3>(3) +
                                         element.gradient(2, a) * modes.bottomRows<3>();
        }
    }
    Matrix3d block(int a, int b) const
    {
        return rows_.middleRows<3>(3 * a).lazyProduct(rows_.middleRows<3>(3 * b).transpose());
    }

private:
    Eigen::Matrix<double, 18, 9> rows_;
};

PrismVertices gather(const Points& positions, const FleshElement& element)
{
    PrismVertices prism;
    for (int a = 0; a < 6; ++a) prism.row(a) = positions.row(element.vertices[static_cast<std::size_t>(a)]);
    return prism;
}

/// The guard of one prism's volume; nothing where it is far from flat.
class GuardedPrism {
public:
    GuardedPrism(const Points& positions, const FleshElement& element)
        : prism_(gather(positions, element)),
          scale_(element.weight * element.lame.lambda),
          rest_volume_(element.rest_volume),
          guard_(volume_guard(prism_volume(prism_) / rest_volume_))
    {
    }
    bool active() const { return guard_.energy > 0; }
    double energy() const { return scale_ * guard_.energy; }
    PrismVertices forces() const { return scale_ * guard_.first / rest_volume_ * prism_volume_gradient(prism_); }
    /// Semi-definite without the curvature of the volume itself.
    Eigen::Matrix<double, 18, 18> hessian(bool exact) const
    {
        const PrismVertices gradient = prism_volume_gradient(prism_) / rest_volume_;
        Eigen::Matrix<double, 18, 1> stacked;
        for (int a = 0; a < 6; ++a) stacked.segment<3>(3 * a) = gradient.row(a).transpose();
        Eigen::Matrix<double, 18, 18> hessian = scale_ * guard_.second * stacked * stacked.transpose();
        if (exact) hessian += scale_ * guard_.first / rest_volume_ * prism_volume_hessian(prism_);
        return hessian;
    }

private:
    PrismVertices prism_;
    double scale_, rest_volume_;
    VolumeGuard guard_;
};

/// Share of an element's stiffness that its smallest eigenvalue may lie below zero and stay, where most stay.
constexpr double nearly_exact_tolerance = 0.3;

template <class Stability>
bool projects(HessianKind kind, const Stability& stability)
{
    if (kind == HessianKind::exact) return false;
    return kind != HessianKind::nearly_exact || stability() < -nearly_exact_tolerance;
}

}  // namespace

ElasticSystem::ElasticSystem(const ElasticModel& model) : ElasticSystem(model, all_free_vertices(model)) {}

ElasticSystem::ElasticSystem(const ElasticModel& model, std::vector<int> vertices)
    : model_(&model), vertices_(std::move(vertices))
{
    require(!vertices_.empty() && std::is_sorted(vertices_.begin(), vertices_.end()) &&
                vertices_.front() >= model.num_fixed_vertices() && vertices_.back() < model.num_vertices(),
            "unknown vertices must be ascending and none of the bone wrap");
    const auto make_parts = [&](const auto& elements, const std::vector<std::vector<int>>& around, auto& parts) {
        for (const int e : elements_at(vertices_, around)) {
            auto& part = parts.emplace_back();
            part.element = e;
            const auto& corners = elements[static_cast<std::size_t>(e)].vertices;
            for (std::size_t a = 0; a < corners.size(); ++a) {
                const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), corners[a]);
                const bool unknown = found != vertices_.end() && *found == corners[a];
                part.unknown[a] = unknown ? static_cast<int>(found - vertices_.begin()) : -1;
            }
        }
    };
    make_parts(model.flesh(), model.flesh_around(), flesh_);
    make_parts(model.skin(), model.skin_around(), skin_);
    make_pattern();
}

double ElasticSystem::energy(const Points& positions) const
{
    double total = 0;
    for (const Part<6>& part : flesh_) {
        const FleshElement& element = model_->flesh()[static_cast<std::size_t>(part.element)];
        total += element.weight * neo_hookean_energy(deformation(positions, element), element.lame);
        if (model_->guards_volume()) total += GuardedPrism(positions, element).energy();
    }
    for (const Part<4>& part : skin_) {
        const SkinElement& element = model_->skin()[static_cast<std::size_t>(part.element)];
        const Hinge hinge = gather_hinge(positions, element.vertices);
        total += model_->stretch_stiffness() * stretch_energy(hinge.x0, hinge.x1, element.rest_length);
        total += bend_energy(hinge, element.bend);
    }
    return total;
}

void ElasticSystem::gradient(const Points& positions, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const
{
    gradient.setZero(num_unknowns());
    absolute.setZero(num_unknowns());
    const auto add = [&](int unknown, const Vector3d& force) {
        if (unknown < 0) return;
        gradient.segment<3>(3 * unknown) += force;
        absolute.segment<3>(3 * unknown) += force.cwiseAbs();
    };
    for (const Part<6>& part : flesh_) {
        const FleshElement& element = model_->flesh()[static_cast<std::size_t>(part.element)];
        const Matrix3d stress = element.weight * neo_hookean_stress(deformation(positions, element), element.lame);
        for (int a = 0; a < 6; ++a) add(part.unknown[static_cast<std::size_t>(a)], stress * element.gradient.col(a));
        if (!model_->guards_volume()) continue;
        const GuardedPrism guarded(positions, element);
        if (!guarded.active()) continue;
        const PrismVertices forces = guarded.forces();
        for (int a = 0; a < 6; ++a) add(part.unknown[static_cast<std::size_t>(a)], forces.row(a).transpose());
    }
    for (const Part<4>& part : skin_) {
        const SkinElement& element = model_->skin()[static_cast<std::size_t>(part.element)];
        const Hinge hinge = gather_hinge(positions, element.vertices);
        const Vector6 stretch = model_->stretch_stiffness() * stretch_gradient(hinge.x0, hinge.x1, element.rest_length);
        add(part.unknown[0], stretch.head<3>());
        add(part.unknown[1], stretch.tail<3>());
        const Vector12 bend = bend_gradient(hinge, element.bend);
        for (int a = 0; a < 4; ++a) add(part.unknown[static_cast<std::size_t>(a)], bend.segment<3>(3 * a));
    }
}

void ElasticSystem::make_pattern()
{
    block_rows_.assign(vertices_.size(), {});
    for (std::size_t i = 0; i < vertices_.size(); ++i) block_rows_[i].push_back(static_cast<int>(i));
    const auto connect = [&](const auto& parts) {
        for (const auto& part : parts) {
            for (const int row : part.unknown) {
                for (const int column : part.unknown) {
                    if (column >= 0 && row > column) block_rows_[static_cast<std::size_t>(column)].push_back(row);
                }
            }
        }
    };
    connect(flesh_);
    connect(skin_);
    for (std::vector<int>& rows : block_rows_) {
        std::sort(rows.begin(), rows.end());
        rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
        block_begin_.push_back(num_values_);
        num_values_ += 9 * static_cast<int>(rows.size());
    }
    for (Part<6>& part : flesh_) find_places(part);
    for (Part<4>& part : skin_) find_places(part);
}

template <std::size_t Size>
void ElasticSystem::find_places(Part<Size>& part) const
{
    part.place.fill(-1);
    for (std::size_t b = 0; b < Size; ++b) {
        if (part.unknown[b] < 0) continue;
        const auto column = static_cast<std::size_t>(part.unknown[b]);
        const std::vector<int>& rows = block_rows_[column];
        for (std::size_t a = 0; a < Size; ++a) {
            if (part.unknown[a] < part.unknown[b]) continue;
            const auto found = std::lower_bound(rows.begin(), rows.end(), part.unknown[a]);
            part.place[a + Size * b] = block_begin_[column] + 3 * static_cast<int>(found - rows.begin());
        }
    }
}

Eigen::SparseMatrix<double> ElasticSystem::hessian_pattern() const
{
    Eigen::SparseMatrix<double> matrix(num_unknowns(), num_unknowns());
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
    matrix.outerIndexPtr()[num_unknowns()] = value;
    return matrix;
}

void ElasticSystem::hessian(const Points& positions, HessianKind kind, Eigen::SparseMatrix<double>& hessian) const
{
    require(hessian.rows() == num_unknowns() && hessian.nonZeros() == num_values_,
            "the matrix given does not have the pattern of this system");
    double* values = hessian.valuePtr();
    std::fill_n(values, num_values_, 0.0);
    const auto add = [&](const auto& part, const auto& block) {
        const std::size_t size = part.unknown.size();
        for (std::size_t b = 0; b < size; ++b) {
            if (part.unknown[b] < 0) continue;
            const auto stride =
                static_cast<std::ptrdiff_t>(3 * block_rows_[static_cast<std::size_t>(part.unknown[b])].size());
            for (std::size_t a = 0; a < size; ++a) {
                const int place = part.place[a + size * b];
                if (place >= 0) add_block(block(static_cast<int>(a), static_cast<int>(b)), values + place, stride);
            }
        }
    };
    for (const Part<6>& part : flesh_) {
        const FleshElement& element = model_->flesh()[static_cast<std::size_t>(part.element)];
        const Matrix3d f = deformation(positions, element);
        if (projects(kind, [&] { return neo_hookean_stability(f, element.lame); })) {
            const ProjectedPrismHessian prism(element, f);
            add(part, [&](int a, int b) { return prism.block(a, b); });
        } else {
            const ExactPrismHessian prism(element, f);
            add(part, [&](int a, int b) { return prism.block(a, b); });
        }
        if (!model_->guards_volume()) continue;
        const GuardedPrism guarded(positions, element);
        if (!guarded.active()) continue;
        const auto guard = guarded.hessian(kind == HessianKind::exact);
        add(part, [&](int a, int b) -> Matrix3d { return guard.block<3, 3>(3 * a, 3 * b); });
    }
    for (const Part<4>& part : skin_) {
        const SkinElement& element = model_->skin()[static_cast<std::size_t>(part.element)];
        const Hinge hinge = gather_hinge(positions, element.vertices);
        const bool projected = projects(kind, [&] { return bend_stability(hinge, element.bend); });
        Matrix12 sum = kind == HessianKind::gauss_newton ? bend_gauss_newton_hessian(hinge, element.bend)
                       : projected                       ? bend_projected_hessian(hinge, element.bend)
                                                         : bend_hessian(hinge, element.bend);
        sum.topLeftCorner<6, 6>() += model_->stretch_stiffness() *
                                     (projected ? stretch_projected_hessian(hinge.x0, hinge.x1, element.rest_length)
                                                : stretch_hessian(hinge.x0, hinge.x1, element.rest_length));
        add(part, [&](int a, int b) -> Matrix3d { return sum.block<3, 3>(3 * a, 3 * b); });
    }
}

}  // namespace ndg
