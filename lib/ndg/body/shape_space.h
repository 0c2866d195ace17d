// SPDX-License-Identifier: Apache-2.0
// PCA of rest shapes (NDG equation 13).
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

struct ShapeSpace {
    Eigen::VectorXd mean;                 ///< 3 N_v, row-major flattening of N_v x 3
    Eigen::MatrixXd components;           ///< 3 N_v x d, orthonormal columns
    Eigen::VectorXd standard_deviations;  ///< d, of the training codes
    double explained_variance = 0;        ///< share kept by the d components

    int dimension() const { return static_cast<int>(components.cols()); }
    Eigen::VectorXd encode(const Eigen::Ref<const Points>& volume_vertices) const;
    Points decode(const Eigen::Ref<const Eigen::VectorXd>& code) const;
};

/// Components up to `max_components`, or fewer where they explain `variance` (0..1] of the training variance. Any
/// number of shapes from two on, all of one size: by the shapes' inner products, or by the coordinates' where these are
/// fewer. Throws InputError for fewer or equal shapes.
ShapeSpace fit_shape_space(const std::vector<const Points*>& rest_shapes, int max_components, double variance);

/// Share of the training variance that the first 1, 2, ..., d components explain.
Eigen::VectorXd explained_variances(const ShapeSpace& space);

/// Distances of the vertices of shapes decoded from the first `dimension` numbers of their code to the true ones.
struct ReconstructionErrors {
    std::vector<double> means;  ///< of each shape, m
    double largest = 0;         ///< of any vertex of any shape, m
};
ReconstructionErrors reconstruction_errors(const ShapeSpace& space, const std::vector<const Points*>& rest_shapes,
                                           int dimension);

void write_shape_space(const std::string& path, const ShapeSpace& space, const Eigen::Ref<const RowMatrix>& codes,
                       const std::vector<double>& reconstruction_errors, const Provenance& provenance);
ShapeSpace read_shape_space(const std::string& path);

}  // namespace ndg
