// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget.h"

#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"
#include "ndg/retarget/retarget_measures.h"
#include "ndg/retarget/retarget_targets.h"
#include "ndg/retarget/retarget_transfer.h"

#include <algorithm>
#include <cmath>
#include <exception>

namespace ndg {

namespace {

using Rotations = std::vector<Eigen::Matrix3d>;

/// Frames a piece; inverse kinematics starts anew in each.
constexpr int piece_size = 256;

struct ErrorSum {
    double sum = 0.0, before = 0.0, uniform = 0.0, max = 0.0;
};

/// What a piece of a clip adds to the report.
struct PieceTotals {
    std::vector<ErrorSum> errors;  ///< one a landmark
    std::vector<LimitHits> hits;   ///< one a joint
    int num_violating = 0, num_far = 0, num_jumps = 0, num_new_jumps = 0;
    long num_iterations = 0;
    double max_jump = 0.0, max_source_jump = 0.0;
};

/// One frame on our skeleton.
struct Frame {
    Rotations world;    ///< after inverse kinematics
    Rotations free;     ///< local, before clamping
    Rotations clamped;  ///< local, the result
    Rotations correction;
};

std::vector<int> mapped_joints(const RotationTransfer& transfer)
{
    std::vector<int> joints;
    for (std::size_t j = 0; j < transfer.links().size(); ++j) {
        if (transfer.links()[j].source >= 0) joints.push_back(static_cast<int>(j));
    }
    return joints;
}

/// Nearest joint above that the map moves, -1 for the root.
std::vector<int> mapped_parents(const RotationTransfer& transfer)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<int> parents = skeleton.parents;
    for (int& parent : parents) {
        while (parent > 0 && transfer.links()[parent].source < 0) parent = skeleton.parents[parent];
    }
    return parents;
}

/// The joint other than the root that is furthest beyond the limit of the options or its own; no poses: none is.
DroppedJoint beyond_angles(const RotationTransfer& transfer, const Rotations& local, double max_joint_angle)
{
    DroppedJoint result;
    for (std::size_t j = 1; j < local.size(); ++j) {
        const double limit = std::min(transfer.links()[j].limit, max_joint_angle);
        if (limit >= M_PI) continue;
        const double angle = rotation_angle(local[j], Eigen::Matrix3d::Identity());
        if (angle <= limit || angle - limit < result.max_angle - result.limit) continue;
        result = {standard_skeleton().joint_names[j], 1, angle, limit};
    }
    return result;
}

class ClipRetargeter {
public:
    ClipRetargeter(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions,
                   const RetargetOptions& options, int first_frame)
        : options_(options),
          rest_(joint_positions),
          first_frame_(first_frame),
          transfer_(clip, map, joint_positions),
          targets_(transfer_, joint_positions),
          kinematics_(standard_skeleton(), joint_positions, mapped_joints(transfer_), targets_.landmarks(),
                      options.kinematics),
          mapped_parents_(mapped_parents(transfer_)),
          kept_(wanted_frames())
    {
        num_frames_ = clip.num_frames() - first_frame;
        speeds_.assign(std::max(0, num_frames_ - 1), 0.0);
        const int num_pieces = (num_frames_ + piece_size - 1) / piece_size;
        pieces_.resize(num_pieces);
        poses_.resize(kept_.size());
        beyond_.resize(kept_.size());
        std::vector<std::exception_ptr> errors(pieces_.size());
#pragma omp parallel for schedule(dynamic)
        for (int p = 0; p < num_pieces; ++p) {
            try {
                run_piece(p);
            } catch (...) {
                errors[p] = std::current_exception();
            }
        }
        for (const std::exception_ptr& error : errors) {
            if (error) std::rethrow_exception(error);
        }
    }

