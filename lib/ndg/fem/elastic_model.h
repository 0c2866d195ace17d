// SPDX-License-Identifier: Apache-2.0
// Total elastic energy of a layered body (NDG equation 7) as a function of its free vertices: muscle wrap and skin.
#pragma once

#include "ndg/body/template.h"
#include "ndg/fem/materials.h"
#include "ndg/fem/shell.h"
#include "ndg/geometry/prism.h"

#include <Eigen/SparseCore>

#include <array>
#include <vector>

namespace ndg {

/// Topology, sparsity pattern and the places of every element's entries in it are made once per template; set_rest()
/// changes the body. Positions are N_v x 3; degrees of freedom are 3 (v - N_w) + coordinate for v >= N_w.
/// Functions are const and do not allocate in element loops; one matrix and vector per thread is the caller's.
class ElasticModel {
public:
    ElasticModel(const Template& body_template, const MaterialOptions& material);

    /// Throws Error for a flat or inverted rest prism or a skin edge of no length.
    void set_rest(const Eigen::Ref<const Points>& rest_vertices);

    int num_dofs() const { return 3 * (num_vertices_ - num_fixed_); }
    int num_fixed_vertices() const { return num_fixed_; }
    const Prisms& prisms() const { return prisms_; }

    /// Joule; zero at rest and under rigid motions.
    double energy(const Points& vertices) const;

    /// d energy / d dofs in newton, and per degree of freedom the sum over elements of the absolute force each
    /// contributes there: against its norm the norm of the gradient is the share of the forces out of balance.
    void gradient(const Points& vertices, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const;

    /// A matrix of the Hessian's pattern, zero: lower triangle in 3 x 3 vertex blocks, diagonal blocks full.
    Eigen::SparseMatrix<double> hessian_pattern() const;
    /// d^2 energy / d dofs^2 into a matrix made by hessian_pattern(). `projected`: every element's Hessian is made
    /// positive semi-definite first.
    void hessian(const Points& vertices, bool projected, Eigen::SparseMatrix<double>& hessian) const;

private:
    struct SkinEdge {
        std::array<int, 4> vertices{};  ///< x0, x1, left, right
        double rest_length = 0;
        HingeRest bend;
    };
    /// Value index of the top left entry of block (row vertex a, column vertex b) at [a + Size b]; -1: not stored.
    template <std::size_t Size>
    using Places = std::array<int, Size * Size>;

    void make_pattern();
    template <std::size_t Size>
    Places<Size> find_places(const std::array<int, Size>& vertices) const;
    template <std::size_t Size>
    void add_block_matrix(const std::array<int, Size>& vertices, const Places<Size>& places,
                          const Eigen::Matrix<double, 3 * static_cast<int>(Size), 3 * static_cast<int>(Size)>& element,
                          double* values) const;
    std::array<int, 6> prism_vertices(Eigen::Index prism_idx) const;
    Eigen::Matrix3d deformation(const Points& vertices, Eigen::Index prism_idx) const;

    MaterialOptions material_;
    Prisms prisms_;
    int num_vertices_ = 0, num_fixed_ = 0, fat_begin_ = 0;
    std::array<Lame, 2> lame_;              ///< muscle layer, fat layer
    std::vector<PrismGradient> operators_;  ///< G_p
    std::vector<double> weights_;           ///< k_f V_p
    std::vector<SkinEdge> skin_edges_;

    std::vector<std::vector<int>> block_rows_;  ///< per free vertex: itself and its later neighbours, sorted
    std::vector<int> block_begin_;              ///< per free vertex: value index of its first column
    int num_values_ = 0;
    std::vector<Places<6>> prism_places_;
    std::vector<Places<4>> edge_places_;
};

}  // namespace ndg
