// SPDX-License-Identifier: Apache-2.0
// The error measures of NDG 5.1, with the corrections of docs (mean over free vertices, mean over prisms).
#pragma once

#include "ndg/core/types.h"

#include <Eigen/SparseCore>

#include <array>
#include <vector>

namespace ndg {

/// Prisms by V_deformed / V_rest - 1: bins of equal width from -1 to 1, the first and the last with all beyond.
constexpr int volume_bins = 80;
using VolumeHistogram = std::array<double, volume_bins>;
constexpr double volume_bin_centre(int bin)
{
    return -1.0 + (2.0 * bin + 1.0) / volume_bins;
}

/// The figures of one posed body, or their average over samples.
struct SampleMetrics {
    double position_error_mm = 0;       ///< E_pos: mean distance over the free vertices, millimetre
    double gradient_error = 0;          ///< E_grad: |G X - G X_hat|^2 / (9 N_p)
    double inverted_prisms = 0;         ///< E_inv: number of prisms with exact volume < 0
    double corner_inverted_prisms = 0;  ///< E_corner: number of prisms with a negative Jacobian at a corner
    double volume_error = 0;            ///< E_vol: mean over prisms of (V_deformed / V_rest - 1)^2
    VolumeHistogram volume_changes{};   ///< share of the prisms in each bin
};

/// What the metrics of one body need, computed once from its rest shape.
class BodyMetrics {
public:
    /// `rest_vertices`: N_v x 3 = [bone wrap; muscle wrap; skin] with `num_wrap_vertices` rows each. The bone wrap is
    /// prescribed in every method and does not count in E_pos. Throws InputError for a rest prism that is flat or
    /// inverted, or indices or counts that do not fit.
    BodyMetrics(const Eigen::Ref<const Points>& rest_vertices, const Eigen::Ref<const Prisms>& prisms,
                int num_wrap_vertices);

    /// `reference`, `prediction`: N_v x 3 deformed vertices. Throws Error for another number of rows.
    SampleMetrics evaluate(const Eigen::Ref<const Points>& reference, const Eigen::Ref<const Points>& prediction) const;

private:
    Prisms prisms_;
    int num_wrap_vertices_;
    Eigen::Index num_vertices_;
    Eigen::SparseMatrix<double> gradient_;
    Eigen::VectorXd rest_volumes_;
};

/// Averages over samples; throws Error for none.
SampleMetrics mean_metrics(const std::vector<SampleMetrics>& samples);

}  // namespace ndg
