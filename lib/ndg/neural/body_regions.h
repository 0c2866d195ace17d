// SPDX-License-Identifier: Apache-2.0
// Regions of the body that have networks of their own, each of which sees the joints near it only. Not in the paper:
// what a knee does cannot be learned from the other arm, and a network that does not see the arm need not learn that.
#pragma once

#include "ndg/neural/output_space.h"
#include "ndg/runtime/input_space.h"

#include <vector>

namespace ndg {

/// The flesh that one joint rules: elements (prisms or vertices) whose largest skinning weight is the joint's.
struct BodyRegion {
    int joint = 0;
    std::vector<int> seen_joints;  ///< ascending: at most `reach` steps from `joint` in the kinematic tree
    std::vector<int> elements;     ///< ascending
};

/// A region smaller than this share of all elements goes to the region that is nearest above it, or else below.
constexpr double smallest_region = 0.005;

/// Regions of elements with these skinning weights, by ascending joint: they hold every element once.
std::vector<BodyRegion> find_body_regions(const Skeleton& skeleton, const SkinningWeights& element_weights, int reach);

/// What a network sees and gives: ascending columns of the model's inputs and raw outputs.
struct NetworkColumns {
    std::vector<int> inputs, outputs;
};

/// Of a network for each region of the output space's elements: the rotations of its seen joints, without those that
/// move nothing, and the whole shape code; the outputs of its elements. Throws InputError where outputs are of no kind
/// that belongs to elements near joints.
std::vector<NetworkColumns> regional_columns(const Template& body_template, const InputSpace& input_space,
                                             const OutputSpace& output_space, int reach);

}  // namespace ndg
