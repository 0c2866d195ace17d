// SPDX-License-Identifier: Apache-2.0
// Targets and inputs of the network against closed forms.
#include "ndg/neural/training_set.h"

#include "ndg/core/error.h"
#include "ndg/deform/residuals.h"
#include "ndg/neural/input_space.h"
#include "ndg/neural/matrix_exponential.h"
#include "ndg/neural/output_basis.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <functional>

using namespace ndg;
using namespace ndg::test;

namespace {

/// A synthetic set whose only training sample is `vertices` of body 0 in `pose`.
Synthetic single_sample(const Pose& pose, const std::function<Points(const Synthetic&)>& deform)
{
    Synthetic s = make_synthetic(8, 2);
    s.poses.poses = {pose};
    DeformationSet set;
    set.method = "FEM";
    set.num_volume_vertices = s.tube.num_volume_vertices();
    set.add({0, 0}, "train", deform(s));
    set.statistics["converged"] = {1.0};
    s.samples = {set};
    return s;
}

GradientsF residuals_of(const TrainingSet& set, int sample_idx)
{
    GradientsF residuals(set.num_prisms(), 9);
    set.residuals(sample_idx, residuals.data());
    return residuals;
}

using RowMatrix3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

}  // namespace

TEST_CASE("an affine deformation in the rest pose is its own residual")
{
    Eigen::Matrix3d map;
    map << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, -0.2, 0.1, 1.2;
    const Synthetic s = single_sample(tube_pose(0), [&](const Synthetic& all) -> Points {
        return all.bodies.bodies[0].volume_vertices * map.transpose();
    });
    const GradientsF residuals = residuals_of(s.set("train", small_network()), 0);
    for (Eigen::Index p = 0; p < residuals.rows(); ++p)
        REQUIRE((Eigen::Map<const RowMatrix3f>(residuals.row(p).data()).cast<double>() - map).norm() < 1e-5);
}

TEST_CASE("a rigid motion with the root has the identity as residual")
{
    Pose pose = tube_pose(0);
    const Eigen::Matrix3d turn = rotation_about({1, 2, -0.5}, 2.2);
    pose.parent_from_joint[0] = turn;
    pose.root_translation << 0.3, -0.2, 5;
    const auto move = [&](const Synthetic& all) {
        const Body& body = all.bodies.bodies[0];
        return linear_blend_skinning(body.volume_vertices, all.tube.volume_weights(),
                                     forward_kinematics(all.tube.skeleton, body.joint_positions, pose));
    };
    const Synthetic s = single_sample(pose, move);
    for (const bool rotation : {true, false}) {
        NetworkOptions options = small_network();
        options.rotation = rotation;
        const GradientsF residuals = residuals_of(s.set("train", options), 0);
        for (Eigen::Index p = 0; p < residuals.rows(); ++p)
            REQUIRE((Eigen::Map<const RowMatrix3f>(residuals.row(p).data()) - RowMatrix3f::Identity()).norm() < 1e-4);
    }
}

TEST_CASE("targets kept in memory and computed anew are the same")
{
    const Synthetic s = make_synthetic(8, 2);
    const TrainingSet kept = s.set("train", small_network(), 1.0), computed = s.set("train", small_network(), 0.0);
    for (int i = 0; i < kept.size(); ++i) CHECK(residuals_of(kept, i) == residuals_of(computed, i));
    CHECK(kept.digest() == computed.digest());
}

TEST_CASE("only converged simulations of the split are used")
{
    Synthetic s = make_synthetic(8, 2);
    s.samples[0].statistics["converged"][3] = 0.0;
    const TrainingSet training = s.set("train", small_network()), validation = s.set("validation", small_network());
    CHECK(training.size() == 7);
    CHECK(training.num_unconverged() == 1);
    CHECK(training.pair(3).pose_idx == 4);
    CHECK(validation.size() == 2);
    CHECK(training.digest() != make_synthetic(8, 2).set("train", small_network()).digest());
}

TEST_CASE("samples that do not fit are refused")
{
    const Synthetic good = make_synthetic(4, 2);
    Synthetic s = good;
    CHECK_THROWS_AS(s.set("test", small_network()), InputError);
    s.samples.push_back(s.samples[0]);
    CHECK_THROWS_WITH(s.set("train", small_network()), Catch::Contains("twice"));
    s = good;
    s.samples[0].pairs[1].body_idx = 8;
    CHECK_THROWS_WITH(s.set("train", small_network()), Catch::Contains("body 8 of 8"));
    s = good;
    s.samples[0].pairs[1].pose_idx = 6;
    CHECK_THROWS_WITH(s.set("train", small_network()), Catch::Contains("pose 6 of 6"));
    s = good;
    s.samples[0].num_volume_vertices -= 1;
    CHECK_THROWS_AS(s.set("train", small_network()), InputError);
}

