// SPDX-License-Identifier: Apache-2.0
// Mirror images and splices against samples that were posed so.
#include "ndg/neural/augmentation.h"

#include "ndg/core/error.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using namespace ndg::test;

namespace {

/// Poses of both arms of a tube that is its own mirror image, each sample followed by its mirror image; bodies are not
/// symmetric.
struct Mirrored {
    Synthetic s;
    TemplateMirror mirror;
};

/// Skinned, bulging on the left with the left forearm's bend and on the right with the right one's.
Points bulged(const Template& tube, const Body& body, const Pose& pose)
{
    Points rest = body.volume_vertices;
    const Skeleton& skeleton = tube.skeleton;
    const double left = pose.parent_from_joint[skeleton.joint("left_forearm")](1, 2);
    const double right = pose.parent_from_joint[skeleton.joint("right_forearm")](1, 2);
    for (Eigen::Index i = tube.num_wrap_vertices(); i < rest.rows(); ++i)
        rest(i, 2) *= 1.0 + 0.3 * (rest(i, 0) > 0 ? left * rest(i, 0) : -right * rest(i, 0)) / 0.08;
    return linear_blend_skinning(rest, tube.volume_weights(), forward_kinematics(skeleton, body.joint_positions, pose));
}

Mirrored make_mirrored(int num_pairs)
{
    Mirrored m;
    Synthetic& s = m.s = two_sided_tube();
    m.mirror = find_mirror(s.tube);
    Random random(9, "mirrored");
    for (int i = 0; i < 4; ++i) {
        Body body = s.tube.rest;
        for (Eigen::Index v = 0; v < body.volume_vertices.rows(); ++v)
            body.volume_vertices(v, 0) *= 1.0 + 0.1 * i * (body.volume_vertices(v, 0) > 0 ? 1 : 0.5);
        Body image = body;
        image.volume_vertices = m.mirror.mirrored(body.volume_vertices);
        s.bodies.bodies.push_back(body);
        s.bodies.bodies.push_back(image);
    }
    std::vector<const Points*> shapes;
    for (const Body& body : s.bodies.bodies) shapes.push_back(&body.volume_vertices);
    s.shape_space = fit_shape_space(shapes, 3, 1.0);
    DeformationSet set = no_samples(s.tube);
    for (int i = 0; i < num_pairs; ++i) {
        const Pose pose = two_arm_pose(random);
        s.poses.poses.push_back(pose);
        s.poses.poses.push_back(m.mirror.mirrored(pose));
        for (int side = 0; side < 2; ++side) {
            const int body_idx = 2 * (i % 4) + side, pose_idx = 2 * i + side;
            set.add({body_idx, pose_idx}, "train", bulged(s.tube, s.bodies.bodies[body_idx], s.poses.poses[pose_idx]));
        }
    }
    s.samples = {set};
    return m;
}

NetworkOptions network_of(const std::string& output_space)
{
    NetworkOptions options = small_network();
    options.output_space = output_space;
    return options;
}

Eigen::RowVectorXf target_of(const TrainingSet& set, int sample_idx)
{
    Eigen::RowVectorXf target(set.width());
    set.target(sample_idx, target.data());
    return target;
}

Eigen::RowVectorXf target_of(const Augmentation& augmentation, const TrainingSet& set, int sample_idx,
                             const SampleChange& change)
{
    Eigen::RowVectorXf target(set.width());
    augmentation.target(sample_idx, change, target.data());
    return target;
}

AugmentationOptions both()
{
    AugmentationOptions options;
    options.mirror = true;
    options.splice = 0.5;
    return options;
}

/// A training set and what becomes of its samples.
struct Augmented {
    NeuralModel model;
    TrainingSet set;
    Augmentation augmentation;

    Augmented(const Synthetic& s, const NetworkOptions& options)
        : model(s.model(options)),
          set(s.set("train", model)),
          augmentation(set, model.input_space(), model.output_space(), both(), 1)
    {
    }
};

}  // namespace

