// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/poisson_matrices.h"

#include <vector>

namespace ndg {

PoissonMatrices::PoissonMatrices(const RestOperators& rest, int num_wrap_vertices)
{
    const int num_free = rest.num_vertices() - num_wrap_vertices;
    std::vector<Eigen::Triplet<double>> free_entries, coupling_entries;
    free_entries.reserve(static_cast<std::size_t>(rest.num_prisms()) * 21);
    for (int p = 0; p < rest.num_prisms(); ++p) {
        const PrismGradient& gradient = rest.gradient(p);
        const Eigen::Matrix<double, 6, 6> block = rest.volume(p) * gradient.transpose() * gradient;
        for (int a = 0; a < 6; ++a) {
            const int row = rest.prisms()(p, a) - num_wrap_vertices;
            if (row < 0) continue;
            for (int b = 0; b < 6; ++b) {
                const int col = rest.prisms()(p, b) - num_wrap_vertices;
                if (col < 0) {
                    coupling_entries.emplace_back(row, col + num_wrap_vertices, block(a, b));
                } else if (col <= row) {
                    free_entries.emplace_back(row, col, block(a, b));
                }
            }
        }
    }
    free.resize(num_free, num_free);
    free.setFromTriplets(free_entries.begin(), free_entries.end());
    coupling.resize(num_free, num_wrap_vertices);
    coupling.setFromTriplets(coupling_entries.begin(), coupling_entries.end());
}

}  // namespace ndg
