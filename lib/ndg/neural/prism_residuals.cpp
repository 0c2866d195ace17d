// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/prism_residuals.h"

#include "ndg/neural/parametrisation.h"

namespace ndg {
namespace {

class PrismResiduals : public OutputSpace {
public:
    PrismResiduals(const Template& body_template, const NetworkOptions& options)
        : skeleton_(body_template.skeleton),
          prism_weights_(body_template.prism_weights()),
          rotation_(options.rotation),
          parametrisation_(find_parametrisation(options.parametrisation))
    {
    }

    int width() const override { return 9 * num_prisms(); }

    void target(const Body&, const RestOperators& rest, const Pose& pose, const Eigen::Ref<const PointsF>& vertices,
                float* target) const override
    {
        Eigen::Map<GradientsF>(target, num_prisms(), 9) = rest.residuals(vertices, reference_rotations(pose));
    }

    GradientsF gradients(const Pose& pose, const float* prediction) const override
    {
        GradientsF gradients = Eigen::Map<const GradientsF>(prediction, num_prisms(), 9);
        rotate_residuals_in_place(gradients.data(), reference_rotations(pose));
        return gradients;
    }

    torch::Tensor activate(const torch::Tensor& outputs) const override
    {
        return parametrisation_.residuals(outputs.reshape({outputs.size(0), -1, 9})).reshape(outputs.sizes());
    }

    bool has_approximate_inverse() const override { return parametrisation_.approximate_inverse != nullptr; }
    void approximate_inverse(const float* prediction, float* outputs) const override
    {
        for (int p = 0; p < num_prisms(); ++p)
            parametrisation_.approximate_inverse(prediction + 9 * p, outputs + 9 * p);
    }

private:
    int num_prisms() const { return static_cast<int>(prism_weights_.size()); }

    /// R_p (NDG equation 11), or the root's rotation for every prism.
    std::vector<Eigen::Matrix3d> reference_rotations(const Pose& pose) const
    {
        if (!rotation_) return std::vector<Eigen::Matrix3d>(num_prisms(), pose.parent_from_joint.at(0));
        // Rotations do not depend on where the joints are.
        return blend_rotations(prism_weights_,
                               forward_kinematics(skeleton_, Points::Zero(skeleton_.num_joints(), 3), pose));
    }

    Skeleton skeleton_;
    SkinningWeights prism_weights_;
    bool rotation_;
    const Parametrisation& parametrisation_;
};

}  // namespace

std::unique_ptr<OutputSpace> make_prism_residuals(const Template& body_template, const NetworkOptions& options)
{
    return std::make_unique<PrismResiduals>(body_template, options);
}

}  // namespace ndg
