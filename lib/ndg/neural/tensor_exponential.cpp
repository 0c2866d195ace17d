// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/tensor_exponential.h"

#include <torch/csrc/autograd/custom_function.h>

#include <vector>

namespace ndg {
namespace {

using torch::Tensor;

// As in matrix_exponential.cpp.
constexpr double scaled_norm = 0.5;
constexpr int taylor_degree = 8;
constexpr double max_squarings = 16;

// Matrices are 3 x 3 x count here: a product is one multiplication of large arrays and one sum.

Tensor matrix_products(const Tensor& a, const Tensor& b)
{
    return (a.unsqueeze(2) * b.unsqueeze(0)).sum(1);
}

Tensor transposed(const Tensor& a)
{
    return a.transpose(0, 1);
}

Tensor side_by_side(const Tensor& matrices)
{
    return matrices.reshape({-1, 9}).t().contiguous().view({3, 3, -1});
}

Tensor one_after_the_other(const Tensor& arrays, const Tensor& like)
{
    return arrays.reshape({9, -1}).t().reshape(like.sizes());
}

/// The exponentials, with all that is needed to go the way back.
struct Evaluation {
    Tensor scaled, scale;         ///< 3 x 3 x count, at most `scaled_norm` each; count
    Tensor squarings;             ///< count
    std::vector<Tensor> partial;  ///< Horner's sum before step k, k = 0 .. taylor_degree
    std::vector<Tensor> powers;   ///< before each squaring, and the result
};

Evaluation evaluate(const Tensor& matrices)
{
    Evaluation e;
    const Tensor a = side_by_side(matrices);
    const Tensor ratio = a.square().sum(at::IntArrayRef({0, 1})).sqrt() / scaled_norm;
    e.squarings = ratio.log2().floor().add(1).nan_to_num(0, 0, 0).clamp(0, max_squarings);
    e.scale = torch::pow(2.0, e.squarings.neg()).to(a.dtype());
    e.scaled = a * e.scale;
    const Tensor identity = torch::eye(3, a.options()).unsqueeze(2);
    e.partial.resize(taylor_degree + 1);
    e.partial[taylor_degree] = identity.expand_as(a);
    for (int k = taylor_degree; k >= 1; --k)
        e.partial[k - 1] = matrix_products(e.scaled, e.partial[k]).div_(k).add_(identity);
    e.powers.push_back(e.partial[0]);
    const int most = a.size(2) > 0 ? e.squarings.max().item<int>() : 0;
    for (int level = 0; level < most; ++level)
        e.powers.push_back(
            torch::where(e.squarings > level, matrix_products(e.powers[level], e.powers[level]), e.powers[level]));
    return e;
}

struct TensorExponential : torch::autograd::Function<TensorExponential> {
    static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& matrices)
    {
        const Evaluation e = evaluate(matrices);
        torch::autograd::variable_list kept = {e.scaled, e.scale, e.squarings};
        kept.insert(kept.end(), e.partial.begin(), e.partial.end());
        kept.insert(kept.end(), e.powers.begin(), e.powers.end());
        context->save_for_backward(kept);
        return one_after_the_other(e.powers.back(), matrices);
    }

    static torch::autograd::tensor_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::tensor_list gradients)
    {
        const torch::autograd::variable_list kept = context->get_saved_variables();
        const Tensor &scaled = kept[0], &scale = kept[1], &squarings = kept[2];
        const Tensor* partial = &kept[3];
        const Tensor* powers = partial + taylor_degree + 1;
        const auto num_squarings = static_cast<int>(kept.size()) - (3 + taylor_degree + 1) - 1;
        Tensor gradient = side_by_side(gradients[0]);
        for (int level = num_squarings - 1; level >= 0; --level) {  // of x_{i+1} = x_i x_i
            const Tensor power = transposed(powers[level]);
            gradient = torch::where(squarings > level,
                                    matrix_products(power, gradient).add_(matrix_products(gradient, power)), gradient);
        }
        Tensor total = torch::zeros_like(scaled);
        for (int k = 1; k <= taylor_degree; ++k) {  // of p_{k-1} = I + a p_k / k
            total.add_(matrix_products(gradient, transposed(partial[k])), 1.0 / k);
            gradient = matrix_products(transposed(scaled), gradient).div_(k);
        }
        return {one_after_the_other(total.mul_(scale), gradients[0])};
    }
};

}  // namespace

torch::Tensor tensor_exponential(const torch::Tensor& matrices)
{
    return TensorExponential::apply(matrices);
}

}  // namespace ndg
