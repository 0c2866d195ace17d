// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/parametrisation.h"

#include "ndg/core/error.h"
#include "ndg/geometry/matrix_exponential.h"
#include "ndg/neural/tensor_exponential.h"

#include <torch/csrc/autograd/custom_function.h>
#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <vector>

namespace ndg {
namespace {

using torch::Tensor;
using Matrix3fRow = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

constexpr double smallest_stretch = 0.05;

std::size_t num_matrices(const Tensor& tensor)
{
    return static_cast<std::size_t>(tensor.numel() / 9);
}

struct ExponentialFunction : torch::autograd::Function<ExponentialFunction> {
    static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& matrices)
    {
        const Tensor input = matrices.contiguous();
        Tensor output = torch::empty_like(input);
        matrix_exponential(input.data_ptr<float>(), num_matrices(input), output.data_ptr<float>());
        context->save_for_backward({input});
        return output;
    }

    static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::tensor_list gradients)
    {
        const Tensor input = context->get_saved_variables()[0];
        const Tensor gradient = gradients[0].contiguous();
        Tensor result = torch::empty_like(input);
        matrix_exponential_adjoint(input.data_ptr<float>(), gradient.data_ptr<float>(), num_matrices(input),
                                   result.data_ptr<float>());
        return {result};
    }
};

/// log(R) + log(S) of the polar decomposition F = R S, with the stretches raised to at least `smallest_stretch` so that
/// it exists for inverted prisms too. Equal to log(F) where R and S commute.
void exponential_inverse(const float* residual, float* q)
{
    const Eigen::Matrix3d gradient = Eigen::Map<const Matrix3fRow>(residual).cast<double>();
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    const Eigen::Matrix3d& v = svd.matrixV();
    Eigen::Vector3d stretches = svd.singularValues();
    if ((u * v.transpose()).determinant() < 0) {
        u.col(2) *= -1;
        stretches[2] *= -1;
    }
    stretches = stretches.cwiseMax(smallest_stretch);
    const Eigen::AngleAxisd rotation{Eigen::Matrix3d(u * v.transpose())};
    const Eigen::Vector3d axis = rotation.angle() * rotation.axis();
    Eigen::Matrix3d log_rotation;
    log_rotation << 0, -axis.z(), axis.y(), axis.z(), 0, -axis.x(), -axis.y(), axis.x(), 0;
    const Matrix3fRow logarithm =
        (log_rotation + v * stretches.array().log().matrix().asDiagonal() * v.transpose()).cast<float>();
    std::copy_n(logarithm.data(), 9, q);
}

Tensor direct(const Tensor& q)
{
    return q + torch::eye(3, q.options()).reshape({1, 1, 9});
}

void direct_inverse(const float* residual, float* q)
{
    // In double: the difference is exact, its rounding is the only one.
    for (int k = 0; k < 9; ++k) q[k] = static_cast<float>(static_cast<double>(residual[k]) - (k % 4 == 0 ? 1.0 : 0.0));
}

/// left times (exp(Q00) Q01 Q02; 0 exp(Q11) Q12; 0 0 exp(Q22)), given the nine entries of Q.
Tensor times_positive_upper_triangular(const Tensor& left, const std::vector<Tensor>& q)
{
    const Tensor zero = torch::zeros_like(q[0]);
    const Tensor right = torch::stack({q[0].exp(), q[1], q[2], zero, q[4].exp(), q[5], zero, zero, q[8].exp()}, -1);
    return torch::bmm(left.reshape({-1, 3, 3}), right.reshape({-1, 3, 3})).reshape(left.sizes());
}

Tensor lu(const Tensor& matrices)
{
    const std::vector<Tensor> q = matrices.unbind(-1);
    const Tensor zero = torch::zeros_like(q[0]), one = torch::ones_like(q[0]);
    return times_positive_upper_triangular(torch::stack({one, zero, zero, q[3], one, zero, q[6], q[7], one}, -1), q);
}

Tensor qr(const Tensor& matrices)
{
    const std::vector<Tensor> q = matrices.unbind(-1);
    const Tensor zero = torch::zeros_like(q[0]);
    const Tensor skew = torch::stack({zero, -q[3], -q[6], q[3], zero, -q[7], q[6], q[7], zero}, -1);
    return times_positive_upper_triangular(differentiable_exponential(skew), q);
}

const char* const exponential_script = "    f = torch.matrix_exp(q.reshape(-1, 3, 3))\n";
const char* const direct_script = "    f = q.reshape(-1, 3, 3) + torch.eye(3, device=q.device)\n";
const char* const upper_script = R"(
    o = torch.zeros_like(q[:, 0])
    d = torch.exp(q)
    upper = torch.stack([d[:, 0], q[:, 1], q[:, 2], o, d[:, 4], q[:, 5], o, o, d[:, 8]], 1).reshape(-1, 3, 3)
)";
const std::string lu_script = std::string(upper_script) + R"(
    e = torch.ones_like(o)
    lower = torch.stack([e, o, o, q[:, 3], e, o, q[:, 6], q[:, 7], e], 1).reshape(-1, 3, 3)
    f = torch.bmm(lower, upper)
)";
const std::string qr_script = std::string(upper_script) + R"(
    skew = torch.stack([o, -q[:, 3], -q[:, 6], q[:, 3], o, -q[:, 7], q[:, 6], q[:, 7], o], 1).reshape(-1, 3, 3)
    f = torch.bmm(torch.matrix_exp(skew), upper)
)";

const Parametrisation parametrisations[] = {
    {ParametrisationKind::exponential, differentiable_exponential, exponential_script, exponential_inverse},
    {ParametrisationKind::direct, direct, direct_script, direct_inverse},
    {ParametrisationKind::lu, lu, lu_script.c_str(), nullptr},
    {ParametrisationKind::qr, qr, qr_script.c_str(), nullptr},
};

}  // namespace

const Parametrisation& find_parametrisation(ParametrisationKind kind)
{
    for (const Parametrisation& candidate : parametrisations)
        if (kind == candidate.kind) return candidate;
    throw Error(fmt::format("the parametrisation {} has no row", to_name(kind)));
}

torch::Tensor differentiable_exponential(const torch::Tensor& matrices)
{
    if (matrices.device().is_cpu()) return ExponentialFunction::apply(matrices);
    return tensor_exponential(matrices);
}

}  // namespace ndg
