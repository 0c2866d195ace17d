// SPDX-License-Identifier: Apache-2.0
// Farthest-point sampling of many poses, against the algorithm written down as it is defined. Without --poses:
// synthetic motion.
#include "ndg/motion/pose_sampling.h"
#include "ndg/body/pose_set.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/geometry/rotation.h"
#include "report.h"

#include <chrono>
#include <ctime>
#include <functional>
#include <limits>

using namespace ndg;

namespace {

Eigen::Matrix3d turn_by(const Eigen::Vector3d& rotation_vector)
{
    const double angle = rotation_vector.norm();
    if (angle == 0.0) return Eigen::Matrix3d::Identity();
    return Eigen::AngleAxisd(angle, rotation_vector / angle).toRotationMatrix();
}

Eigen::Vector3d normal_vector(Random& random)
{
    const double x = random.normal(), y = random.normal(), z = random.normal();
    return {x, y, z};
}

/// Clips of 250 frames at 30 Hz. Each joint has a range of its own, 0.02 to 0.5 rad (standard deviation); a clip has a
/// mean pose within it, and its frames follow a smooth random walk about that (white noise through two low passes of
/// half a second). Joint 0 does not move, as after remove_root_motion.
std::vector<Pose> synthetic_motion(int count, int num_joints, std::uint64_t seed)
{
    constexpr int clip_frames = 250, warm_up = 60;
    constexpr double keep = 0.94, gain = 0.043;  // gain: the twice filtered noise has standard deviation 0.5
    Random ranges(seed, "ranges");
    std::vector<double> range(num_joints, 0.0);
    for (int j = 1; j < num_joints; ++j) range[j] = 0.02 * std::pow(25.0, ranges.uniform());
    std::vector<Pose> poses(count, Pose::rest(num_joints));
#pragma omp parallel for schedule(static)
    for (int begin = 0; begin < count; begin += clip_frames) {
        for (int j = 1; j < num_joints; ++j) {
            Random random(seed, "clip", static_cast<std::uint64_t>(begin) * num_joints + j);
            const Eigen::Vector3d mean = normal_vector(random);
            Eigen::Vector3d once = Eigen::Vector3d::Zero(), twice = Eigen::Vector3d::Zero();
            for (int i = begin - warm_up; i < std::min(count, begin + clip_frames); ++i) {
                once = keep * once + gain * normal_vector(random);
                twice = keep * twice + once;
                if (i >= begin) poses[i].parent_from_joint[j] = turn_by(range[j] * (mean + twice));
            }
        }
    }
    return poses;
}

/// The poses of a file, then poses between successive frames of a clip, turned a little (0.02 rad) at each moving
/// joint.
std::vector<Pose> multiplied(const PoseSet& set, int count, std::uint64_t seed)
{
    std::vector<Pose> poses(count);
#pragma omp parallel for schedule(static)
    for (int i = 0; i < count; ++i) {
        const int base = i % set.size(), following = std::min(base + 1, set.size() - 1);
        poses[i] = set.poses[base];
        remove_root_motion(poses[i]);
        if (i < set.size()) continue;
        const bool same_clip = set.clip_idx[base] == set.clip_idx[following];
        const Pose& other = set.poses[same_clip ? following : base];
        Random random(seed, "multiplied", i);
        const double share = random.uniform();
        for (std::size_t j = 1; j < poses[i].parent_from_joint.size(); ++j) {
            Eigen::Matrix3d& rotation = poses[i].parent_from_joint[j];
            const Eigen::Vector3d jitter = 0.02 * normal_vector(random);
            if (rotation == set.poses.front().parent_from_joint[j]) continue;
            const Eigen::Quaterniond between =
                to_quaternion(rotation).slerp(share, to_quaternion(other.parent_from_joint[j]));
            rotation = between.toRotationMatrix() * turn_by(jitter);
        }
    }
    return poses;
}

/// The definition: every pick updates the distance of every candidate. All threads, quaternions made beforehand.
class Naive {
public:
    explicit Naive(const std::vector<Pose>& poses)
        : num_poses_(static_cast<int>(poses.size())), num_joints_(static_cast<int>(poses[0].parent_from_joint.size()))
    {
        for (const Pose& pose : poses) {
            for (const Eigen::Matrix3d& rotation : pose.parent_from_joint) joints_.push_back(to_quaternion(rotation));
        }
    }

