// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/rest_operators.h"

#include "ndg/core/error.h"

namespace ndg {

namespace {

/// Row p of the result is what `finish(p, F_p)` makes of the gradient, row-major, in the precision of the vertices.
template <typename Vertices, typename Finish>
auto per_prism(const RestOperators& rest, const Vertices& vertices, const Finish& finish)
{
    require(vertices.rows() == rest.num_vertices(), "{} deformed vertices, the body at rest has {}", vertices.rows(),
            rest.num_vertices());
    using Scalar = typename Vertices::Scalar;
    Eigen::Matrix<Scalar, Eigen::Dynamic, 9, Eigen::RowMajor> result(rest.num_prisms(), 9);
    for (int p = 0; p < rest.num_prisms(); ++p) {
        PrismVertices deformed;
        for (int k = 0; k < 6; ++k) deformed.row(k) = vertices.row(rest.prisms()(p, k)).template cast<double>();
        const Eigen::Matrix3d transposed = rest.gradient(p) * deformed;
        const Eigen::Matrix3d finished = finish(p, transposed.transpose());
        Eigen::Map<Eigen::Matrix<Scalar, 3, 3, Eigen::RowMajor>>(result.row(p).data()) =
            finished.template cast<Scalar>();
    }
    return result;
}

template <typename Vertices>
auto gradients_of(const RestOperators& rest, const Vertices& vertices)
{
    return per_prism(rest, vertices, [](int, const auto& gradient) -> Eigen::Matrix3d { return gradient; });
}

template <typename Vertices>
auto residuals_of(const RestOperators& rest, const Vertices& vertices,
                  const std::vector<Eigen::Matrix3d>& prism_rotations)
{
    require(int(prism_rotations.size()) == rest.num_prisms(), "{} prism rotations, the body has {} prisms",
            prism_rotations.size(), rest.num_prisms());
    return per_prism(rest, vertices, [&](int p, const auto& gradient) -> Eigen::Matrix3d {
        return prism_rotations[p].transpose() * gradient;
    });
}

}  // namespace

RestOperators::RestOperators(const Prisms& prisms, const Eigen::Ref<const Points>& rest_vertices)
    : prisms_(&prisms), num_vertices_(int(rest_vertices.rows()))
{
    require(prisms.rows() > 0 && prisms.minCoeff() >= 0 && prisms.maxCoeff() < num_vertices_,
            "{} prisms do not refer to the {} vertices of the body alone", prisms.rows(), num_vertices_);
    gradients_.reserve(prisms.rows());
    volumes_.reserve(prisms.rows());
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        const PrismVertices prism = gather_prism(rest_vertices, prisms, p);
        const double volume = prism_volume(prism);
        require(volume > 0, "rest prism {} has volume {} m^3", p, volume);
        try {
            gradients_.push_back(prism_gradient_operator(prism));
        } catch (const Error& error) {
            throw Error(fmt::format("rest prism {}: {}", p, error.what()));
        }
        volumes_.push_back(volume);
    }
}

Gradients RestOperators::deformation_gradients(const Eigen::Ref<const Points>& vertices) const
{
    return gradients_of(*this, vertices);
}

GradientsF RestOperators::deformation_gradients(const Eigen::Ref<const PointsF>& vertices) const
{
    return gradients_of(*this, vertices);
}

Gradients RestOperators::residuals(const Eigen::Ref<const Points>& vertices,
                                   const std::vector<Eigen::Matrix3d>& prism_rotations) const
{
    return residuals_of(*this, vertices, prism_rotations);
}

GradientsF RestOperators::residuals(const Eigen::Ref<const PointsF>& vertices,
                                    const std::vector<Eigen::Matrix3d>& prism_rotations) const
{
    return residuals_of(*this, vertices, prism_rotations);
}

}  // namespace ndg
