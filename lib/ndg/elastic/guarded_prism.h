// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/elastic_model.h"
#include "ndg/elastic/volume_guard.h"

namespace ndg {

/// The guard of one prism's volume; nothing where it is far from flat.
class GuardedPrism {
public:
    GuardedPrism(const Points& positions, const FleshElement& element)
        : prism_(gather(positions, element)),
          scale_(element.weight * element.lame.lambda),
          rest_volume_(element.rest_volume),
          guard_(volume_guard(prism_volume(prism_) / rest_volume_))
    {
    }
    bool active() const { return guard_.energy > 0; }
    double energy() const { return scale_ * guard_.energy; }
    PrismVertices forces() const { return scale_ * guard_.first / rest_volume_ * prism_volume_gradient(prism_); }
    /// Semi-definite without the curvature of the volume itself.
    Eigen::Matrix<double, 18, 18> hessian(bool exact) const
    {
        const PrismVertices gradient = prism_volume_gradient(prism_) / rest_volume_;
        Eigen::Matrix<double, 18, 1> stacked;
        for (int a = 0; a < 6; ++a) stacked.segment<3>(3 * a) = gradient.row(a).transpose();
        Eigen::Matrix<double, 18, 18> hessian = scale_ * guard_.second * stacked * stacked.transpose();
        if (exact) hessian += scale_ * guard_.first / rest_volume_ * prism_volume_hessian(prism_);
        return hessian;
    }

private:
    static PrismVertices gather(const Points& positions, const FleshElement& element)
    {
        PrismVertices prism;
        for (int a = 0; a < 6; ++a) prism.row(a) = positions.row(element.vertices[static_cast<std::size_t>(a)]);
        return prism;
    }

    PrismVertices prism_;
    double scale_, rest_volume_;
    VolumeGuard guard_;
};

}  // namespace ndg
