// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/prism_residuals.h"

#include "ndg/neural/parametrisation.h"

namespace ndg {
namespace {

class PrismResiduals : public OutputSpace {
public:
    PrismResiduals(int num_prisms, const NetworkOptions& options)
        : num_prisms_(num_prisms),
          rotation_(options.rotation),
          parametrisation_(find_parametrisation(options.parametrisation))
    {
    }

    int width() const override { return 9 * num_prisms_; }
    /// Without the rotations, matrices of a limb turn with the joints above it: they cannot be spliced.
    OutputKind kind() const override { return rotation_ ? OutputKind::prism_matrices : OutputKind::other; }

    void target(const PosedBody& posed, const RestOperators& rest, const Eigen::Ref<const PointsF>& vertices,
                float* target) const override
    {
        Eigen::Map<GradientsF>(target, num_prisms_, 9) = rest.residuals(vertices, reference_rotations(posed));
    }

    Points vertices(const PosedBody& posed, RestCache& rest, const float* prediction) const override
    {
        return rest.poisson(posed.body()).reconstruct(gradients(posed, prediction), posed.bone_wrap());
    }

    GradientsF gradients(const PosedBody& posed, const float* prediction) const override
    {
        GradientsF gradients = Eigen::Map<const GradientsF>(prediction, num_prisms_, 9);
        rotate_residuals_in_place(gradients.data(), reference_rotations(posed));
        return gradients;
    }

    torch::Tensor activate(const torch::Tensor& outputs) const override
    {
        return parametrisation_.residuals(outputs.reshape({outputs.size(0), -1, 9})).reshape(outputs.sizes());
    }

    std::string script() const override
    {
        return std::string("    q = y.reshape(-1, 9)\n") + parametrisation_.script +
               "    return f.reshape(y.size(0), -1, 3, 3)\n";
    }

    bool adds_to_neutral() const override { return parametrisation_.kind == ParametrisationKind::direct; }
    bool has_approximate_inverse() const override { return parametrisation_.approximate_inverse != nullptr; }
    void approximate_inverse(const float* prediction, float* outputs) const override
    {
        for (int p = 0; p < num_prisms_; ++p) parametrisation_.approximate_inverse(prediction + 9 * p, outputs + 9 * p);
    }

private:
    /// R_p (NDG equation 11), or the root's rotation for every prism.
    std::vector<Eigen::Matrix3d> reference_rotations(const PosedBody& posed) const
    {
        if (rotation_) return posed.prism_rotations();
        return std::vector<Eigen::Matrix3d>(num_prisms_, posed.pose().parent_from_joint[0]);
    }

    int num_prisms_;
    bool rotation_;
    const Parametrisation& parametrisation_;
};

}  // namespace

std::unique_ptr<OutputSpace> make_prism_residuals(const Template& body_template, const NetworkOptions& options)
{
    return std::make_unique<PrismResiduals>(body_template.num_prisms(), options);
}

}  // namespace ndg
