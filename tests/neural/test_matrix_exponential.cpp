// SPDX-License-Identifier: Apache-2.0
// The exponential kernel against libtorch's own, and against finite differences.
#include "ndg/geometry/matrix_exponential.h"

#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/core/types.h"
#include "ndg/neural/parametrisation.h"
#include "ndg/neural/tensor_exponential.h"

#include <cmath>
#include <limits>
#include <vector>

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;

namespace {

template <typename T>
std::vector<T> random_matrices(int count, double norm)
{
    Random random(3, "matrices", static_cast<std::uint64_t>(norm * 1000));
    std::vector<T> values(static_cast<std::size_t>(9 * count));
    for (T& value : values) value = static_cast<T>(norm * random.uniform(-1, 1) / std::sqrt(3.0));
    return values;
}

template <typename T>
torch::Tensor as_tensor(const std::vector<T>& values)
{
    const auto type = sizeof(T) == 4 ? torch::kFloat32 : torch::kFloat64;
    return torch::from_blob(const_cast<T*>(values.data()), {static_cast<std::int64_t>(values.size()) / 9, 3, 3}, type)
        .clone();
}

template <typename T>
double relative_difference(const torch::Tensor& a, const std::vector<T>& b)
{
    const torch::Tensor other = as_tensor(b);
    return ((a - other).norm() / a.norm()).template item<double>();
}

template <typename T>
void compare_with_torch(double norm, double tolerance)
{
    const std::vector<T> q = random_matrices<T>(101, norm);  // not a multiple of the lanes
    const std::vector<T> weights = random_matrices<T>(101, 1.7);
    std::vector<T> exponentials(q.size()), gradients(q.size());
    matrix_exponential(q.data(), 101, exponentials.data());
    matrix_exponential_adjoint(q.data(), weights.data(), 101, gradients.data());
    torch::Tensor reference = as_tensor(q).requires_grad_();
    const torch::Tensor value = torch::matrix_exp(reference);
    CHECK(relative_difference(value.detach(), exponentials) < tolerance);
    (value * as_tensor(weights)).sum().backward();
    CHECK(relative_difference(reference.grad(), gradients) < tolerance);
}

}  // namespace

TEST_CASE("exponential and adjoint agree with torch::matrix_exp")
{
    for (const double norm : {1e-4, 0.3, 1.0, 4.0, 12.0}) {
        CAPTURE(norm);
        compare_with_torch<double>(norm, 1e-12 * std::max(1.0, norm));
        compare_with_torch<float>(norm, 2e-6 * std::max(1.0, norm));
    }
}

TEST_CASE("exponentials in tensor operations and their derivatives are those of the kernel")
{
    for (const double norm : {0.0, 1e-4, 0.3, 1.0, 4.0, 12.0}) {
        CAPTURE(norm);
        const std::vector<float> q = random_matrices<float>(101, norm), weights = random_matrices<float>(101, 1.7);
        std::vector<float> exponentials(q.size()), gradients(q.size());
        matrix_exponential(q.data(), 101, exponentials.data());
        matrix_exponential_adjoint(q.data(), weights.data(), 101, gradients.data());
        const torch::Tensor input = as_tensor(q).reshape({101, 9}).requires_grad_();
        const torch::Tensor value = tensor_exponential(input);
        (value * as_tensor(weights).reshape({101, 9})).sum().backward();
        CHECK(relative_difference(value.detach().reshape({101, 3, 3}), exponentials) < 1e-6 * std::max(1.0, norm));
        CHECK(relative_difference(input.grad().reshape({101, 3, 3}), gradients) < 1e-6 * std::max(1.0, norm));
    }
    CHECK(tensor_exponential(torch::empty({0, 9})).numel() == 0);
}

