// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/dataset/make_splits.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// Clips of `seconds` each at 120 Hz, a pose every tenth of a second; clip 1 at 30 Hz.
PoseSet clips(const std::vector<double>& seconds)
{
    PoseSet poses;
    for (std::size_t c = 0; c < seconds.size(); ++c) {
        const double rate = c == 1 ? 30.0 : 120.0;
        poses.clip_names.push_back("clip" + std::to_string(c));
        poses.clip_frame_rates.push_back(rate);
        for (int k = 0; k < seconds[c] * 10; ++k) {
            poses.poses.push_back(Pose::rest(1));
            poses.clip_idx.push_back(static_cast<int>(c));
            poses.frame_idx.push_back(static_cast<int>(k * rate / 10));
        }
    }
    return poses;
}

/// Every third to tenth pose, in random order, as a farthest-point subset has them.
PoseSet subset(const PoseSet& all, int count)
{
    Random random(4, "subset");
    PoseSet poses;
    poses.clip_names = all.clip_names;
    poses.clip_frame_rates = all.clip_frame_rates;
    const std::vector<int> order = random.permutation(all.size());
    for (int k = 0; k < count; ++k) {
        poses.poses.push_back(all.poses[order[k]]);
        poses.clip_idx.push_back(all.clip_idx[order[k]]);
        poses.frame_idx.push_back(all.frame_idx[order[k]]);
    }
    return poses;
}

/// Least time between poses of one clip in different splits, over all pairs of poses.
double least_gap(const PoseSet& poses, const Splits& splits)
{
    double gap = 1e300;
    for (const auto& [a, first] : splits.poses) {
        for (const auto& [b, second] : splits.poses) {
            if (a == b) continue;
            for (const int i : first) {
                for (const int k : second) {
                    if (poses.clip_idx[i] != poses.clip_idx[k]) continue;
                    const double rate = poses.clip_frame_rates[poses.clip_idx[i]];
                    gap = std::min(gap, std::abs(poses.frame_idx[i] - poses.frame_idx[k]) / rate);
                }
            }
        }
    }
    return gap;
}

void check_pairs(const Splits& splits, const SplitOptions& options)
{
    for (std::size_t s = 0; s < split_names.size(); ++s) {
        const std::string& name = split_names[s];
        INFO(name);
        const auto& bodies = splits.bodies.at(name);
        const auto& poses = splits.poses.at(name);
        const auto& pairs = splits.pairs.at(name);
        REQUIRE(static_cast<int>(pairs.size()) == options.num_pairs[s]);
        std::set<std::pair<int, int>> seen;
        std::map<int, int> body_uses, pose_uses;
        for (const int body : bodies) body_uses[body] = 0;
        for (const int pose : poses) pose_uses[pose] = 0;
        for (const SamplePair& pair : pairs) {
            CHECK(seen.insert({pair.body_idx, pair.pose_idx}).second);
            REQUIRE(body_uses.count(pair.body_idx) == 1);
            REQUIRE(pose_uses.count(pair.pose_idx) == 1);
            ++body_uses[pair.body_idx];
            ++pose_uses[pair.pose_idx];
        }
        for (const auto* uses : {&body_uses, &pose_uses}) {
            int low = 1 << 30, high = 0;
            for (const auto& [idx, count] : *uses) {
                low = std::min(low, count);
                high = std::max(high, count);
            }
            CHECK(high - low <= 1);
        }
    }
}

void check_disjoint(const std::map<std::string, std::vector<int>>& splits, int count, int least_used)
{
    std::set<int> seen;
    for (const auto& [name, members] : splits) {
        CHECK_FALSE(members.empty());
        for (const int idx : members) {
            CHECK(idx >= 0);
            CHECK(idx < count);
            CHECK(seen.insert(idx).second);
        }
    }
    CHECK(static_cast<int>(seen.size()) >= least_used);
}

/// What splits must not do; "" where they do not. Every pair of poses is looked at, whatever made the splits.
std::string fault(const PoseSet& poses, const Splits& splits, double guard_seconds)
{
    for (const auto& [what, members] :
         {std::make_pair("body", &splits.bodies), std::make_pair("pose", &splits.poses)}) {
        std::map<int, std::string> split_of;
        for (const auto& [name, indices] : *members) {
            for (const int idx : indices) {
                if (!split_of.emplace(idx, name).second) return fmt::format("{} {} is in two splits", what, idx);
            }
        }
    }
    for (const auto& [name, pairs] : splits.pairs) {
        std::set<std::pair<int, int>> seen;
        for (const SamplePair& pair : pairs) {
            const auto &bodies = splits.bodies.at(name), &of_split = splits.poses.at(name);
            if (std::count(bodies.begin(), bodies.end(), pair.body_idx) != 1)
                return "a pair has a body of another split";
            if (std::count(of_split.begin(), of_split.end(), pair.pose_idx) != 1) {
                return "a pair has a pose of another split";
            }
            if (!seen.insert({pair.body_idx, pair.pose_idx}).second) return "a pair is drawn twice";
        }
    }
    if (least_gap(poses, splits) < guard_seconds - 1e-9) return "neighbouring frames are in two splits";
    return "";
}

}  // namespace