TEST_CASE("a mirrored sample is that of the mirrored body in the mirrored pose")
{
    const Mirrored m = make_mirrored(6);
    for (const char* output_space : {"residuals", "vertex-offsets"}) {
        CAPTURE(output_space);
        const Augmented augmented(m.s, network_of(output_space));
        const TrainingSet& set = augmented.set;
        const Augmentation& augmentation = augmented.augmentation;
        SampleChange change;
        change.mirrored = true;
        double largest_change = 0;
        for (int i = 0; i < set.size(); i += 2) {
            const Eigen::RowVectorXf expected = target_of(set, i + 1);
            const float size = expected.cwiseAbs().maxCoeff();
            CHECK((target_of(augmentation, set, i, change) - expected).cwiseAbs().maxCoeff() < 1e-5 * size);
            CHECK((augmentation.features(i, change) - set.features().row(i + 1)).cwiseAbs().maxCoeff() < 1e-5);
            largest_change = std::max<double>(largest_change, (expected - target_of(set, i)).norm());
        }
        CHECK(largest_change > 0.1);
    }
}

TEST_CASE("shares of the splice regions sum to one and fade across the seams")
{
    const Template tube = symmetric_tube_template(41);
    const SpliceRegions regions = find_splice_regions(tube);
    for (const RowMatrixF* shares : {&regions.vertex_shares, &regions.prism_shares}) {
        CHECK((shares->rowwise().sum().array() - 1.0F).abs().maxCoeff() < 1e-5);
        CHECK(shares->minCoeff() >= 0);
    }
    REQUIRE(regions.prism_shares.rows() == tube.num_prisms());
    const Skeleton& skeleton = tube.skeleton;
    const auto region_of = [&](const char* joint) { return regions.of_joints[skeleton.joint(joint)]; };
    CHECK(region_of("pelvis") == 0);
    CHECK(region_of("spine_2") == 0);
    CHECK(region_of("right_thigh") == 0);
    CHECK(region_of("spine_3") == 1);
    CHECK(region_of("left_upper_arm") == 1);
    CHECK(region_of("head") == 1);
    CHECK(region_of("left_hand") == 2);
    CHECK(region_of("right_forearm") == 3);
    CHECK(region_of("left_toes") == 4);
    CHECK(region_of("right_shin") == 5);
    // The tube's upper arms reach from 0.35 to 0.75 of its height: above they are forearm, the left one for x > 0.
    const Points& rest = tube.rest.volume_vertices;
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        const float forearms = regions.vertex_shares(v, 2) + regions.vertex_shares(v, 3);
        if (rest(v, 1) > 0.65) CHECK(forearms == Approx(1).margin(1e-5));
        if (rest(v, 1) < 0.45) CHECK(forearms == Approx(0).margin(1e-5));
        if (rest(v, 1) > 0.65 && rest(v, 0) > 0.05) CHECK(regions.vertex_shares(v, 2) > 0.8);
        if (rest(v, 1) < 0.08) CHECK(regions.vertex_shares(v, 0) == Approx(1).margin(1e-5));
    }
}

TEST_CASE("a sample spliced with itself is itself; with another it has both")
{
    const Mirrored m = make_mirrored(12);
    for (const char* output_space : {"residuals", "vertex-offsets"}) {
        CAPTURE(output_space);
        const Augmented augmented(m.s, network_of(output_space));
        const TrainingSet& set = augmented.set;
        const Augmentation& augmentation = augmented.augmentation;
        SampleChange change;
        change.other_idx = 0;
        change.from_other = 0b110110;
        CHECK(target_of(augmentation, set, 0, change) == target_of(set, 0));
        CHECK(augmentation.features(0, change) == set.features().row(0));

        // Sample 8 is of the same body: the left forearm of its pose, and residuals of the tube's upper left end.
        change.other_idx = 8;
        change.from_other = 0b000100;
        const Eigen::RowVectorXf features = augmentation.features(0, change);
        const int forearm = 9 * m.s.tube.skeleton.joint("left_forearm"), arm = 9 * m.s.tube.skeleton.joint("spine_2");
        CHECK(features.segment(forearm, 9) == set.features().row(8).segment(forearm, 9));
        CHECK(features.segment(arm, 9) == set.features().row(0).segment(arm, 9));
        const Eigen::RowVectorXf spliced = target_of(augmentation, set, 0, change), own = target_of(set, 0),
                                 other = target_of(set, 8);
        const SpliceRegions regions = find_splice_regions(m.s.tube);
        const bool prisms = set.width() == 9 * m.s.tube.num_prisms();
        const int size = prisms ? 9 : 3;
        for (int e = 0; e < set.width() / size; ++e) {
            const float share =
                prisms ? regions.prism_shares(e, 2) : regions.vertex_shares(m.s.tube.num_wrap_vertices() + e, 2);
            const auto part = [&](const Eigen::RowVectorXf& row) { return row.segment(size * e, size); };
            CHECK((part(spliced) - ((1 - share) * part(own) + share * part(other))).cwiseAbs().maxCoeff() < 1e-4);
        }
        CHECK((spliced - own).norm() > 1e-2);
        CHECK((spliced - other).norm() > 1e-2);
    }
}

