// SPDX-License-Identifier: Apache-2.0
// Where energy terms add what their elements contribute. Kernels hold several elements side by side: entry k of one of
// them is values[Step * k].
#pragma once

#include "ndg/elastic/element_places.h"

#include <Eigen/Core>

#include <array>
#include <cmath>

namespace ndg {

/// How an element's Hessian enters the sum.
enum class HessianKind {
    exact,
    nearly_exact,  ///< made positive semi-definite where its smallest eigenvalue is far below zero
    projected,     ///< made positive semi-definite (Teran et al. 2005)
    gauss_newton,  ///< the same; hinges with the stiffness of their angle alone
};

/// Joule, in four partial sums that a term with four elements side by side keeps apart.
struct EnergySum {
    std::array<double, 4> parts{};
    double total() const { return (parts[0] + parts[2]) + (parts[1] + parts[3]); }
};

/// d energy / d unknowns, N, and per unknown the sum over elements of the absolute force each contributes there.
class ForceSum {
public:
    ForceSum(Eigen::VectorXd& gradient, Eigen::VectorXd& absolute)
        : gradient_(gradient.data()), absolute_(absolute.data())
    {
    }

    /// What an element has on its first `Corners` corners: entry 3 a + c is along coordinate c of corner a.
    template <int Corners, int Step = 1>
    void add(const int* unknown, const double* values)
    {
        for (int a = 0; a < Corners; ++a) {
            if (unknown[a] < 0) continue;
            for (int c = 0; c < 3; ++c) {
                const double force = values[Step * (3 * a + c)];
                gradient_[3 * unknown[a] + c] += force;
                absolute_[3 * unknown[a] + c] += std::abs(force);
            }
        }
    }

private:
    double *gradient_, *absolute_;
};

/// d^2 energy / d unknowns^2, in a matrix of the objective's pattern.
class HessianSum {
public:
    explicit HessianSum(Eigen::SparseMatrix<double>& hessian) : values_(hessian.valuePtr()) {}

    /// The i th element's lower triangle in 3 x 3 blocks: entry 9 (a (a + 1) / 2 + b) + r + 3 c is at coordinate r of
    /// corner a, c of corner b, a >= b.
    template <int Corners, int Step = 1>
    [[gnu::noinline]] void add(const ElementPlaces& places, int i, const double* values)
    {
        // Within a caller's loops there are not enough registers.
        const int *unknown = places.unknown(i), *stride = places.stride(i), *block = places.block(i);
        for (int a = 0; a < Corners; ++a) {
            for (int b = 0; b <= a; ++b, ++block, values += 9 * Step) {
                if (*block < 0) continue;
                if (unknown[a] < unknown[b]) {
                    add_block<3 * Step, Step>(values, values_ + *block, stride[a]);
                } else {
                    add_block<Step, 3 * Step>(values, values_ + *block, stride[b]);
                }
            }
        }
    }

private:
    template <int Down, int Right>
    static void add_block(const double* values, double* target, std::ptrdiff_t stride)
    {
        for (int c = 0; c < 3; ++c, target += stride) {
            for (int r = 0; r < 3; ++r) target[r] += values[Down * r + Right * c];
        }
    }

    double* values_;
};

}  // namespace ndg
