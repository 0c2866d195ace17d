// SPDX-License-Identifier: Apache-2.0
// What a good pair of wraps minimises.
#pragma once

#include "ndg/geometry/distance_grid.h"
#include "ndg/wraps/prism_barrier.h"
#include "ndg/wraps/wrap_skin.h"

#include <Eigen/SparseCore>

#include <array>
#include <vector>

namespace ndg {

/// Two inner surfaces in the tessellation of a skin.
struct WrapPair {
    Points bone, muscle;  ///< N_w x 3
};

/// Weights and lengths. Energies are without unit: lengths count in `length_scale`, integrals over the skin in mean
/// triangle areas.
struct WrapEnergyOptions {
    double length_scale = 0.01;      ///< m
    double muscle_fit = 1.0;         ///< weight of the muscle wrap's fit
    double repulsion_reach = 0.003;  ///< m inside, from where on the repulsion grows no more
    double repulsion = 100.0;  ///< of an envelope, where a wrap lies inside it; attraction from outside has weight 1
    double bone_bending_length = 0.02;    ///< m; hollows narrower than this are bridged
    double muscle_bending_length = 0.01;  ///< m
    double skin_likeness = 0.5;           ///< share of bending that is measured against the skin's own shape (0..1)
    double quality = 0.5;                 ///< weight of the barriers
    double cover = 0.0008;          ///< m, least depth of the muscle wrap below the skin; twice that for the bone wrap
    double boundary = 20.0;         ///< weight of the distance of border vertices from the plane of their cut
    double active_jacobian = 0.35;  ///< scaled Jacobians above this feel no barrier
    double active_thickness = 0.002;              ///< m, likewise
    double min_area = 0.004, active_area = 0.05;  ///< of a wrap's triangle, as shares of the skin's
    double sample_spacing = 0.005;  ///< m between the points of a skin triangle at which the wraps meet the envelope
};

/// E = fit + bending + barriers for wraps B (bone) and M (muscle) under a skin S:
///   fit      max(0, margin - phi)^2 repulsion + max(0, phi - margin)^2 at points spread over every triangle
///   bending  |Laplacian of B|^2 and |Laplacian of (B - S)|^2, the same for M
///   barrier  -(1 - y)^2 log y with y = 0 at the bound and y = 1 where the barrier begins (after Li et al. 2020), of
///   the
///            scaled Jacobian at all corners and quadrature points and of the height at all corners of every prism
///   border   distance of border vertices from the plane of their skin loop
///   cover    max(0, depth - distance below the skin)^2 repulsion, which acts where the prisms see no neighbour
class WrapEnergy {
public:
    /// Signed distance to the envelopes of bones and muscles and to the skin; all kept by reference.
    WrapEnergy(const WrapSkin& skin, const ScalarGrid& bone, const ScalarGrid& muscle, const ScalarGrid& skin_distance,
               const WrapEnergyOptions& options);

    /// Infinite where a barrier's bound is reached. `gradient` may be null.
    double evaluate(const WrapPair& wraps, WrapPair* gradient) const;

    /// Positive definite approximation of the Hessian (squares of first derivatives, and a bound of the barriers'
    /// curvature along their columns): lower triangle, 6 N_w x 6 N_w, the pattern always the same. Unknown 6 v + c is
    /// coordinate c of vertex v of the bone wrap for c < 3, coordinate c - 3 of the muscle wrap otherwise.
    /// `ridge` / length_scale^2 on the diagonal keeps it definite where nothing acts on a vertex.
    const Eigen::SparseMatrix<double>& hessian(const WrapPair& wraps, double ridge = 1e-3);

    /// Bounds for each triangle: column 0 the fat layer, column 1 the muscle layer. Scaled Jacobian and m.
    Eigen::ArrayX2d jacobian_bounds, thickness_bounds;
    /// Shortens `move` at vertices where it would take a prism most of the way to a bound or beyond.
    void limit_move(const WrapPair& wraps, WrapPair& move) const;

    /// Wanted distance from the envelope for each triangle, m: column 0 bone wrap, column 1 muscle wrap.
    Eigen::ArrayX2d margins;

    WrapEnergyOptions options;

private:
    using Corners = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

    Corners corners(const Points& surface, Eigen::Index t) const;
    using ElementHessian = Eigen::Matrix<double, 18, 18>;  ///< of a triangle's bone corners, then its muscle corners

    double fit(const ScalarGrid& envelope, double margin, double depth, double weight, const Corners& triangle,
               Corners* gradient, Eigen::Matrix<double, 9, 9>* hessian) const;
    Points gather(const std::vector<Corners>& corner_gradients) const;
    BarrierBounds bounds(Eigen::Index t, int layer) const;
    ElementHessian element_hessian(const WrapPair& wraps, Eigen::Index t) const;
    void prepare_pattern();
    /// First entry of the 6 x 6 block at vertices (u, v), u >= v, and the distance between its columns.
    double* block(int u, int v, Eigen::Index& stride);

    const WrapSkin& skin_;
    const ScalarGrid& bone_;
    const ScalarGrid& muscle_;
    const ScalarGrid& skin_distance_;
    Eigen::VectorXd triangle_weights_;  ///< area / mean area
    double mean_area_ = 0.0;            ///< m^2
    Eigen::SparseMatrix<double> bone_bending_, muscle_bending_;
    std::vector<Eigen::Vector3d> samples_;                   ///< barycentric
    std::vector<std::vector<std::array<int, 2>>> incident_;  ///< (triangle, corner) of every vertex
    struct Border {
        int vertex;
        Eigen::RowVector3d point, normal;
    };
    std::vector<Border> border_;
    Eigen::SparseMatrix<double> hessian_;
};

}  // namespace ndg
