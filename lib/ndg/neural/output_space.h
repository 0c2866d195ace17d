// SPDX-License-Identifier: Apache-2.0
// What a network predicts for a body in a pose. Nothing else in this module knows what the predicted numbers mean.
#pragma once

#include "ndg/deform/posed_body.h"
#include "ndg/deform/rest_cache.h"
#include "ndg/neural/options.h"

#include <memory>
#include <vector>

namespace at {
class Tensor;
}

namespace ndg {

/// What the predicted numbers are, for those who change samples without posing them (augmentation.h): a 3 x 3 matrix a
/// prism that a mirror conjugates, a vector a free vertex (muscle wrap, then skin), or something else.
enum class OutputKind { prism_matrices, vertex_vectors, other };

/// The network gives width() raw outputs a sample; the activation turns them into a prediction of as many numbers. By
/// default the raw outputs are the prediction. Constant once made, so several threads may use one.
class OutputSpace {
public:
    virtual ~OutputSpace() = default;

    virtual int width() const = 0;
    virtual OutputKind kind() const { return OutputKind::other; }

    /// What should have been predicted where the posed body has these deformed volume vertices (N_v x 3, world).
    /// `rest`: of that body. Writes width() numbers.
    virtual void target(const PosedBody& posed, const RestOperators& rest, const Eigen::Ref<const PointsF>& vertices,
                        float* target) const = 0;

    /// Volume vertices that a prediction gives the posed body, N_v x 3; the first N_w rows are the bone wrap.
    virtual Points vertices(const PosedBody& posed, RestCache& rest, const float* prediction) const = 0;

    /// F_p of every prism, world frame: what PoissonReconstruction::reconstruct takes. Throws InputError where
    /// predictions are nothing of the kind.
    virtual GradientsF gradients(const PosedBody& posed, const float* prediction) const;

    /// Predictions of raw outputs, (B, width()) to the same shape, differentiable, on any device. Who overrides it says
    /// so in adds_to_neutral.
    virtual at::Tensor activate(const at::Tensor& outputs) const;

    /// Lines of TorchScript, indented by four, that return the prediction of raw outputs y (B x width()) in the shape
    /// that is handed out (torchscript.h).
    virtual std::string script() const;

    /// Whether predictions are the neutral one and the raw outputs added, so that approximate_inverse is exact.
    virtual bool adds_to_neutral() const { return true; }

    /// Whether there is an approximate_inverse; a fixed basis of outputs needs one.
    virtual bool has_approximate_inverse() const { return true; }
    /// Raw outputs whose prediction is near this one; zeros for the neutral prediction.
    virtual void approximate_inverse(const float* prediction, float* outputs) const;
};

/// The prediction of zero outputs, where every network starts: the animation without a network.
std::vector<float> neutral_prediction(const OutputSpace& space);

/// The space that `options.output_space` names. Throws InputError for a name that the table in output_space.cpp lacks.
std::unique_ptr<OutputSpace> make_output_space(const Template& body_template, const NetworkOptions& options);
std::vector<std::string> output_space_names();

}  // namespace ndg
