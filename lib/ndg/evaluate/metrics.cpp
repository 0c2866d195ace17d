// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/metrics.h"

#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"

#include <algorithm>

namespace ndg {

BodyMetrics::BodyMetrics(const Eigen::Ref<const Points>& rest_vertices, const Eigen::Ref<const Prisms>& prisms,
                         int num_wrap_vertices)
    : prisms_(prisms), num_wrap_vertices_(num_wrap_vertices), num_vertices_(rest_vertices.rows())
{
    require_input(prisms.rows() > 0, "There are no prisms to evaluate");
    require_input(num_wrap_vertices > 0 && num_wrap_vertices < num_vertices_,
                  "{} of {} volume vertices are said to be bone wrap; at least one must be, and one must be free",
                  num_wrap_vertices, num_vertices_);
    require_input(prisms.minCoeff() >= 0 && prisms.maxCoeff() < num_vertices_,
                  "A prism index lies outside the {} volume vertices", num_vertices_);
    rest_volumes_ = prism_volumes(rest_vertices, prisms);
    for (Eigen::Index p = 0; p < rest_volumes_.size(); ++p)
        require_input(rest_volumes_[p] > 0, "Rest prism {} has volume {:.3e} m^3; rest prisms must be positive", p,
                      rest_volumes_[p]);
    gradient_ = gradient_operator(rest_vertices, prisms);
}

SampleMetrics BodyMetrics::evaluate(const Eigen::Ref<const Points>& reference,
                                    const Eigen::Ref<const Points>& prediction) const
{
    require(reference.rows() == num_vertices_ && prediction.rows() == num_vertices_,
            "Metrics compare {} and {} vertices on a body of {}", reference.rows(), prediction.rows(), num_vertices_);
    SampleMetrics metrics;
    const Points difference = prediction - reference;
    const Eigen::Index num_free = num_vertices_ - num_wrap_vertices_;
    metrics.position_error_mm = 1e3 * difference.bottomRows(num_free).rowwise().norm().sum() / double(num_free);
    // G is linear, so the difference of gradients is the gradient of the difference.
    metrics.gradient_error =
        deformation_gradients(gradient_, difference).squaredNorm() / (9.0 * double(prisms_.rows()));
    const Eigen::VectorXd volumes = prism_volumes(prediction, prisms_);
    for (Eigen::Index p = 0; p < volumes.size(); ++p) {
        if (volumes[p] < 0.0) metrics.inverted_prisms += 1.0;
        if (prism_min_corner_jacobian(gather_prism(prediction, prisms_, p)) < 0.0) {
            metrics.corner_inverted_prisms += 1.0;
        }
        const double change = volumes[p] / rest_volumes_[p] - 1.0;
        metrics.volume_error += change * change / double(volumes.size());
        const int bin = int(std::clamp((change + 1.0) * volume_bins / 2, 0.0, volume_bins - 1.0));
        metrics.volume_changes[bin] += 1.0 / double(volumes.size());
    }
    return metrics;
}

SampleMetrics mean_metrics(const std::vector<SampleMetrics>& samples)
{
    require(!samples.empty(), "There is no sample to average over");
    SampleMetrics mean;
    for (const SampleMetrics& sample : samples) {
        mean.position_error_mm += sample.position_error_mm;
        mean.gradient_error += sample.gradient_error;
        mean.inverted_prisms += sample.inverted_prisms;
        mean.corner_inverted_prisms += sample.corner_inverted_prisms;
        mean.volume_error += sample.volume_error;
        for (int bin = 0; bin < volume_bins; ++bin) mean.volume_changes[bin] += sample.volume_changes[bin];
    }
    const double scale = 1.0 / double(samples.size());
    mean.position_error_mm *= scale;
    mean.gradient_error *= scale;
    mean.inverted_prisms *= scale;
    mean.corner_inverted_prisms *= scale;
    mean.volume_error *= scale;
    for (double& share : mean.volume_changes) share *= scale;
    return mean;
}

}  // namespace ndg
