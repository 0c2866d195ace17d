// SPDX-License-Identifier: Apache-2.0
// From what the network gives to the right-hand side of the Poisson solve, prism by prism in one pass: matrix
// exponential (NDG equation 15), rotation R_p (equations 11 and 12), and the sums G^T W F^T (equation 10).
#pragma once

#include "ndg/body/template.h"
#include "ndg/deform/poisson_matrices.h"
#include "ndg/deform/rest_operators.h"
#include "ndg/runtime/model_traits.h"

#include <array>
#include <vector>

namespace ndg {

/// 4 x N: points as columns, the fourth number not used.
using PointColumns = Eigen::Matrix4Xf;

class PrismForces {
public:
    /// `prisms`: of each lane, as RuntimeNetwork::prisms().
    PrismForces(const Template& body_template, const std::vector<int>& prisms, const ModelTraits& traits);

    /// Another body.
    void set_rest(const RestOperators& rest, const PoissonMatrices& matrices);

    /// Called by all threads of an OpenMP parallel region, or outside of one. `outputs`: RuntimeNetwork::outputs();
    /// `volume`: its first N_w columns are the posed bone wrap, the next 2 N_w become the right-hand side. The same for
    /// any number of threads.
    void right_hand_side(const std::vector<float>& outputs, const std::vector<Eigen::Isometry3d>& world_from_rest,
                         PointColumns& volume);

    /// For comparisons: AVX-512 or not, where the processor has it.
    void use_wide_registers(bool wide);

    /// What a frame reads of tables, bytes.
    std::size_t table_bytes() const;

private:
    static constexpr int lanes = 16;
    /// One influence of a joint on each prism of a group.
    struct Influence {
        std::array<int, lanes> joints;
        std::array<float, lanes> weights;
    };
    struct Group {
        alignas(64) std::array<std::array<float, lanes>, 18> operators;  ///< V_p G_p^T, row by row
        std::array<std::array<int, lanes>, 6> vertices;                  ///< free ones, num_free_ for the bone wrap
        int influence_begin, influence_end;                              ///< the heaviest first
    };
    /// x, y, z, w of each joint's rotation.
    using Quaternions = std::array<std::vector<float>, 4>;
    struct Kernels;

    int num_wrap_ = 0, num_free_ = 0;
    bool is_exponential_ = true, is_wide_ = false;
    std::vector<int> prisms_;
    std::vector<Group> groups_;
    std::vector<Influence> influences_;
    Quaternions quaternions_;
    std::vector<PointColumns> sums_;  ///< of each piece of the groups
    /// The coupling with the bone wrap, row by row.
    std::vector<int> coupling_begin_, coupling_column_;
    std::vector<float> coupling_;
};

}  // namespace ndg
