// SPDX-License-Identifier: Apache-2.0
// Internal to this module (includes libtorch): targets in the space of a fixed basis' coefficients.
#pragma once

#include "ndg/core/types.h"
#include "ndg/neural/augmentation.h"
#include "ndg/neural/network.h"

#include <vector>

namespace ndg {

/// The coefficients of each training target in the bases of a network's parts, whose rows are orthogonal; side by side
/// in the order of the parts. Projected once, K numbers a sample: mirror images and splices are linear, so theirs are
/// sums of what is kept of each splice region and its mirror image (12 K numbers a sample with both). Needs an output
/// space that adds to the neutral prediction.
class Coefficients {
public:
    /// `augmentation` may be null; not kept.
    Coefficients(const TrainingSet& set, const Augmentation* augmentation, const OutputSpace& output_space,
                 const Network& network);

    /// K.
    int width() const { return static_cast<int>(squared_norms_.size()); }
    /// Of a sample, changed as Augmentation::target changes it; width() numbers.
    void of_sample(int sample_idx, const SampleChange& change, float* coefficients) const;
    /// Of the bases' rows, K: what a coefficient's square weighs in the squared error of the outputs.
    const Eigen::VectorXd& squared_norms() const { return squared_norms_; }
    /// Mean over the unchanged samples of the sum of squares that the bases cannot hold.
    double mean_remainder() const { return mean_remainder_; }

private:
    /// What a basis has to do with some columns of the targets.
    struct Projection {
        std::vector<int> columns;
        RowMatrixF rows;  ///< coefficients x columns
        int first = 0;    ///< column of kept_ that the first coefficient goes to
    };
    std::vector<Projection> find_projections(const Augmentation* augmentation, const Network& network) const;
    int place(int region, bool mirrored) const { return (mirrored ? num_regions_ : 0) + region; }

    int num_regions_ = 1;
    Eigen::VectorXd squared_norms_;
    RowMatrixF kept_;  ///< samples x K times regions and images
    double mean_remainder_ = 0;
};

}  // namespace ndg