    PoseSet collect(RetargetReport& report) const
    {
        const MotionClip& clip = transfer_.clip();
        std::vector<bool> glitch(num_frames_, false);
        for (std::size_t f = 0; f < speeds_.size(); ++f) {
            report.max_joint_speed = std::max(report.max_joint_speed, speeds_[f]);
            if (speeds_[f] > options_.max_joint_speed * radians_per_degree) glitch[f] = glitch[f + 1] = true;
        }
        report.num_glitch_frames = static_cast<int>(std::count(glitch.begin(), glitch.end(), true));
        SegmentDirections segments(transfer_);
        PoseSet poses;
        poses.clip_names.push_back(clip.name);
        poses.clip_frame_rates.push_back(clip.frame_rate);
        for (std::size_t k = 0; k < kept_.size(); ++k) {
            if (!glitch[kept_[k]]) segments.add(rest_, poses_[k].parent_from_joint, kept_[k] + first_frame_);
            if (glitch[kept_[k]]) {
                ++report.num_dropped_glitches;
            } else if (beyond_[k].num_poses > 0) {
                ++report.num_dropped_angles;
                add_dropped(beyond_[k], report);
            } else {
                const int frame_idx = kept_[k] + first_frame_;
                poses.poses.push_back(poses_[k]);
                poses.clip_idx.push_back(0);
                poses.frame_idx.push_back(frame_idx);
                report.mean_direction_error +=
                    direction_error(transfer_, rest_, poses_[k].parent_from_joint, frame_idx);
            }
        }
        report.segment_errors = segments.errors();
        report.num_poses = poses.size();
        if (report.num_poses > 0) report.mean_direction_error /= report.num_poses;
        add_totals(report);
        report.scale = transfer_.scale();
        return poses;
    }

private:
    static void add_dropped(const DroppedJoint& dropped, RetargetReport& report)
    {
        for (DroppedJoint& known : report.dropped_joints) {
            if (known.joint != dropped.joint) continue;
            ++known.num_poses;
            known.max_angle = std::max(known.max_angle, dropped.max_angle);
            return;
        }
        report.dropped_joints.push_back(dropped);
    }

    /// Frames from the first one on that are kept, before any is dropped.
    std::vector<int> wanted_frames() const
    {
        const MotionClip& clip = transfer_.clip();
        const double step = options_.frame_rate > 0 ? std::max(1.0, clip.frame_rate / options_.frame_rate) : 1.0;
        std::vector<int> frames;
        for (int k = 0;; ++k) {
            const auto f = static_cast<int>(std::llround(k * step));
            if (f >= clip.num_frames() - first_frame_) return frames;
            frames.push_back(f);
        }
    }

    void run_piece(int piece)
    {
        const auto num_joints = static_cast<std::size_t>(num_standard_joints);
        PieceTotals& totals = pieces_[piece];
        totals.errors.resize(targets_.landmarks().size());
        totals.hits.resize(num_joints);
        const int begin = piece * piece_size, end = std::min(num_frames_, begin + piece_size);
        Frame before, now;
        now.correction.assign(num_joints, Eigen::Matrix3d::Identity());
        // One frame of the piece before, for the jump between them.
        for (int f = std::max(0, begin - 1); f < end; ++f) {
            before = now;
            solve(f, before.correction, now, f >= begin ? &totals : nullptr);
            if (f < begin || f == 0) continue;
            speeds_[f - 1] = largest_angle(before.free, now.free) * transfer_.clip().frame_rate;
            count_jumps(f, before.clamped, now.clamped, totals);
        }
    }

    /// Frame `f` (from the first on) onto our skeleton.
    void solve(int f, const Rotations& last_correction, Frame& frame, PieceTotals* totals)
    {
        const int frame_idx = f + first_frame_;
        const Rotations reference = transfer_.world_rotations(frame_idx);
        const Points targets = targets_.targets(frame_idx);
        frame.world = reference;
        int iterations = 0;
        if (options_.inverse_kinematics) {
            for (std::size_t j = 0; j < reference.size(); ++j) frame.world[j] = last_correction[j] * reference[j];
            iterations = kinematics_.solve(reference, targets, frame.world);
            for (std::size_t j = 0; j < reference.size(); ++j) {
                frame.correction[j] = to_quaternion(frame.world[j] * reference[j].transpose()).toRotationMatrix();
            }
        }
        frame.free = local_rotations(frame.world);
        frame.clamped = frame.free;
        if (options_.limits != nullptr && options_.clamp_limits) frame.clamped = options_.limits->clamped(frame.free);
        if (totals == nullptr) return;
        totals->num_iterations += iterations;
        add_errors(frame_idx, reference, targets, frame, *totals);
        if (options_.limits != nullptr) add_hits(frame.free, *totals);
        const auto kept = std::lower_bound(kept_.begin(), kept_.end(), f);
        if (kept == kept_.end() || *kept != f) return;
        const auto k = static_cast<std::size_t>(kept - kept_.begin());
        poses_[k].parent_from_joint = frame.clamped;
        poses_[k].root_translation = transfer_.root_translation(frame_idx, first_frame_, frame.clamped[0]);
        beyond_[k] = beyond_angles(transfer_, frame.clamped, options_.max_joint_angle * radians_per_degree);
    }

