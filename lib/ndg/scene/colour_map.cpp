// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/colour_map.h"

#include "ndg/geometry/prism.h"

#include <algorithm>
#include <array>

namespace ndg {

Eigen::Vector3f diverging_colour(double value)
{
    // Control colours at -1, -1/2, 0, 1/2, 1; between them linear in sRGB. The two arms have matching lightness.
    static const std::array<Eigen::Vector3f, 5> stops = {
        Eigen::Vector3f(0.13f, 0.26f, 0.60f), Eigen::Vector3f(0.42f, 0.63f, 0.86f),
        Eigen::Vector3f(0.90f, 0.89f, 0.88f), Eigen::Vector3f(0.93f, 0.53f, 0.39f),
        Eigen::Vector3f(0.66f, 0.07f, 0.13f)};
    const double position = 2.0 * (std::clamp(value, -1.0, 1.0) + 1.0);
    const int stop = std::min(int(position), 3);
    const float t = float(position - stop);
    return (1.0f - t) * stops[std::size_t(stop)] + t * stops[std::size_t(stop) + 1];
}

Eigen::VectorXd volume_change(const Eigen::Ref<const Points>& rest_vertices,
                              const Eigen::Ref<const Points>& deformed_vertices, const Eigen::Ref<const Prisms>& prisms,
                              int num_wrap_vertices)
{
    const Eigen::VectorXd rest = prism_volumes(rest_vertices, prisms);
    const Eigen::VectorXd deformed = prism_volumes(deformed_vertices, prisms);
    Eigen::VectorXd rest_sum = Eigen::VectorXd::Zero(num_wrap_vertices);
    Eigen::VectorXd deformed_sum = Eigen::VectorXd::Zero(num_wrap_vertices);
    for (Eigen::Index p = 0; p < prisms.rows(); ++p)
        for (int k = 0; k < 3; ++k) {
            // The two triangles of a prism are copies of one wrap triangle, so three of the six vertices suffice.
            const int wrap_vertex = prisms(p, k) % num_wrap_vertices;
            rest_sum[wrap_vertex] += rest[p];
            deformed_sum[wrap_vertex] += deformed[p];
        }
    Eigen::VectorXd change = Eigen::VectorXd::Zero(num_wrap_vertices);
    for (int w = 0; w < num_wrap_vertices; ++w)
        if (rest_sum[w] > 0) change[w] = deformed_sum[w] / rest_sum[w] - 1.0;
    return change;
}

}  // namespace ndg