TEST_CASE("splits are disjoint, near the fractions and apart in time")
{
    const PoseSet all = clips({40, 25, 3, 61, 8});
    const bool sampled = GENERATE(false, true);
    const PoseSet poses = sampled ? subset(all, 150) : all;
    SplitOptions options;
    options.num_pairs = {300, 20, 20};
    options.seed = GENERATE(1, 2, 3);
    const Splits splits = make_splits(25, poses, options);
    check_disjoint(splits.bodies, 25, 25);
    check_disjoint(splits.poses, poses.size(), static_cast<int>(0.8 * poses.size()));
    check_pairs(splits, options);
    CHECK(splits.bodies.at("train").size() == 19);
    CHECK(splits.bodies.at("test").size() == 3);
    CHECK(least_gap(poses, splits) >= 0.5 - 1e-9);
    CHECK(fault(poses, splits, options.guard_seconds).empty());
    for (const auto& [name, fraction] :
         std::map<std::string, double>{{"train", 0.8}, {"validation", 0.1}, {"test", 0.1}}) {
        CHECK(static_cast<double>(splits.poses.at(name).size()) ==
              Approx(fraction * poses.size()).margin(0.07 * poses.size()));
    }
}

TEST_CASE("a guard longer than a segment still holds")
{
    const PoseSet poses = clips({60, 60});
    SplitOptions options;
    options.segment_seconds = 1.0;
    options.guard_seconds = 2.6;
    options.num_pairs = {5, 5, 5};
    const Splits splits = make_splits(10, poses, options);
    CHECK(least_gap(poses, splits) >= 2.6 - 1e-9);
}

TEST_CASE("a shared body, pose or neighbourhood would be found")
{
    const PoseSet poses = clips({40, 25, 30});
    SplitOptions options;
    options.num_pairs = {50, 5, 5};
    const Splits good = make_splits(20, poses, options);
    CHECK(fault(poses, good, 0.5).empty());

    Splits bad = good;
    bad.bodies["test"].push_back(bad.bodies["train"].front());
    CHECK_THAT(fault(poses, bad, 0.5), Contains("is in two splits"));
    bad = good;
    bad.poses["validation"].push_back(bad.poses["test"].back());
    CHECK_THAT(fault(poses, bad, 0.5), Contains("is in two splits"));
    bad = good;
    bad.pairs["test"].front().body_idx = bad.bodies["train"].front();
    CHECK_THAT(fault(poses, bad, 0.5), Contains("body of another split"));
    bad = good;
    bad.pairs["test"].front().pose_idx = bad.poses["train"].front();
    CHECK_THAT(fault(poses, bad, 0.5), Contains("pose of another split"));
    bad = good;
    bad.pairs["train"].back() = bad.pairs["train"].front();
    CHECK_THAT(fault(poses, bad, 0.5), Contains("drawn twice"));
    // A pose of train goes to the test split while the frame beside it stays.
    bad = good;
    const int moved = bad.poses["train"][bad.poses["train"].size() / 2];
    bad.poses["train"].erase(std::find(bad.poses["train"].begin(), bad.poses["train"].end(), moved));
    bad.poses["test"].push_back(moved);
    bad.pairs.clear();
    CHECK_THAT(fault(poses, bad, 0.5), Contains("neighbouring frames"));
    // Without a guard poses on both sides of a border are neighbours.
    options.guard_seconds = 0.0;
    CHECK_THAT(fault(poses, make_splits(20, poses, options), 0.5), Contains("neighbouring frames"));
}

TEST_CASE("the same seed gives the same splits, another seed others")
{
    const PoseSet poses = clips({40, 25, 30});
    SplitOptions options;
    options.num_pairs = {100, 5, 5};
    const Splits a = make_splits(20, poses, options), b = make_splits(20, poses, options);
    options.seed = 9;
    const Splits c = make_splits(20, poses, options);
    CHECK(a.bodies == b.bodies);
    CHECK(a.poses == b.poses);
    CHECK(a.poses != c.poses);
    bool same = true, other = false;
    for (std::size_t k = 0; k < 100; ++k) {
        const SamplePair &x = a.pairs.at("train")[k], &y = b.pairs.at("train")[k], &z = c.pairs.at("train")[k];
        same = same && x.body_idx == y.body_idx && x.pose_idx == y.pose_idx;
        other = other || x.body_idx != z.body_idx || x.pose_idx != z.pose_idx;
    }
    CHECK(same);
    CHECK(other);
}