TEST_CASE("exponential of zero is the identity and of a skew matrix a rotation")
{
    const std::vector<double> q = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1.2, 0, 1.2, 0, 0, 0, 0, 0};
    std::vector<double> e(18);
    matrix_exponential(q.data(), 2, e.data());
    for (int k = 0; k < 9; ++k) CHECK(e[k] == (k % 4 == 0 ? 1.0 : 0.0));
    CHECK(e[9] == Approx(std::cos(1.2)).epsilon(1e-14));
    CHECK(e[10] == Approx(-std::sin(1.2)).epsilon(1e-14));
    CHECK(e[12] == Approx(std::sin(1.2)).epsilon(1e-14));
    CHECK(e[17] == 1.0);
}

TEST_CASE("adjoint agrees with finite differences")
{
    const std::vector<double> q = random_matrices<double>(5, 2.0), weights = random_matrices<double>(5, 1.0);
    std::vector<double> gradients(q.size());
    matrix_exponential_adjoint(q.data(), weights.data(), 5, gradients.data());
    const auto weighted_sum = [&](const std::vector<double>& values) {
        std::vector<double> e(values.size());
        matrix_exponential(values.data(), 5, e.data());
        double sum = 0;
        for (std::size_t k = 0; k < e.size(); ++k) sum += weights[k] * e[k];
        return sum;
    };
    for (std::size_t k = 0; k < q.size(); ++k) {
        std::vector<double> up = q, down = q;
        const double step = 1e-5;
        up[k] += step;
        down[k] -= step;
        CHECK(gradients[k] == Approx((weighted_sum(up) - weighted_sum(down)) / (2 * step)).epsilon(1e-8).margin(1e-9));
    }
}

TEST_CASE("determinants of exponentials are exp of the trace, hence positive")
{
    const std::vector<float> q = random_matrices<float>(2000, 3.0);
    std::vector<float> e(q.size());
    matrix_exponential(q.data(), 2000, e.data());
    for (std::size_t i = 0; i < 2000; ++i) {
        const Eigen::Matrix3d m =
            Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(e.data() + 9 * i).cast<double>();
        const double trace = static_cast<double>(q[9 * i]) + q[9 * i + 4] + q[9 * i + 8];
        REQUIRE(m.determinant() > 0);
        REQUIRE(m.determinant() == Approx(std::exp(trace)).epsilon(1e-3));
    }
}

TEST_CASE("a matrix's exponential depends neither on its neighbours nor on the threads")
{
    const std::vector<float> q = random_matrices<float>(333, 5.0), weights = random_matrices<float>(333, 1.0);
    std::vector<float> together(q.size()), alone(q.size()), gradient(q.size()), gradient_alone(q.size());
    set_num_threads(1);
    matrix_exponential(q.data(), 333, together.data());
    matrix_exponential_adjoint(q.data(), weights.data(), 333, gradient.data());
    set_num_threads(2);
    for (std::size_t i = 0; i < 333; ++i) {
        matrix_exponential(q.data() + 9 * i, 1, alone.data() + 9 * i);
        matrix_exponential_adjoint(q.data() + 9 * i, weights.data() + 9 * i, 1, gradient_alone.data() + 9 * i);
    }
    CHECK(together == alone);
    CHECK(gradient == gradient_alone);
}

TEST_CASE("non-finite matrices stay non-finite and harm no neighbour")
{
    std::vector<float> q(27, 0.0F), e(27);
    q[0] = std::numeric_limits<float>::quiet_NaN();
    q[9] = std::numeric_limits<float>::infinity();
    matrix_exponential(q.data(), 3, e.data());
    CHECK(!std::isfinite(e[0]));
    CHECK(!std::isfinite(e[9]));
    for (std::size_t k = 0; k < 9; ++k) CHECK(e[18 + k] == (k % 4 == 0 ? 1.0F : 0.0F));
}

TEST_CASE("the differentiable exponential has torch's gradient")
{
    const torch::Tensor q = as_tensor(random_matrices<float>(60, 1.0)).reshape({4, 15, 9});
    torch::Tensor ours = q.clone().requires_grad_(), theirs = q.clone().requires_grad_();
    differentiable_exponential(ours).square().sum().backward();
    torch::matrix_exp(theirs.reshape({4, 15, 3, 3})).square().sum().backward();
    CHECK((ours.grad() - theirs.grad()).abs().max().item<double>() < 2e-5);
}
