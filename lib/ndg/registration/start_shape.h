// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/rest_pose.h"
#include "ndg/scan/skin_places.h"

#include <vector>

namespace ndg {

/// Shapes to start a registration from, instead of the template's own: a surface says little about where on a smooth
/// limb a vertex belongs, and another sex or build has other places than the template. No statistical model: the mean
/// of the few examples nearest in shape.
class StartShapes {
public:
    /// `skin`: the template; `examples`: skins in its tessellation and pose, may be empty.
    StartShapes(const SkinnedSurface& skin, const JointRegressor& regressor, std::vector<JointExample> examples);
    bool empty() const { return examples_.empty(); }

    /// The examples nearest to a registered skin at rest, averaged, at its stature. Nearness is that of the distances
    /// of trunk and limbs to their bones, as shares of stature: it depends neither on the pose nor much on where along
    /// a limb a vertex lies.
    SkinnedSurface nearest(const Eigen::Ref<const Points>& rest_skin) const;

private:
    Eigen::VectorXd profile(const Eigen::Ref<const Points>& rest_skin) const;

    SkinnedSurface skin_;
    JointRegressor regressor_;
    std::vector<JointExample> examples_;
    std::vector<int> rows_;         ///< vertices that are compared...
    std::vector<int> begin_, end_;  ///< ...their bones' joints...
    Eigen::VectorXd root_areas_;    ///< ...and what they count
    std::vector<Eigen::VectorXd> profiles_;
};

}  // namespace ndg