    std::vector<int> sample(int count, int first_idx) const
    {
        std::vector<int> order = {first_idx};
        std::vector<double> nearest(num_poses_, std::numeric_limits<double>::infinity());
        while (true) {
            const Eigen::Quaterniond* q = joints_.data() + static_cast<std::size_t>(order.back()) * num_joints_;
#pragma omp parallel for schedule(static)
            for (int i = 0; i < num_poses_; ++i) {
                const Eigen::Quaterniond* p = joints_.data() + static_cast<std::size_t>(i) * num_joints_;
                double sum = 0.0;
                for (int j = 0; j < num_joints_; ++j) sum += rotation_angle(p[j], q[j]);
                nearest[i] = std::min(nearest[i], sum);
            }
            const auto farthest = std::max_element(nearest.begin(), nearest.end());
            if (static_cast<int>(order.size()) == count) return order;
            order.push_back(static_cast<int>(farthest - nearest.begin()));
        }
    }

private:
    int num_poses_, num_joints_;
    std::vector<Eigen::Quaterniond> joints_;
};

struct Times {
    double seconds = 0.0;       ///< passed
    double core_seconds = 0.0;  ///< of processor time, all threads
};

Times times_of(const std::function<void()>& work)
{
    const auto core_seconds = [] {
        timespec time{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    };
    const auto start = std::chrono::steady_clock::now();
    const double core_start = core_seconds();
    work();
    return {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
            core_seconds() - core_start};
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-pose-sampling", "Times farthest-point sampling of poses.",
              "bench_pose_sampling --candidates 5000 --picks 500 --output out/bench/pose_sampling.json");
    std::string poses_path, output;
    int candidates = 100000, picks = 15000, naive_picks = 20, joints = 60;
    tool.input("poses", poses_path, "poses, multiplied to the number of candidates; synthetic motion without it",
               false);
    tool.parameter("candidates", candidates, "poses to choose from", 1, 10000000);
    tool.parameter("picks", picks, "poses to pick", 1, 10000000);
    tool.parameter("naive-picks", naive_picks, "picks of the straightforward algorithm, each costs the same", 2,
                   10000000);
    tool.parameter("joints", joints, "joints of the synthetic motion", 2, 1000);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        require_input(picks <= candidates, "--picks {} is more than --candidates {}", picks, candidates);
        require_input(naive_picks <= picks, "--naive-picks {} is more than --picks {}", naive_picks, picks);
        const std::vector<Pose> poses = poses_path.empty()
                                            ? synthetic_motion(candidates, joints, tool.seed())
                                            : multiplied(read_poses(poses_path), candidates, tool.seed());
        PoseSampling sampling;
        const Times fast = times_of([&] { sampling = farthest_point_sampling(poses, picks, {0}); });
        std::vector<int> naive_order;
        Times naive;
        {
            const Naive algorithm(poses);
            naive = times_of([&] { naive_order = algorithm.sample(naive_picks, 0); });
        }
        require(std::equal(naive_order.begin(), naive_order.end(), sampling.order.begin()),
                "the two algorithms picked different poses");

        bench::Report report("pose_sampling");
        report.add("candidates", candidates);
        report.add("joints", static_cast<double>(poses.front().parent_from_joint.size()));
        report.add("picks", picks);
        report.add("threads", num_threads());
        report.add("seconds", fast.seconds);
        report.add("core_seconds", fast.core_seconds);
        report.add("picks_per_second", picks / fast.seconds);
        report.add("naive_picks_timed", naive_picks);
        report.add("naive_seconds_per_pick", naive.seconds / naive_picks);
        report.add("naive_seconds_scaled", naive.seconds / naive_picks * picks);
        report.add("speedup_over_naive", naive.seconds / naive_picks * picks / fast.seconds);
        report.add("core_speedup_over_naive", naive.core_seconds / naive_picks * picks / fast.core_seconds);
        report.add("same_picks_checked", static_cast<double>(naive_order.size()));
        report.add("first_covering_radius", sampling.covering_radius.front());
        report.add("last_covering_radius", sampling.covering_radius.back());
        fmt::print(
            "The straightforward algorithm was timed over {} picks and scaled to {}: every pick costs the same.\n"
            "Both ran on {} threads and agreed on the first {} picks.\n",
            naive_picks, picks, num_threads(), naive_picks);
        report.print();
        if (!output.empty()) report.write(output);
    });
}
