// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/make_splits.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <set>

namespace ndg {

namespace {

constexpr int num_splits = 3;
constexpr int num_draws = 64;

/// Poses of one segment of one clip.
struct Segment {
    int clip = 0;
    long long number = 0;  ///< segment_seconds * number is where it begins
    std::vector<int> poses;
};

double pose_time(const PoseSet& poses, int pose_idx)
{
    return poses.frame_idx[pose_idx] / poses.clip_frame_rates[poses.clip_idx[pose_idx]];
}

std::vector<Segment> cut_segments(const PoseSet& poses, double segment_seconds)
{
    std::map<std::pair<int, long long>, std::vector<int>> by_segment;
    for (int i = 0; i < poses.size(); ++i) {
        if (poses.is_spliced(i)) continue;
        const auto number = static_cast<long long>(std::floor(pose_time(poses, i) / segment_seconds));
        by_segment[{poses.clip_idx[i], number}].push_back(i);
    }
    std::vector<Segment> segments;
    for (auto& [key, members] : by_segment) segments.push_back({key.first, key.second, std::move(members)});
    return segments;
}

using PoseSplits = std::array<std::vector<int>, num_splits>;

/// Poses of every split for a given assignment of segments, without those nearer than half the guard to a border with
/// another split. A neighbouring segment without poses is of no split, but the border beyond it may still be near.
PoseSplits collect(const PoseSet& poses, const std::vector<Segment>& segments, const std::vector<int>& split_of_segment,
                   const SplitOptions& options)
{
    std::map<std::pair<int, long long>, int> split_at;
    for (std::size_t s = 0; s < segments.size(); ++s) {
        split_at[{segments[s].clip, segments[s].number}] = split_of_segment[s];
    }
    const double guard = 0.5 * options.guard_seconds;
    const auto reach = static_cast<long long>(std::ceil(options.guard_seconds / options.segment_seconds)) + 1;
    PoseSplits result;
    for (std::size_t s = 0; s < segments.size(); ++s) {
        const Segment& segment = segments[s];
        const int split = split_of_segment[s];
        // Nearest borders of segments of other splits, from below and above.
        double below = -std::numeric_limits<double>::infinity(), above = -below;
        for (long long step = 1; step <= reach; ++step) {
            const auto before = split_at.find({segment.clip, segment.number - step});
            const auto after = split_at.find({segment.clip, segment.number + step});
            if (before != split_at.end() && before->second != split) {
                below = std::max(below, (segment.number - step + 1) * options.segment_seconds);
            }
            if (after != split_at.end() && after->second != split) {
                above = std::min(above, (segment.number + step) * options.segment_seconds);
            }
        }
        for (const int i : segment.poses) {
            const double time = pose_time(poses, i);
            if (time - below >= guard && above - time >= guard) result[split].push_back(i);
        }
    }
    for (std::vector<int>& split : result) std::sort(split.begin(), split.end());
    return result;
}

/// Segments in random order fill test, then validation, each while that brings it nearer to its share.
std::vector<int> draw_assignment(const std::vector<Segment>& segments, int num_poses, const SplitOptions& options,
                                 int draw)
{
    Random random(options.seed, "pose splits", draw);
    const std::vector<int> order = random.permutation(static_cast<int>(segments.size()));
    std::vector<int> split_of_segment(segments.size(), 0);
    std::array<double, num_splits> missing{};
    for (int k = 0; k < num_splits; ++k) missing[k] = options.fractions[k] * num_poses;
    for (const int s : order) {
        const auto size = static_cast<double>(segments[s].poses.size());
        for (const int split : {2, 1}) {
            if (std::abs(missing[split] - size) < missing[split]) {
                split_of_segment[s] = split;
                missing[split] -= size;
                break;
            }
        }
    }
    return split_of_segment;
}

/// How far the used poses are from the wanted fractions of all poses; infinite with an empty split.
double deviation(const PoseSplits& splits, int num_poses, const SplitOptions& options)
{
    double sum = 0.0;
    for (int k = 0; k < num_splits; ++k) {
        if (splits[k].empty()) return std::numeric_limits<double>::infinity();
        sum += std::abs(static_cast<double>(splits[k].size()) - options.fractions[k] * num_poses);
    }
    return sum;
}

/// Spliced poses go to training if nothing they were made of is in a segment of validation or testing, or nearer than
/// the guard to one of their poses.
void add_spliced(const PoseSet& poses, const SplitOptions& options, PoseSplits& splits)
{
    std::map<int, std::vector<double>> withheld;  // clip -> times of poses of validation and testing
    std::set<std::pair<int, long long>> withheld_segments;
    const auto segment = [&](double time) {
        return static_cast<long long>(std::floor(time / options.segment_seconds));
    };
    for (const int split : {1, 2})
        for (const int i : splits[split]) {
            withheld[poses.clip_idx[i]].push_back(pose_time(poses, i));
            withheld_segments.insert({poses.clip_idx[i], segment(pose_time(poses, i))});
        }
    for (int i = 0; i < poses.size(); ++i) {
        if (!poses.is_spliced(i)) continue;
        bool free = true;
        for (int part = 0; part < 3 && free; ++part) {
            const int clip = poses.spliced_from(i, 2 * part);
            const double time = poses.spliced_from(i, 2 * part + 1) / poses.clip_frame_rates[clip];
            free = withheld_segments.count({clip, segment(time)}) == 0;
            for (const double other : withheld[clip]) free = free && std::abs(other - time) >= options.guard_seconds;
        }
        if (free) splits[0].push_back(i);
    }
}

PoseSplits split_poses(const PoseSet& poses, const SplitOptions& options)
{
    const std::vector<Segment> segments = cut_segments(poses, options.segment_seconds);
    int num_captured = 0;
    for (const Segment& segment : segments) num_captured += static_cast<int>(segment.poses.size());
    PoseSplits best;
    double best_deviation = std::numeric_limits<double>::infinity();
    for (int draw = 0; draw < num_draws; ++draw) {
        const PoseSplits splits =
            collect(poses, segments, draw_assignment(segments, num_captured, options, draw), options);
        const double value = deviation(splits, num_captured, options);
        if (value < best_deviation) {
            best = splits;
            best_deviation = value;
        }
    }
    require_input(std::isfinite(best_deviation),
                  "{} poses in {} segments of {} s do not give each of train, validation and test a pose", num_captured,
                  segments.size(), options.segment_seconds);
    add_spliced(poses, options, best);
    return best;
}

std::array<std::vector<int>, num_splits> split_bodies(int num_bodies, const SplitOptions& options)
{
    require_input(num_bodies >= num_splits, "{} bodies are too few for train, validation and test", num_bodies);
    Random random(options.seed, "body splits");
    const std::vector<int> order = random.permutation(num_bodies);
    std::array<int, num_splits> counts{};
    for (const int k : {1, 2})
        counts[k] = std::max(1, static_cast<int>(std::lround(options.fractions[k] * num_bodies)));
    while (counts[1] + counts[2] >= num_bodies) --counts[counts[1] >= counts[2] ? 1 : 2];
    counts[0] = num_bodies - counts[1] - counts[2];
    std::array<std::vector<int>, num_splits> result;
    auto next = order.begin();
    for (int k = 0; k < num_splits; ++k) {
        result[k].assign(next, next + counts[k]);
        std::sort(result[k].begin(), result[k].end());
        next += counts[k];
    }
    return result;
}

/// Walks (k mod B, k mod P), which visits lcm(B, P) different pairs, then shifts the pose by one, and so on: all B P
/// pairs once, with every body and pose in even turns. Bodies and poses are shuffled before.
std::vector<SamplePair> draw_pairs(const std::vector<int>& bodies, const std::vector<int>& poses, int count,
                                   const SplitOptions& options, int split)
{
    const auto num_bodies = static_cast<long long>(bodies.size());
    const auto num_poses = static_cast<long long>(poses.size());
    require_input(count <= num_bodies * num_poses, "{} {} pairs were asked for, {} bodies and {} poses give {}", count,
                  split_names[split], num_bodies, num_poses, num_bodies * num_poses);
    Random random(options.seed, "pairs", split);
    const std::vector<int> body_order = random.permutation(static_cast<int>(num_bodies));
    const std::vector<int> pose_order = random.permutation(static_cast<int>(num_poses));
    const long long round = std::lcm(num_bodies, num_poses);
    std::vector<SamplePair> pairs;
    for (long long k = 0; k < count; ++k) {
        SamplePair pair;
        pair.body_idx = bodies[body_order[k % num_bodies]];
        pair.pose_idx = poses[pose_order[(k + k / round) % num_poses]];
        pairs.push_back(pair);
    }
    return pairs;
}

void check(const PoseSet& poses, const SplitOptions& options)
{
    check_options(options);
    const double sum = std::accumulate(options.fractions.begin(), options.fractions.end(), 0.0);
    require_input(std::abs(sum - 1.0) < 1e-6, "the split fractions add up to {}, not 1", sum);
    for (std::size_t c = 0; c < poses.clip_names.size(); ++c) {
        require_input(poses.clip_frame_rates[c] > 0, "clip {} has frame rate {}", poses.clip_names[c],
                      poses.clip_frame_rates[c]);
    }
}

}  // namespace

void describe(OptionList& list, SplitOptions& options)
{
    for (int k = 0; k < num_splits; ++k) {
        const std::string& name = split_names[k];
        list.add(name + "-fraction", options.fractions[k], "share of bodies and of poses for " + name, 1e-6, 1);
        list.add(name + "-pairs", options.num_pairs[k], "pairs for " + name, 1, 1000000000);
    }
    list.add("segment-seconds", options.segment_seconds, "clips are split in whole segments of this length (s)", 1e-3,
             1e9);
    list.add("guard-seconds", options.guard_seconds, "least time between poses of one clip in different splits (s)", 0,
             1e9);
}

Splits make_splits(int num_bodies, const PoseSet& poses, const SplitOptions& options)
{
    check(poses, options);
    const auto bodies = split_bodies(num_bodies, options);
    const auto pose_splits = split_poses(poses, options);
    Splits splits;
    for (int k = 0; k < num_splits; ++k) {
        const std::string& name = split_names[k];
        splits.bodies[name] = bodies[k];
        splits.poses[name] = pose_splits[k];
        splits.pairs[name] = draw_pairs(bodies[k], pose_splits[k], options.num_pairs[k], options, k);
    }
    return splits;
}

Splits unseen_bodies_splits(const Splits& known, const std::string& split, int num_bodies)
{
    Splits splits;
    for (const std::string& name : split_names) {
        splits.bodies[name];
        splits.poses[name];
        splits.pairs[name];
    }
    splits.poses[split] = known.poses.at(split);
    require_input(!splits.poses[split].empty(), "the split {} has no poses", split);
    for (int b = 0; b < num_bodies; ++b) {
        splits.bodies[split].push_back(b);
        for (const int pose : splits.poses[split]) splits.pairs[split].push_back({b, pose});
    }
    return splits;
}

}  // namespace ndg
