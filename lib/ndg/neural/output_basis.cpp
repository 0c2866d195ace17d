// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/output_basis.h"

#include "ndg/core/log.h"
#include "ndg/neural/principal_axes.h"

#include <algorithm>
#include <vector>

namespace ndg {
namespace {

/// Of which the changed samples are drawn; no epoch of training.
constexpr int basis_epoch = -1;

}  // namespace

std::vector<RowMatrixF> fit_output_bases(const TrainingSet& set, const Augmentation* augmentation,
                                         const OutputSpace& output_space, const std::vector<NetworkColumns>& columns,
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
    const int most = options.output_basis;
    const double share = options.output_basis_variance;
    std::vector<PrincipalAxes> all;
    if (columns.empty()) {
        all.push_back(principal_axes(outputs, most, share, seed));
    } else {
        std::vector<std::vector<int>> blocks;
        for (const NetworkColumns& of_network : columns) blocks.push_back(of_network.outputs);
        all = principal_axes(outputs, blocks, most, share, seed);
    }
    std::vector<RowMatrixF> bases;
    Eigen::Index count = 0;
    double least = 1;
    for (const PrincipalAxes& principal : all) {
        bases.push_back(principal.root_means.cast<float>().asDiagonal() * principal.axes);
        count += principal.axes.rows();
        least = std::min(least, principal.explained);
    }
    log_info("output basis: {} components hold {}{:.3f} % of the squares of {} outputs", count,
             all.size() > 1 ? "in each region at least " : "", 100 * least, outputs.num_rows);
    return bases;
}

}  // namespace ndg