TEST_CASE("all pairs can be drawn, and not one more")
{
    const PoseSet poses = clips({40, 25, 30});
    SplitOptions options;
    const Splits small = make_splits(20, poses, options);
    for (std::size_t s = 0; s < 3; ++s) {
        const std::string& name = split_names[s];
        options.num_pairs[s] = static_cast<int>(small.bodies.at(name).size() * small.poses.at(name).size());
    }
    check_pairs(make_splits(20, poses, options), options);
    ++options.num_pairs[2];
    CHECK_THROWS_AS(make_splits(20, poses, options), InputError);
    CHECK_THROWS_WITH(make_splits(20, poses, options), Contains("test pairs were asked for"));
}

TEST_CASE("splits without body or pose and wrong options are refused")
{
    const PoseSet poses = clips({40, 25, 30});
    SplitOptions options;
    CHECK_NOTHROW(make_splits(3, poses, options));
    CHECK_THROWS_WITH(make_splits(2, poses, options), Contains("2 bodies are too few"));
    CHECK_THROWS_WITH(make_splits(20, clips({3.5}), options), Contains("1 segments"));
    options.fractions = {0.8, 0.1, 0.2};
    CHECK_THROWS_WITH(make_splits(20, poses, options), Contains("add up to 1.1"));
    options.fractions = {0.9, 0.1, 0.0};
    CHECK_THROWS_WITH(make_splits(20, poses, options), Contains("test-fraction"));
    options = SplitOptions();
    options.segment_seconds = 0.0;
    CHECK_THROWS_AS(make_splits(20, poses, options), InputError);
}

TEST_CASE("spliced poses serve training, and nothing of validation or testing reaches it in them")
{
    PoseSet poses = clips({20, 16, 30, 12});
    const int num_captured = poses.size();
    const int num_spliced = 400;
    poses.clip_names.emplace_back("spliced");
    poses.clip_frame_rates.push_back(30.0);
    poses.spliced_from.setConstant(num_captured + num_spliced, 6, -1);
    Random random(3, "splices");
    for (int k = 0; k < num_spliced; ++k) {
        poses.poses.push_back(Pose::rest(1));
        poses.clip_idx.push_back(4);
        poses.frame_idx.push_back(k);
        for (int part = 0; part < 3; ++part) {
            const int source = static_cast<int>(random.below(static_cast<std::uint64_t>(num_captured)));
            poses.spliced_from(num_captured + k, 2 * part) = poses.clip_idx[source];
            poses.spliced_from(num_captured + k, 2 * part + 1) = poses.frame_idx[source];
        }
    }
    SplitOptions options;
    options.segment_seconds = 2.0;
    options.seed = 1;
    const Splits splits = make_splits(10, poses, options);
    const auto seconds = [&](int clip, int frame) { return frame / poses.clip_frame_rates[clip]; };
    for (const std::string split : {"validation", "test"}) {
        CHECK(splits.poses.at(split).size() > 0.05 * num_captured);
        CHECK(splits.poses.at(split).size() < 0.15 * num_captured);
        for (const int i : splits.poses.at(split)) CHECK_FALSE(poses.is_spliced(i));
    }
    int used = 0;
    for (const int i : splits.poses.at("train")) {
        if (!poses.is_spliced(i)) continue;
        ++used;
        for (const std::string split : {"validation", "test"})
            for (const int other : splits.poses.at(split))
                for (int part = 0; part < 3; ++part) {
                    if (poses.spliced_from(i, 2 * part) != poses.clip_idx[other]) continue;
                    const double apart = std::abs(seconds(poses.clip_idx[other], poses.frame_idx[other]) -
                                                  seconds(poses.clip_idx[other], poses.spliced_from(i, 2 * part + 1)));
                    REQUIRE(apart >= options.guard_seconds - 1e-9);
                }
    }
    // Four fifths of the captured poses serve training: about half of the triples come from them alone.
    CHECK(used > 0.3 * num_spliced);
    CHECK(used < 0.65 * num_spliced);
}

TEST_CASE("Bodies that training never saw take all poses of one split and no other")
{
    Splits known;
    known.poses = {{"train", {0, 1, 4}}, {"validation", {2}}, {"test", {3, 5}}};
    const Splits splits = unseen_bodies_splits(known, "test", 2);
    CHECK(splits.pairs.at("test") == std::vector<SamplePair>{{0, 3}, {0, 5}, {1, 3}, {1, 5}});
    CHECK(splits.bodies.at("test") == std::vector<int>{0, 1});
    CHECK(splits.poses.at("test") == known.poses.at("test"));
    for (const char* name : {"train", "validation"}) {
        CHECK(splits.pairs.at(name).empty());
        CHECK(splits.poses.at(name).empty());
        CHECK(splits.bodies.at(name).empty());
    }
    known.poses["test"].clear();
    CHECK_THROWS_AS(unseen_bodies_splits(known, "test", 2), InputError);
}
