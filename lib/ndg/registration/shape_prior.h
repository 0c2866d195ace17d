// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/registration/hems.h"
#include "ndg/registration/rest_pose.h"
#include "ndg/registration/skin_segments.h"
#include "ndg/scan/skin_places.h"

#include <array>
#include <vector>

namespace ndg {

/// What skins look like, from examples: mean and principal components of skins and joints. A surface says little about
/// where on a smooth limb a vertex belongs, and nothing about what lies under clothes; other people do.
class ShapePrior {
public:
    /// `skin`: the template; `examples`: skins in its tessellation and pose, may be empty.
    ShapePrior(const SkinnedSurface& skin, const std::vector<JointExample>& examples);
    bool empty() const { return components_.modes.cols() == 0; }

    struct Explanation {
        SkinnedSurface shape;  ///< the likeliest person, in the place of the skin given
        /// N: how far the skin given lies outside the shape, m, negative inside.
        Eigen::VectorXd outside;
        /// Segments that lie farther outside than skin can, as trousers, shoes and hair do.
        std::array<bool, num_segment_pairs> dressed{};
        std::vector<char> covered;  ///< N, 1 where clothes or hair hide the skin
    };
    /// `rest_skin`: a registered skin at rest, N x 3; `evidence`: N, area where the scan shows it, else 0. Distances
    /// count along the skin's normals, and little across them. A group of segments is dressed if the person that the
    /// other segments tell of leaves it too far outside, beyond what people differ by; `hems`: what is known to be
    /// dressed.
    Explanation explain(const Eigen::Ref<const Points>& rest_skin, const Eigen::VectorXd& evidence,
                        const HemCover& hems) const;

private:
    struct Components {
        Eigen::VectorXd mean;   ///< 3 (N + J): skin, then joints, centred at the skin's mean
        Eigen::MatrixXd modes;  ///< of length one standard deviation each
        /// Of unknowns: coefficients of the modes, then a translation.
        Points positions(const Eigen::VectorXd& unknowns) const;
    };
    struct Evidence;
    using PairEvidence = std::array<Evidence, num_segment_pairs>;
    using PairFlags = std::array<bool, num_segment_pairs>;
    static Components find_components(const std::vector<JointExample>& examples);
    PairEvidence gather(const Components& components, const Eigen::Ref<const Points>& rest_skin, const Points& normals,
                        const Eigen::VectorXd& weights) const;
    void learn_deviations(const std::vector<JointExample>& examples);

    SkinnedSurface skin_;
    std::vector<SegmentPair> pairs_;  ///< of each vertex
    Components components_;
    std::vector<double> deviations_;  ///< of each garment: of bare skin there from what the rest of the body tells, m
};

}  // namespace ndg
