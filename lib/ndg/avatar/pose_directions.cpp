// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/pose_directions.h"

#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"

#include <algorithm>

namespace ndg {

Eigen::VectorXd pose_features(const Pose& pose, const std::vector<int>& joints)
{
    Eigen::VectorXd features(9 * joints.size());
    for (std::size_t k = 0; k < joints.size(); ++k) {
        require(joints[k] >= 0 && joints[k] < int(pose.parent_from_joint.size()),
                "Pose directions depend on joint {}, the pose has {} joints", joints[k], pose.parent_from_joint.size());
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(features.data() + 9 * k) =
            pose.parent_from_joint[joints[k]] - Eigen::Matrix3d::Identity();
    }
    return features;
}

Points pose_offsets(const Eigen::Ref<const Eigen::VectorXd>& features, const RowMatrixF& directions)
{
    require(features.size() == directions.rows(), "{} features were given to {} pose directions", features.size(),
            directions.rows());
    constexpr Eigen::Index block = 3072;
    Points offsets = Points::Zero(directions.cols() / 3, 3);
    Eigen::Map<Eigen::RowVectorXd> sum(offsets.data(), offsets.size());
    parallel_for(int((sum.size() + block - 1) / block), [&](int b) {
        const Eigen::Index begin = b * block, count = std::min(block, sum.size() - begin);
        for (Eigen::Index f = 0; f < features.size(); ++f) {
            if (features[f] != 0.0)
                sum.segment(begin, count) += features[f] * directions.row(f).segment(begin, count).cast<double>();
        }
    });
    return offsets;
}

}  // namespace ndg