TEST_CASE("inputs see the joints that move the volume, and the body")
{
    const Synthetic s = make_synthetic(4, 2);
    const std::vector<int> visible = visible_joints(s.tube);
    const auto index = [](const char* name) { return static_cast<std::size_t>(standard_skeleton().joint(name)); };
    CHECK(visible[index("left_upper_arm")] == 1);
    CHECK(visible[index("left_forearm")] == 1);
    CHECK(visible[index("left_clavicle")] == 1);  // turns the arm
    CHECK(visible[index("left_hand")] == 0);
    CHECK(visible[index("right_thigh")] == 0);
    CHECK(visible[0] == 0);

    Pose pose = arm_pose(0.4, 0.1, 0.2);
    const Eigen::VectorXd code = s.shape_space.encode(s.bodies.bodies[1].volume_vertices);
    const Eigen::RowVectorXf features = network_features({code, pose}, visible, s.shape_space, true);
    REQUIRE(features.size() == 540 + 2);
    const auto forearm = static_cast<Eigen::Index>(9 * index("left_forearm"));
    const Eigen::Matrix3d& elbow = pose.parent_from_joint[index("left_forearm")];
    CHECK(features[forearm] == Approx(elbow(0, 0) - 1.0));
    CHECK(features[forearm + 1] == Approx(elbow(0, 1)));
    CHECK(features[forearm + 3] == Approx(elbow(1, 0)));
    CHECK(features[541] == Approx(code[1] / s.shape_space.standard_deviations[1]));
    pose.parent_from_joint[0] = rotation_about({1, 1, 1}, 1.0);
    pose.parent_from_joint[index("left_hand")] = rotation_about({1, 0, 0}, 1.0);
    CHECK(network_features({code, pose}, visible, s.shape_space, true) == features);
    CHECK(network_features({code, pose}, visible, s.shape_space, false).size() == 540);
    pose.parent_from_joint.pop_back();
    CHECK_THROWS_AS(network_features({code, pose}, visible, s.shape_space, true), InputError);
    CHECK_THROWS_AS(network_features({code.head(1), tube_pose(0)}, visible, s.shape_space, true), InputError);
}

TEST_CASE("residual logarithms invert the exponential for rotations and for stretches")
{
    const RowMatrix3f rotation = rotation_about({1, 2, 3}, 0.9).cast<float>();
    RowMatrix3f stretch;
    stretch << 1.3F, 0.1F, 0.2F, 0.1F, 0.8F, -0.1F, 0.2F, -0.1F, 1.1F;
    for (const RowMatrix3f& residual : {rotation, stretch}) {
        RowMatrix3f logarithm, back;
        residual_logarithm(residual.data(), true, logarithm.data());
        matrix_exponential(logarithm.data(), 1, back.data());
        CHECK((back - residual).norm() < 1e-5F);
    }
    RowMatrix3f inverted = stretch, logarithm;
    inverted.col(0) *= -1;
    residual_logarithm(inverted.data(), true, logarithm.data());
    CHECK(logarithm.allFinite());
    residual_logarithm(stretch.data(), false, logarithm.data());
    CHECK((logarithm + RowMatrix3f::Identity() - stretch).norm() < 1e-6F);
}

TEST_CASE("the output basis spans the training residuals")
{
    const Synthetic s = make_synthetic(12, 2);
    const TrainingSet set = s.set("train", small_network());
    const RowMatrixF basis = fit_output_basis(set, 100, false, 1);
    REQUIRE(basis.rows() <= 12);
    const Eigen::MatrixXd gram = (basis * basis.transpose()).cast<double>();
    CHECK((gram - Eigen::MatrixXd(gram.diagonal().asDiagonal())).norm() < 1e-3 * gram.norm());
    const GradientsF residuals = residuals_of(set, 5);
    Eigen::RowVectorXd target = Eigen::Map<const Eigen::RowVectorXf>(residuals.data(), residuals.size()).cast<double>();
    for (Eigen::Index k = 0; k < target.size(); ++k) target[k] -= k % 9 % 4 == 0 ? 1.0 : 0.0;
    const Eigen::RowVectorXd coefficients =
        (target * basis.transpose().cast<double>()).cwiseQuotient(gram.diagonal().transpose());
    CHECK((coefficients * basis.cast<double>() - target).norm() < 1e-3 * target.norm());
    CHECK(fit_output_basis(set, 3, true, 1).rows() == 3);
}
