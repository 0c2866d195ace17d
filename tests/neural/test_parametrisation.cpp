// SPDX-License-Identifier: Apache-2.0
// From nine numbers to a residual: every parametrisation against Eigen, finite differences and its inverse.
#include "ndg/neural/parametrisation.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/neural/options.h"

#include <unsupported/Eigen/MatrixFunctions>

#include <map>
#include <string>

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;

namespace {

using RowMatrix3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

/// (2, 7, 9), entries of +-0.8.
torch::Tensor some_numbers()
{
    Random random(5, "parametrisation");
    torch::Tensor q = torch::empty({2, 7, 9});
    for (int k = 0; k < q.numel(); ++k) q.data_ptr<float>()[k] = static_cast<float>(random.uniform(-0.8, 0.8));
    return q;
}

Eigen::Matrix3d matrix_at(const torch::Tensor& tensor, int idx)
{
    return Eigen::Map<const RowMatrix3f>(tensor.contiguous().data_ptr<float>() + 9 * idx).cast<double>();
}

Eigen::Matrix3d positive_upper_triangular(const Eigen::Matrix3d& q)
{
    Eigen::Matrix3d result = q.triangularView<Eigen::StrictlyUpper>();
    result.diagonal() = q.diagonal().array().exp();
    return result;
}

/// What options.h says of each, in Eigen's terms.
Eigen::Matrix3d expected_residual(const std::string& name, const Eigen::Matrix3d& q)
{
    const Eigen::Matrix3d lower = q.triangularView<Eigen::StrictlyLower>();
    if (name == "exponential") return q.exp();
    if (name == "direct") return Eigen::Matrix3d::Identity() + q;
    if (name == "lu") return (Eigen::Matrix3d::Identity() + lower) * positive_upper_triangular(q);
    return Eigen::Matrix3d(lower - lower.transpose()).exp() * positive_upper_triangular(q);
}

}  // namespace

TEST_CASE("every parametrisation is what it says and gives the identity for zero")
{
    const torch::Tensor q = some_numbers();
    for (const std::string& name : names<ParametrisationKind>()) {
        CAPTURE(name);
        const Parametrisation& parametrisation = find_parametrisation(parse_name<ParametrisationKind>(name));
        CHECK(to_name(parametrisation.kind) == name);
        const torch::Tensor residuals = parametrisation.residuals(q);
        REQUIRE(residuals.sizes() == q.sizes());
        for (int i = 0; i < 14; ++i)
            CHECK((matrix_at(residuals, i) - expected_residual(name, matrix_at(q, i))).norm() < 2e-6);
        const torch::Tensor neutral = parametrisation.residuals(torch::zeros_like(q));
        for (int i = 0; i < 14; ++i) CHECK(matrix_at(neutral, i) == Eigen::Matrix3d::Identity());
    }
}

TEST_CASE("derivatives of every parametrisation agree with finite differences")
{
    const torch::Tensor q = some_numbers();
    const torch::Tensor weights = some_numbers().flip({1});
    for (const std::string& name : names<ParametrisationKind>()) {
        CAPTURE(name);
        const auto weighted_sum = [&](const torch::Tensor& numbers) {
            return (find_parametrisation(parse_name<ParametrisationKind>(name)).residuals(numbers) * weights)
                .to(torch::kFloat64)
                .sum();
        };
        torch::Tensor traced = q.clone().requires_grad_();
        weighted_sum(traced).backward();
        REQUIRE(traced.grad().abs().max().item<double>() > 0.5);
        for (int k = 0; k < q.numel(); ++k) {
            constexpr float step = 0.01F;
            torch::Tensor up = q.clone(), down = q.clone();
            up.data_ptr<float>()[k] += step;
            down.data_ptr<float>()[k] -= step;
            const double difference = weighted_sum(up).item<double>() - weighted_sum(down).item<double>();
            const double width = static_cast<double>(up.data_ptr<float>()[k]) - down.data_ptr<float>()[k];
            CHECK(traced.grad().data_ptr<float>()[k] == Approx(difference / width).margin(4e-4));
        }
    }
}

TEST_CASE("inverses are exact for rotations and for stretches, and finite for inverted prisms")
{
    const RowMatrix3f rotation =
        Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix().cast<float>();
    RowMatrix3f stretch;
    stretch << 1.3F, 0.1F, 0.2F, 0.1F, 0.8F, -0.1F, 0.2F, -0.1F, 1.1F;
    RowMatrix3f inverted = stretch;
    inverted.col(0) *= -1;
    for (const std::string& name : names<ParametrisationKind>()) {
        CAPTURE(name);
        const Parametrisation& parametrisation = find_parametrisation(parse_name<ParametrisationKind>(name));
        CHECK((parametrisation.approximate_inverse != nullptr) == (name == "exponential" || name == "direct"));
        if (!parametrisation.approximate_inverse) continue;
        RowMatrix3f q;
        for (const RowMatrix3f& residual : {rotation, stretch}) {
            parametrisation.approximate_inverse(residual.data(), q.data());
            const torch::Tensor back = parametrisation.residuals(torch::from_blob(q.data(), {1, 1, 9}));
            CHECK((matrix_at(back, 0) - residual.cast<double>()).norm() < 1e-5);
            if (name == "exponential")
                CHECK((q.cast<double>() - Eigen::Matrix3d(residual.cast<double>()).log()).norm() < 1e-5);
        }
        parametrisation.approximate_inverse(inverted.data(), q.data());
        CHECK(q.allFinite());
    }
}
