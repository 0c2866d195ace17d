// SPDX-License-Identifier: Apache-2.0
// The matrices of the Poisson reconstruction (NDG equation 10).
#pragma once

#include "ndg/deform/rest_operators.h"

#include <Eigen/SparseCore>

namespace ndg {

/// G^T W G of a body, its rows and columns parted into the bone wrap (the first `num_wrap_vertices`, given) and the
/// free vertices.
struct PoissonMatrices {
    PoissonMatrices(const RestOperators& rest, int num_wrap_vertices);

    Eigen::SparseMatrix<double> free;      ///< lower triangle of the free part
    Eigen::SparseMatrix<double> coupling;  ///< free rows, columns of the bone wrap
};

}  // namespace ndg
