// SPDX-License-Identifier: Apache-2.0
// More training samples made of those there are: seen in a mirror, and spliced from two samples of the same body.
//
// Neither is in the paper. Both keep the network as it is and are near the truth: a body's mirror image deforms like
// the body, and flesh in the middle of a limb's segment hardly knows which way the joints beyond the next one turn.
#pragma once

#include "ndg/body/mirror.h"
#include "ndg/neural/training_set.h"

#include <map>
#include <optional>
#include <vector>

namespace ndg {

/// What two samples can be joined of, with seams at the waist, half-way along the upper arms and half-way along the
/// thighs. Region 0 is pelvis and thighs, 1 the upper trunk, 2 and 3 the left and right forearm, 4 and 5 the left and
/// right shank.
struct SpliceRegions {
    static constexpr int count = 6;
    std::vector<int> of_joints;  ///< J: region whose sample gives the joint's rotation
    /// How much of each region a volume vertex (N_v) and a prism (N_p) belong to: rows sum to one, and change smoothly
    /// across the seams.
    RowMatrixF vertex_shares, prism_shares;
};
SpliceRegions find_splice_regions(const Template& body_template);

/// What becomes of a sample.
struct SampleChange {
    bool mirrored = false;    ///< after splicing
    int other_idx = -1;       ///< sample of the same body that gives some regions; -1: none
    unsigned from_other = 0;  ///< bit r: region r is the other sample's
};

class Augmentation {
public:
    /// Keeps references to all but the options. Throws InputError where the template has no mirror image, or where
    /// predictions are of no kind that is known here.
    Augmentation(const TrainingSet& set, const InputSpace& input_space, const OutputSpace& output_space,
                 const AugmentationOptions& options, std::uint64_t seed);

    /// Of a sample in one epoch; another one in each.
    SampleChange draw(int sample_idx, int epoch) const;
    /// What the network sees, InputSpace::width() numbers.
    Eigen::RowVectorXf features(int sample_idx, const SampleChange& change) const;
    /// What it is to predict, OutputSpace::width() numbers. May be called by any thread.
    void target(int sample_idx, const SampleChange& change, float* target) const;

    /// Beyond the neutral prediction changed targets are linear: the sum, over the regions that may come from another
    /// sample, of a matrix times the target of the region's sample. This is the matrix's transpose times a row of
    /// OutputSpace::width() numbers. Without splices there is one region, the whole.
    void transpose(int region, bool mirrored, const float* row, float* result) const;
    int num_regions() const { return options_.splice > 0 ? SpliceRegions::count : 1; }
    bool mirrors() const { return options_.mirror; }

private:
    /// Numbers an element (prism or vertex) has, and shares of the elements in the splice regions.
    int element_size() const { return kind_ == OutputKind::prism_matrices ? 9 : 3; }
    float share(Eigen::Index element, int region) const;
    const float* mirror_signs() const;
    void splice(const SampleChange& change, float* target) const;
    void mirror_in_place(float* target) const;

    const TrainingSet* set_;
    const InputSpace* input_space_;
    OutputKind kind_;
    AugmentationOptions options_;
    std::uint64_t seed_;
    SpliceRegions regions_;
    std::optional<TemplateMirror> mirror_;  ///< with AugmentationOptions::mirror
    std::vector<int> opposite_;             ///< element opposite each, where there is a mirror
    std::map<int, std::vector<int>> samples_of_body_;
    std::map<int, Eigen::VectorXd> codes_, mirror_codes_;  ///< of the bodies
};

}  // namespace ndg