    void add_errors(int frame_idx, const Rotations& reference, const Points& targets, const Frame& frame,
                    PieceTotals& totals) const
    {
        const bool clamps = options_.limits != nullptr && options_.clamp_limits;
        const Rotations result = clamps ? compose_rotations(frame.clamped) : frame.world;
        const Points before = kinematics_.positions(reference), after = kinematics_.positions(result);
        const Points uniform = targets_.uniform_targets(frame_idx, result[0]);
        for (std::size_t k = 0; k < totals.errors.size(); ++k) {
            ErrorSum& error = totals.errors[k];
            const double distance = (after.row(k) - targets.row(k)).norm();
            error.sum += distance;
            error.max = std::max(error.max, distance);
            error.before += (before.row(k) - targets.row(k)).norm();
            error.uniform += (after.row(k) - uniform.row(k)).norm();
        }
    }

    void add_hits(const Rotations& local, PieceTotals& totals) const
    {
        const std::vector<double> excess = options_.limits->excess(local);
        bool any = false, far = false;
        for (std::size_t j = 0; j < excess.size(); ++j) {
            if (excess[j] <= violation_angle) continue;
            any = true;
            ++totals.hits[j].num_frames;
            if (excess[j] > far_violation_angle) {
                far = true;
                ++totals.hits[j].num_far_frames;
            }
            totals.hits[j].max_excess = std::max(totals.hits[j].max_excess, excess[j]);
        }
        if (any) ++totals.num_violating;
        if (far) ++totals.num_far;
    }

    static double largest_angle(const Rotations& a, const Rotations& b)
    {
        double angle = 0.0;
        for (std::size_t j = 0; j < a.size(); ++j) angle = std::max(angle, rotation_angle(a[j], b[j]));
        return angle;
    }

    /// Largest change of rotation between the source's joints that drive joint j and those that drive its parent.
    double source_jump(int f, std::size_t j) const
    {
        const MotionClip& clip = transfer_.clip();
        const auto& links = transfer_.links();
        const int parent = mapped_parents_[j];
        double largest = 0.0;
        for (const int b : {links[j].source, links[j].blend_with}) {
            if (b < 0) continue;
            if (parent < 0) largest = std::max(largest, relative_jump(clip, f + first_frame_, -1, b));
            for (const int a : {parent >= 0 ? links[parent].source : -1, parent >= 0 ? links[parent].blend_with : -1}) {
                if (a >= 0 && a != b) largest = std::max(largest, relative_jump(clip, f + first_frame_, a, b));
            }
        }
        return largest;
    }

    void count_jumps(int f, const Rotations& before, const Rotations& now, PieceTotals& totals) const
    {
        for (std::size_t j = 0; j < now.size(); ++j) {
            const double jump = rotation_angle(before[j], now[j]);
            totals.max_jump = std::max(totals.max_jump, jump);
            if (transfer_.links()[j].source < 0) continue;
            const double source = source_jump(f, j);
            totals.max_source_jump = std::max(totals.max_source_jump, source);
            if (jump <= jump_angle) continue;
            ++totals.num_jumps;
            if (source <= jump_angle) ++totals.num_new_jumps;
        }
    }

