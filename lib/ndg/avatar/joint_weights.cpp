// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/joint_weights.h"

#include "ndg/core/error.h"

#include <cmath>

namespace ndg {

namespace {

/// How far rows of weights may be from summing to one.
constexpr double sum_tolerance = 1e-6;

}  // namespace

JointWeights sparse_weights(const Eigen::Ref<const RowMatrix>& dense)
{
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index i = 0; i < dense.rows(); ++i)
        for (Eigen::Index j = 0; j < dense.cols(); ++j)
            if (dense(i, j) != 0.0) entries.emplace_back(int(i), int(j), dense(i, j));
    JointWeights weights(dense.rows(), dense.cols());
    weights.setFromTriplets(entries.begin(), entries.end());
    return weights;
}

JointWeights sparse_weights(const SkinningWeights& weights, int num_joints)
{
    return sparse_weights(dense_weights(weights, num_joints));
}

Eigen::Matrix<double, 3, 4> blended_motion(const JointWeights& weights,
                                           const std::vector<Eigen::Isometry3d>& world_from_rest, int vertex)
{
    Eigen::Matrix<double, 3, 4> blend = Eigen::Matrix<double, 3, 4>::Zero();
    for (JointWeights::InnerIterator entry(weights, vertex); entry; ++entry)
        blend += entry.value() * world_from_rest[entry.col()].matrix().topRows<3>();
    return blend;
}

std::string weights_defect(const Eigen::Ref<const RowMatrix>& dense)
{
    for (Eigen::Index i = 0; i < dense.rows(); ++i) {
        for (Eigen::Index j = 0; j < dense.cols(); ++j) {
            if (!(dense(i, j) >= 0.0)) return fmt::format("[{}, {}] is {}, not a weight", i, j, dense(i, j));
        }
        const double sum = dense.row(i).sum();
        if (!(std::abs(sum - 1.0) <= sum_tolerance)) return fmt::format("[{}] sums to {} instead of 1", i, sum);
    }
    return "";
}

std::string parents_defect(const std::vector<int>& parents)
{
    if (parents.empty()) return " has no joint";
    for (std::size_t j = 0; j < parents.size(); ++j) {
        const bool valid = j == 0 ? parents[j] == -1 : parents[j] >= 0 && parents[j] < int(j);
        if (!valid) {
            return fmt::format("[{}] is {}, but {}", j, parents[j],
                               j == 0 ? "the first joint is the root, with parent -1"
                                      : "joints form one tree in which parents stand before their children");
        }
    }
    return "";
}

}  // namespace ndg
