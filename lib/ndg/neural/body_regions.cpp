// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/body_regions.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <numeric>

namespace ndg {
namespace {

/// Steps in the kinematic tree from `joint` to each joint.
std::vector<int> tree_distances(const Skeleton& skeleton, int joint)
{
    const int num_joints = skeleton.num_joints();
    std::vector<int> distances(num_joints, num_joints);
    int steps = 0;
    for (int above = joint; above >= 0; above = skeleton.parents[above]) distances[above] = steps++;
    for (int j = 1; j < num_joints; ++j)  // parents come before children
        distances[j] = std::min(distances[j], distances[skeleton.parents[j]] + 1);
    return distances;
}

/// The joint of the largest weight of each element, the first of equals.
std::vector<int> ruling_joints(const SkinningWeights& weights)
{
    std::vector<int> ruling(weights.size());
    for (Eigen::Index e = 0; e < weights.size(); ++e) {
        Eigen::Index slot = 0;
        weights.weights.row(e).maxCoeff(&slot);
        ruling[e] = weights.joints(e, slot);
    }
    return ruling;
}

/// For each joint with elements the joint whose region they belong to.
std::vector<int> merge_small_regions(const Skeleton& skeleton, const std::vector<int>& counts, int least)
{
    std::vector<int> region(counts.size());
    std::iota(region.begin(), region.end(), 0);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        if (counts[j] == 0 || counts[j] >= least) continue;
        const std::vector<int> distances = tree_distances(skeleton, j);
        int best = -1;
        for (int other = 0; other < skeleton.num_joints(); ++other)  // of equals the first, which is above
            if (counts[other] >= least && (best < 0 || distances[other] < distances[best])) best = other;
        if (best >= 0) region[j] = best;
    }
    return region;
}

}  // namespace

std::vector<BodyRegion> find_body_regions(const Skeleton& skeleton, const SkinningWeights& element_weights, int reach)
{
    const int num_joints = skeleton.num_joints();
    const std::vector<int> ruling = ruling_joints(element_weights);
    std::vector<int> counts(num_joints, 0);
    for (const int joint : ruling) ++counts[joint];
    const auto least = static_cast<int>(smallest_region * static_cast<double>(ruling.size())) + 1;
    const std::vector<int> region_of = merge_small_regions(skeleton, counts, least);
    std::vector<BodyRegion> regions;
    for (int joint = 0; joint < num_joints; ++joint) {
        BodyRegion region;
        region.joint = joint;
        for (std::size_t e = 0; e < ruling.size(); ++e)
            if (region_of[ruling[e]] == joint) region.elements.push_back(static_cast<int>(e));
        if (region.elements.empty()) continue;
        const std::vector<int> distances = tree_distances(skeleton, joint);
        for (int j = 0; j < num_joints; ++j)
            if (distances[j] <= reach) region.seen_joints.push_back(j);
        regions.push_back(std::move(region));
    }
    return regions;
}

std::vector<NetworkColumns> regional_columns(const Template& body_template, const InputSpace& input_space,
                                             const OutputSpace& output_space, int reach)
{
    const OutputKind kind = output_space.kind();
    require_input(kind != OutputKind::other, "regional networks are known for residuals and offsets only");
    const bool prisms = kind == OutputKind::prism_matrices;
    SkinningWeights weights = prisms ? body_template.prism_weights() : body_template.volume_weights();
    if (!prisms) {  // the free vertices
        std::vector<int> rows(2 * body_template.num_wrap_vertices());
        std::iota(rows.begin(), rows.end(), body_template.num_wrap_vertices());
        weights = select_weights(weights, rows);
    }
    const int size = prisms ? 9 : 3, num_joints = body_template.skeleton.num_joints();
    std::vector<NetworkColumns> columns;
    for (const BodyRegion& region : find_body_regions(body_template.skeleton, weights, reach)) {
        NetworkColumns& of_region = columns.emplace_back();
        for (const int joint : region.seen_joints)
            for (int k = 0; k < 9 && input_space.visible_joints()[joint] != 0; ++k)
                of_region.inputs.push_back(9 * joint + k);
        for (int column = 9 * num_joints; column < input_space.width(); ++column) of_region.inputs.push_back(column);
        for (const int element : region.elements)
            for (int k = 0; k < size; ++k) of_region.outputs.push_back(size * element + k);
    }
    return columns;
}

}  // namespace ndg