    void add_totals(RetargetReport& report) const
    {
        const Skeleton& skeleton = standard_skeleton();
        std::vector<ErrorSum> errors(targets_.landmarks().size());
        std::vector<LimitHits> hits(skeleton.joint_names.size());
        long num_iterations = 0;
        // In the order of the pieces: sums do not depend on which thread was first.
        for (const PieceTotals& piece : pieces_) {
            for (std::size_t k = 0; k < errors.size(); ++k) {
                errors[k].sum += piece.errors[k].sum;
                errors[k].before += piece.errors[k].before;
                errors[k].uniform += piece.errors[k].uniform;
                errors[k].max = std::max(errors[k].max, piece.errors[k].max);
            }
            for (std::size_t j = 0; j < hits.size(); ++j) {
                hits[j].num_frames += piece.hits[j].num_frames;
                hits[j].num_far_frames += piece.hits[j].num_far_frames;
                hits[j].max_excess = std::max(hits[j].max_excess, piece.hits[j].max_excess);
            }
            report.num_violating_frames += piece.num_violating;
            report.num_far_frames += piece.num_far;
            report.num_jumps += piece.num_jumps;
            report.num_new_jumps += piece.num_new_jumps;
            report.max_jump = std::max(report.max_jump, piece.max_jump);
            report.max_source_jump = std::max(report.max_source_jump, piece.max_source_jump);
            num_iterations += piece.num_iterations;
        }
        const double share = 1.0 / num_frames_;
        for (std::size_t k = 0; k < errors.size(); ++k) {
            report.joint_errors.push_back({skeleton.joint_names[targets_.landmarks()[k]], share * errors[k].sum,
                                           errors[k].max, share * errors[k].before, share * errors[k].uniform});
            const double of_all = share / static_cast<double>(errors.size());
            report.mean_error += of_all * errors[k].sum;
            report.mean_error_before += of_all * errors[k].before;
            report.mean_error_uniform += of_all * errors[k].uniform;
            report.max_error = std::max(report.max_error, errors[k].max);
        }
        for (std::size_t j = 0; j < hits.size(); ++j) {
            hits[j].joint = skeleton.joint_names[j];
            if (hits[j].num_frames > 0) report.limit_hits.push_back(hits[j]);
        }
        report.mean_iterations = share * static_cast<double>(num_iterations);
        report.limits_checked = options_.limits != nullptr;
        report.limits_clamped = report.limits_checked && options_.clamp_limits;
    }

    const RetargetOptions& options_;
    Points rest_;
    int first_frame_, num_frames_ = 0;
    RotationTransfer transfer_;
    ScaledTargets targets_;
    InverseKinematics kinematics_;
    std::vector<int> mapped_parents_, kept_;
    std::vector<double> speeds_;  ///< rad/s from each frame to the next
    std::vector<PieceTotals> pieces_;
    std::vector<Pose> poses_;           ///< of kept_
    std::vector<DroppedJoint> beyond_;  ///< of kept_
};

}  // namespace

void describe(OptionList& list, RetargetOptions& options)
{
    list.add("frame-rate", options.frame_rate, "poses kept a second (Hz), 0: every frame", 0, 1000);
    list.add("max-joint-speed", options.max_joint_speed, "drop frames where a joint turns faster (degrees/s): glitches",
             1, 1e9);
    list.add("max-joint-angle", options.max_joint_angle,
             "drop frames with a joint further from rest (degrees), 180: none", 0, 180);
    list.add("inverse-kinematics", options.inverse_kinematics,
             "match joint positions; without, rotations are transferred alone");
    list.add("clamp-joint-limits", options.clamp_limits, "bring joints to the border of their range");
}

PoseSet retarget_clip(const MotionClip& clip, const JointMap& map, const Eigen::Ref<const Points>& joint_positions,
                      const RetargetOptions& options, RetargetReport& report)
{
    report = RetargetReport();
    report.clip_name = clip.name;
    report.joint_map = map.path;
    report.num_frames = clip.num_frames();
    report.frame_rate = clip.frame_rate;
    report.frame_rate_assumed = clip.frame_rate_assumed;
    report.num_skipped = std::min(map.skip_first_frames, clip.num_frames());
    require_input(report.num_skipped < clip.num_frames(), "clip {}: has {} frames and the joint map {} skips {}",
                  clip.name, clip.num_frames(), map.path, map.skip_first_frames);
    return ClipRetargeter(clip, map, joint_positions, options, report.num_skipped).collect(report);
}

void append_poses(PoseSet& poses, const PoseSet& addition)
{
    const int offset = static_cast<int>(poses.clip_names.size());
    poses.poses.insert(poses.poses.end(), addition.poses.begin(), addition.poses.end());
    for (const int clip : addition.clip_idx) poses.clip_idx.push_back(clip + offset);
    poses.frame_idx.insert(poses.frame_idx.end(), addition.frame_idx.begin(), addition.frame_idx.end());
    poses.clip_names.insert(poses.clip_names.end(), addition.clip_names.begin(), addition.clip_names.end());
    poses.clip_frame_rates.insert(poses.clip_frame_rates.end(), addition.clip_frame_rates.begin(),
                                  addition.clip_frame_rates.end());
}

}  // namespace ndg