TEST_CASE("changes are drawn anew in each epoch, from samples of the same body, and by seed alone")
{
    const Mirrored m = make_mirrored(40);
    const NeuralModel model = m.s.model(small_network());
    const TrainingSet set = m.s.set("train", model);
    const auto draws = [&](const AugmentationOptions& options, std::uint64_t seed) {
        const Augmentation augmentation(set, model.input_space(), model.output_space(), options, seed);
        std::vector<SampleChange> changes;
        for (int epoch = 0; epoch < 20; ++epoch)
            for (int i = 0; i < set.size(); ++i) changes.push_back(augmentation.draw(i, epoch));
        return changes;
    };
    const std::vector<SampleChange> changes = draws(both(), 1);
    int mirrored = 0, spliced = 0, differ_from_first_epoch = 0;
    for (std::size_t k = 0; k < changes.size(); ++k) {
        const int sample_idx = static_cast<int>(k) % set.size();
        mirrored += changes[k].mirrored;
        spliced += changes[k].other_idx >= 0;
        differ_from_first_epoch += changes[k].other_idx != changes[sample_idx].other_idx;
        if (changes[k].other_idx < 0) continue;
        REQUIRE(changes[k].other_idx != sample_idx);
        REQUIRE(set.pair(changes[k].other_idx).body_idx == set.pair(sample_idx).body_idx);
        REQUIRE((changes[k].from_other & 1U) == 0);
    }
    CHECK(mirrored == Approx(0.5 * changes.size()).epsilon(0.15));
    CHECK(spliced == Approx(0.5 * changes.size()).epsilon(0.15));
    CHECK(differ_from_first_epoch > 500);
    const std::vector<SampleChange> again = draws(both(), 1), others = draws(both(), 2);
    int same = 0, same_as_others = 0;
    for (std::size_t k = 0; k < changes.size(); ++k) {
        same += again[k].other_idx == changes[k].other_idx && again[k].from_other == changes[k].from_other;
        same_as_others += others[k].other_idx == changes[k].other_idx && others[k].from_other == changes[k].from_other;
    }
    CHECK(same == static_cast<int>(changes.size()));
    CHECK(same_as_others < same);
    AugmentationOptions splice_only;
    splice_only.splice = 1;
    for (const SampleChange& change : draws(splice_only, 1)) {
        REQUIRE(!change.mirrored);
        REQUIRE(change.other_idx >= 0);
    }
}

TEST_CASE("what has no mirror image is refused")
{
    const Synthetic s = make_synthetic(8, 2);
    NeuralModel model = s.model(small_network());
    TrainingOptions training;
    training.augmentation.mirror = true;
    CHECK_THROWS_WITH(train(model, s.set("train", model), s.set("validation", model), training),
                      Catch::Contains("no mirror image"));
}

TEST_CASE("gradients that turn with the joints above are not spliced")
{
    const Mirrored m = make_mirrored(8);
    NetworkOptions options = small_network();
    options.rotation = false;
    const NeuralModel model = m.s.model(options);
    const TrainingSet set = m.s.set("train", model);
    CHECK_THROWS_WITH(Augmentation(set, model.input_space(), model.output_space(), both(), 1),
                      Catch::Contains("residuals and offsets only"));
}

TEST_CASE("mirror images teach the other side")
{
    // Training sees one side of each pair only, and is tested on the other.
    Mirrored m = make_mirrored(60);
    std::vector<std::string>& splits = m.s.samples[0].pair_splits;
    for (std::size_t i = 0; i < splits.size(); ++i) splits[i] = i % 2 == 0 ? "train" : "validation";
    TrainingOptions training;
    training.epochs = 60;
    training.learning_rate = 5e-3;
    training.schedule = Schedule::cosine;
    const auto loss = [&] {
        NeuralModel model = m.s.model(small_network());
        train(model, m.s.set("train", model), m.s.set("validation", model), training);
        return model.curve().validation_loss[model.curve().best_epoch - 1];
    };
    const double without = loss();
    training.augmentation.mirror = true;
    CHECK(loss() < 0.7 * without);
}
