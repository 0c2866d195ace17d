// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/output_basis.h"

#include "ndg/core/log.h"
#include "ndg/neural/principal_axes.h"

#include <vector>

namespace ndg {
namespace {

/// Of which the changed samples are drawn; no epoch of training.
constexpr int basis_epoch = -1;

}  // namespace

RowMatrixF fit_output_basis(const TrainingSet& set, const Augmentation* augmentation, const OutputSpace& output_space,
                            const NetworkOptions& options, std::uint64_t seed)
{
    RowSource outputs;
    outputs.num_rows = augmentation ? 2 * set.size() : set.size();
    outputs.num_cols = output_space.width();
    outputs.row = [&](int row_idx, float* values) {
        std::vector<float> target(output_space.width());
        const int sample_idx = row_idx % set.size();
        if (row_idx < set.size())
            set.target(sample_idx, target.data());
        else
            augmentation->target(sample_idx, augmentation->draw(sample_idx, basis_epoch), target.data());
        output_space.approximate_inverse(target.data(), values);
    };
    PrincipalAxes principal = principal_axes(outputs, options.output_basis, options.output_basis_variance, seed);
    log_info("output basis: {} components hold {:.3f} % of the squares of {} outputs", principal.axes.rows(),
             100 * principal.explained, outputs.num_rows);
    return principal.root_means.cast<float>().asDiagonal() * principal.axes;
}

}  // namespace ndg
