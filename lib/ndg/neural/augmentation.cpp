// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/augmentation.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/random.h"

#include <algorithm>
#include <cstdint>
#include <string>

namespace ndg {
namespace {

/// The seam lies on the segment from `joint` to `next`, between these shares of its length; `next` and all joints below
/// it are beyond. Seams of limbs lie half-way between two joints, where flesh is near rest in all poses. At the waist
/// it is not, but exchanged upper trunks help most, also where the spine bends.
struct Seam {
    int region;
    const char *joint, *next;
    double begin, end;
};
const Seam seams[] = {{1, "spine_2", "spine_3", 0.0, 1.0},
                      {2, "left_upper_arm", "left_forearm", 0.3, 0.7},
                      {3, "right_upper_arm", "right_forearm", 0.3, 0.7},
                      {4, "left_thigh", "left_shin", 0.3, 0.7},
                      {5, "right_thigh", "right_shin", 0.3, 0.7}};

double smooth_step(double t)
{
    t = std::clamp(t, 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

/// 1 for `joint` and all below it.
std::vector<char> subtree(const Skeleton& skeleton, int joint)
{
    std::vector<char> below(skeleton.num_joints(), 0);
    for (int j = joint; j < skeleton.num_joints(); ++j)
        below[j] = j == joint || (skeleton.parents[j] >= 0 && below[skeleton.parents[j]]);
    return below;
}

/// How much of each volume vertex lies beyond a seam: the weights of the joints beyond, and of the seam's segment as
/// much as the vertex is along it.
Eigen::VectorXf share_beyond(const Template& body_template, const Seam& seam, const std::vector<char>& below)
{
    const SkinningWeights weights = body_template.volume_weights();
    const int joint = body_template.skeleton.joint(seam.joint), next = body_template.skeleton.joint(seam.next);
    const Points& joints = body_template.rest.joint_positions;
    const Eigen::RowVector3d origin = joints.row(joint), segment = joints.row(next) - origin;
    Eigen::VectorXf share(weights.size());
    for (Eigen::Index v = 0; v < share.size(); ++v) {
        const double along = (body_template.rest.volume_vertices.row(v) - origin).dot(segment) / segment.squaredNorm();
        const double of_segment = smooth_step((along - seam.begin) / (seam.end - seam.begin));
        double sum = 0;
        for (int k = 0; k < max_influences; ++k) {
            const int j = weights.joints(v, k);
            sum += weights.weights(v, k) * (below[j] ? 1.0 : j == joint ? of_segment : 0.0);
        }
        share[v] = static_cast<float>(sum);
    }
    return share;
}

}  // namespace

SpliceRegions find_splice_regions(const Template& body_template)
{
    const Skeleton& skeleton = body_template.skeleton;
    SpliceRegions regions;
    regions.of_joints.assign(skeleton.num_joints(), 0);
    RowMatrixF& shares = regions.vertex_shares;
    shares = RowMatrixF::Zero(body_template.num_volume_vertices(), SpliceRegions::count);
    shares.col(0).setOnes();
    for (const Seam& seam : seams) {  // what is farther out comes later, and is taken from the region it was in
        const int next = skeleton.joint(seam.next), inner = regions.of_joints[next];
        const std::vector<char> below = subtree(skeleton, next);
        for (int j = 0; j < skeleton.num_joints(); ++j)
            if (below[j]) regions.of_joints[j] = seam.region;
        shares.col(seam.region) = share_beyond(body_template, seam, below);
        shares.col(inner) -= shares.col(seam.region);
    }
    shares = shares.cwiseMax(0.0F);  // of rounding
    regions.prism_shares = RowMatrixF::Zero(body_template.num_prisms(), SpliceRegions::count);
    for (Eigen::Index p = 0; p < regions.prism_shares.rows(); ++p)
        for (int k = 0; k < 6; ++k) regions.prism_shares.row(p) += shares.row(body_template.prisms(p, k)) / 6.0F;
    return regions;
}

Augmentation::Augmentation(const TrainingSet& set, const InputSpace& input_space, const OutputSpace& output_space,
                           const AugmentationOptions& options, std::uint64_t seed)
    : set_(&set), input_space_(&input_space), kind_(output_space.kind()), options_(options), seed_(seed)
{
    require_input(kind_ != OutputKind::other, "mirror images and splices are known for residuals and offsets only");
    const Template& body_template = set.body_template();
    regions_ = find_splice_regions(body_template);
    if (options.mirror) {
        mirror_ = find_mirror(body_template);
        log_info("mirror images: the template's skin is symmetric within {:.2f} mm, wraps {:.1f} mm, weights {:.3f}",
                 1e3 * mirror_->skin_residual, 1e3 * mirror_->wrap_residual, mirror_->weight_residual);
        const int num_wrap = body_template.num_wrap_vertices();
        opposite_ = mirror_->prisms;
        if (kind_ == OutputKind::vertex_vectors) {
            opposite_.assign(mirror_->vertices.begin() + num_wrap, mirror_->vertices.end());
            for (int& vertex : opposite_) vertex -= num_wrap;
        }
    }
    for (int i = 0; i < set.size(); ++i) {
        const int body_idx = set.pair(i).body_idx;
        samples_of_body_[body_idx].push_back(i);
        if (codes_.count(body_idx)) continue;
        codes_[body_idx] = input_space.encode(set.body(i).volume_vertices);
        if (mirror_) mirror_codes_[body_idx] = input_space.encode(mirror_->mirrored(set.body(i).volume_vertices));
    }
}

SampleChange Augmentation::draw(int sample_idx, int epoch) const
{
    Random random(seed_, "augmentation " + std::to_string(epoch), static_cast<std::uint64_t>(sample_idx));
    SampleChange change;
    change.mirrored = random.uniform() < 0.5 && options_.mirror;
    const std::vector<int>& same_body = samples_of_body_.at(set_->pair(sample_idx).body_idx);
    const bool spliced = random.uniform() < options_.splice && same_body.size() > 1;
    if (!spliced) return change;
    const auto drawn = static_cast<std::size_t>(random.below(same_body.size() - 1));
    change.other_idx = same_body[drawn] == sample_idx ? same_body.back() : same_body[drawn];
    for (int region = 1; region < SpliceRegions::count; ++region)
        if (random.uniform() < 0.5) change.from_other |= 1U << region;
    return change;
}

Eigen::RowVectorXf Augmentation::features(int sample_idx, const SampleChange& change) const
{
    Pose pose = set_->pose(sample_idx);
    if (change.other_idx >= 0) {
        const Pose& other = set_->pose(change.other_idx);
        for (std::size_t j = 0; j < regions_.of_joints.size(); ++j)
            if (change.from_other >> regions_.of_joints[j] & 1U) pose.parent_from_joint[j] = other.parent_from_joint[j];
    }
    const int body_idx = set_->pair(sample_idx).body_idx;
    if (!change.mirrored) return input_space_->features({codes_.at(body_idx), pose});
    return input_space_->features({mirror_codes_.at(body_idx), mirror_->mirrored(pose)});
}

float Augmentation::share(Eigen::Index element, int region) const
{
    const RowMatrixF& shares = kind_ == OutputKind::prism_matrices ? regions_.prism_shares : regions_.vertex_shares;
    const Eigen::Index first = shares.rows() - set_->width() / element_size();  // free vertices come last
    return shares(first + element, region);
}

const float* Augmentation::mirror_signs() const
{
    // diag(-1, 1, 1) M diag(-1, 1, 1), and diag(-1, 1, 1) v.
    static constexpr float of_matrix[] = {1, -1, -1, -1, 1, 1, -1, 1, 1}, of_vector[] = {-1, 1, 1};
    return kind_ == OutputKind::prism_matrices ? of_matrix : of_vector;
}

void Augmentation::splice(const SampleChange& change, float* target) const
{
    const int size = element_size(), num_elements = set_->width() / size;
    std::vector<float> other(set_->width());
    set_->target(change.other_idx, other.data());
    for (int e = 0; e < num_elements; ++e) {
        float from_other = 0;
        for (int region = 0; region < SpliceRegions::count; ++region)
            if (change.from_other >> region & 1U) from_other += share(e, region);
        for (int k = size * e; k < size * (e + 1); ++k) target[k] += from_other * (other[k] - target[k]);
    }
}

void Augmentation::mirror_in_place(float* target) const
{
    const float* signs = mirror_signs();
    const int size = element_size();
    const std::vector<float> seen(target, target + set_->width());
    for (std::size_t e = 0; e < opposite_.size(); ++e)
        for (int k = 0; k < size; ++k) target[size * opposite_[e] + k] = signs[k] * seen[size * e + k];
}

void Augmentation::transpose(int region, bool mirrored, const float* row, float* result) const
{
    const float* signs = mirror_signs();
    const int size = element_size(), num_elements = set_->width() / size;
    for (int e = 0; e < num_elements; ++e) {
        const float of_region = options_.splice > 0 ? share(e, region) : 1.0F;
        for (int k = 0; k < size; ++k)
            result[size * e + k] = of_region * (mirrored ? signs[k] * row[size * opposite_[e] + k] : row[size * e + k]);
    }
}

void Augmentation::target(int sample_idx, const SampleChange& change, float* target) const
{
    set_->target(sample_idx, target);
    if (change.other_idx >= 0) splice(change, target);
    if (change.mirrored) mirror_in_place(target);
}

}  // namespace ndg
