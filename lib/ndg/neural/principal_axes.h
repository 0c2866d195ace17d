// SPDX-License-Identifier: Apache-2.0
// Principal components of many long rows that are never held together.
#pragma once

#include "ndg/core/types.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace ndg {

/// A matrix given row by row.
struct RowSource {
    int num_rows = 0;
    Eigen::Index num_cols = 0;
    /// Writes a row, the same whenever asked; called by several threads at once.
    std::function<void(int row_idx, float* values)> row;
};

/// The leading axes about zero, by falling share.
struct PrincipalAxes {
    RowMatrixF axes;             ///< k x columns, orthonormal
    Eigen::VectorXd root_means;  ///< k, root mean square of the rows' coefficients
    double explained = 0;        ///< share of the rows' sum of squares that the axes hold, 0..1
};

/// At most `max_axes` axes, and no more than hold `share` (0..1] of the sum of squares; fewer where the rows have no
/// more. Randomised subspace iteration (Halko, Martinsson, Tropp 2011, algorithm 4.4 with two iterations and 20 axes to
/// spare); exact up to rounding where there are at most max_axes + 20 rows. Passes over the rows: four, or two. Memory:
/// 12 bytes a column and axis, beside 64 rows. Depends on the rows and `seed`, not on the processor's load; on several
/// threads sums may differ in rounding. Throws InputError where all rows are zero.
PrincipalAxes principal_axes(const RowSource& source, int max_axes, double share, std::uint64_t seed);
/// The same of some of the columns, for each of the blocks, in passes that they share. Axes have the block's columns.
std::vector<PrincipalAxes> principal_axes(const RowSource& source, const std::vector<std::vector<int>>& blocks,
                                          int max_axes, double share, std::uint64_t seed);

}  // namespace ndg
