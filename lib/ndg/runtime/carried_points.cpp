// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/carried_points.h"

#include "ndg/core/error.h"

#include <utility>

namespace ndg {

SkinnedPoints::SkinnedPoints(std::vector<int> rows, const SkinningWeights& weights)
    : rows_(std::move(rows)), rest_(rows_.size())
{
    begins_.push_back(0);
    for (const int row : rows_) {
        for (int k = 0; k < max_influences; ++k) {
            if (weights.weights(row, k) == 0.0) continue;
            joints_.push_back(weights.joints(row, k));
            weights_.push_back(static_cast<float>(weights.weights(row, k)));
        }
        begins_.push_back(static_cast<int>(joints_.size()));
    }
}

void SkinnedPoints::set_rest(const Eigen::Ref<const Points>& rest)
{
    for (std::size_t i = 0; i < rows_.size(); ++i) rest_[i] = rest.row(rows_[i]).transpose().cast<float>();
}

void SkinnedPoints::pose(const std::vector<Eigen::Matrix<float, 3, 4>>& world_from_rest, PointsF& posed) const
{
    const auto count = static_cast<int>(rows_.size());
#pragma omp for schedule(static) nowait
    for (int i = 0; i < count; ++i) {
        Eigen::Vector3f sum = Eigen::Vector3f::Zero();
        for (int k = begins_[i]; k < begins_[i + 1]; ++k) {
            const Eigen::Matrix<float, 3, 4>& motion = world_from_rest[joints_[k]];
            sum += weights_[k] * (motion.leftCols<3>() * rest_[i] + motion.col(3));
        }
        posed.row(rows_[i]) = sum.transpose();
    }
}

std::size_t SkinnedPoints::table_bytes() const
{
    return rows_.size() * (sizeof(int) * 2 + sizeof(Eigen::Vector3f)) + joints_.size() * (sizeof(int) + sizeof(float));
}

CarriedAnatomy::CarriedAnatomy(const Template& body_template, const RiggedBodies* bones)
{
    const Eigen::Index count = body_template.anatomy_vertices.rows();
    rest_.resize(count, 3);
    std::vector<int> held_of(static_cast<std::size_t>(count), -1);
    std::vector<char> is_bone(static_cast<std::size_t>(count), 0);
    if (bones != nullptr) {
        list_ = &bones->rig().list;
        for (const BoneList::Bone& bone : list_->bones)
            std::fill(is_bone.begin() + bone.vertex_begin, is_bone.begin() + bone.vertex_end, 1);
        const Attachments& attachments = bones->attachments();
        for (std::size_t i = 0; i < attachments.vertices().size(); ++i) {
            held_of[attachments.vertices()[i]] = static_cast<int>(held_.size());
            held_rows_.push_back(attachments.vertices()[i]);
            Held held = {};
            held.share = static_cast<float>(attachments.shares()[i]);
            held.begin = static_cast<int>(influences_.size());
            for (int k = attachments.weights().begins[i]; k < attachments.weights().begins[i + 1]; ++k)
                influences_.push_back(
                    {attachments.weights().segments[k], static_cast<float>(attachments.weights().weights[k])});
            held.end = static_cast<int>(influences_.size());
            held_.push_back(held);
        }
    }
    std::vector<int> skinned;
    const Embedding& embedding = body_template.embedding;
    for (int i = 0; i < static_cast<int>(count); ++i) {
        if (is_bone[i] != 0) continue;
        if (embedding.elements[i] < 0) {
            skinned.push_back(i);
            continue;
        }
        Embedded point = {};
        point.row = i;
        point.held = held_of[i];
        for (int k = 0; k < 6; ++k) {
            point.corners[k] = embedding.vertices(i, k);
            point.weights[k] = static_cast<float>(embedding.weights(i, k));
        }
        embedded_.push_back(point);
    }
    skinned_ = SkinnedPoints(std::move(skinned), body_template.anatomy_weights);
}

void CarriedAnatomy::set_rest(const Eigen::Ref<const Points>& anatomy_rest)
{
    rest_ = anatomy_rest.cast<float>();
    for (std::size_t i = 0; i < held_.size(); ++i) held_[i].rest = rest_.row(held_rows_[i]).transpose();
    skinned_.set_rest(anatomy_rest);
}

void CarriedAnatomy::set_motions(const std::vector<Eigen::Isometry3d>& segments)
{
    segments_.resize(segments.size());
    reals_.resize(segments.size());
    duals_.resize(segments.size());
    for (std::size_t s = 0; s < segments.size(); ++s) {
        segments_[s] = segments[s].matrix().topRows<3>().cast<float>();
        const Eigen::Quaterniond real = Eigen::Quaterniond(segments[s].linear()).normalized();
        const Eigen::Vector3d t = segments[s].translation();
        reals_[s] = real.coeffs().cast<float>();
        duals_[s] = (0.5 * (Eigen::Quaterniond(0.0, t.x(), t.y(), t.z()) * real).coeffs()).cast<float>();
    }
}

/// Dual quaternion blending, as dual_quaternion_blending; of one bone alone (three in four are) its motion.
Eigen::Vector3f CarriedAnatomy::hold(const Held& held) const
{
    if (held.end - held.begin == 1) {
        const Eigen::Matrix<float, 3, 4>& motion = segments_[influences_[held.begin].segment];
        return motion.leftCols<3>() * held.rest + motion.col(3);
    }
    Eigen::Vector4f real = Eigen::Vector4f::Zero(), dual = Eigen::Vector4f::Zero();
    const Eigen::Vector4f& first = reals_[influences_[held.begin].segment];
    for (int k = held.begin; k < held.end; ++k) {
        const Influence& influence = influences_[k];
        const Eigen::Vector4f& of_segment = reals_[influence.segment];
        const float weight = of_segment.dot(first) < 0.0F ? -influence.weight : influence.weight;
        real += weight * of_segment;
        dual += weight * duals_[influence.segment];
    }
    const Eigen::Vector3f r = real.head<3>(), d = dual.head<3>();
    const Eigen::Vector3f turned = r.cross(held.rest) + real[3] * held.rest;
    const float twice = 2.0F / real.squaredNorm();
    return held.rest + twice * (r.cross(turned) + real[3] * d - dual[3] * r + r.cross(d));
}

void CarriedAnatomy::pose(const PointColumns& volume, const std::vector<Eigen::Matrix<float, 3, 4>>& world_from_rest,
                          PointsF& anatomy) const
{
    if (list_ != nullptr) {
        const auto num_bones = static_cast<int>(list_->bones.size());
#pragma omp for schedule(dynamic, 8) nowait
        for (int b = 0; b < num_bones; ++b) {
            const BoneList::Bone& bone = list_->bones[b];
            const Eigen::Matrix<float, 3, 4>& motion = segments_[bone.segment];
            const Eigen::Matrix3f rotation = motion.leftCols<3>();
            const Eigen::Vector3f translation = motion.col(3);
            for (int v = bone.vertex_begin; v < bone.vertex_end; ++v)
                anatomy.row(v) = (rotation * rest_.row(v).transpose() + translation).transpose();
        }
    }
    const auto count = static_cast<int>(embedded_.size());
#pragma omp for schedule(dynamic, 4096) nowait
    for (int i = 0; i < count; ++i) {
        const Embedded& point = embedded_[i];
        const Held* const held = point.held >= 0 ? &held_[point.held] : nullptr;
        if (held != nullptr && held->share >= 1.0F) {  // touches a bone: the volume has no part in it
            anatomy.row(point.row) = hold(*held).transpose();
            continue;
        }
        Eigen::Vector4f sum = point.weights[0] * volume.col(point.corners[0]);
        for (int k = 1; k < 6; ++k) sum += point.weights[k] * volume.col(point.corners[k]);
        Eigen::Vector3f position = sum.head<3>();
        if (held != nullptr) position += held->share * (hold(*held) - position);
        anatomy.row(point.row) = position.transpose();
    }
    skinned_.pose(world_from_rest, anatomy);
}

std::size_t CarriedAnatomy::table_bytes() const
{
    std::size_t bone_vertices = 0;
    if (list_ != nullptr)
        for (const BoneList::Bone& bone : list_->bones)
            bone_vertices += static_cast<std::size_t>(bone.vertex_end - bone.vertex_begin);
    return sizeof(Embedded) * embedded_.size() + sizeof(Held) * held_.size() + sizeof(Influence) * influences_.size() +
           3 * sizeof(float) * bone_vertices + skinned_.table_bytes();
}

}  // namespace ndg
