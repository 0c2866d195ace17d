// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/deform/fit_correctives.h"
#include "ndg/deform/gradient_skinning.h"
#include "ndg/geometry/rotation.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <Eigen/LU>

using namespace ndg;

namespace {

/// Two tubes in random poses of all joints that their flesh sees.
struct Scene {
    test::TemporaryFolder folder;
    Template tube = test::tube_template(5, 6);
    BodySet bodies;
    PoseSet poses;
    DeformationSet samples;
    BodyPoser poser{tube, test::bending};

    Scene()
    {
        Body large = tube.rest;
        for (Points* points : {&large.volume_vertices, &large.joint_positions}) *points *= 1.1;
        bodies.bodies = {tube.rest, large};
        samples.method = "FEM";
        samples.posing = test::bending;
        samples.num_volume_vertices = tube.num_volume_vertices();
    }

    void add_poses(int count, double spread)
    {
        Random random(7, "poses");
        for (int i = 0; i < count; ++i) {
            Pose pose = Pose::rest(tube.skeleton.num_joints());
            for (const int joint : corrective_joints(tube))
                pose.parent_from_joint[joint] =
                    rotation_of(spread * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
            pose.parent_from_joint[0] = about_y(0.1 * i);
            poses.poses.push_back(pose);
        }
    }
    PosedBody posed(const SamplePair& pair) const
    {
        return poser.pose(bodies.bodies[pair.body_idx], poses.poses[pair.pose_idx], pair);
    }
    CorrectivesFit fit(double ridge) const { return fit_correctives(tube, bodies, poses, samples, {ridge}); }
};

RowMatrix random_matrix(Eigen::Index rows, Eigen::Index cols, const std::string& stream)
{
    RowMatrix matrix(rows, cols);
    Random random(8, stream);
    for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = random.normal();
    return matrix;
}

}  // namespace

TEST_CASE("Normal equations summed in blocks solve the regression, and know its errors")
{
    const RowMatrix features = random_matrix(40, 6, "features"), outputs = random_matrix(40, 9, "outputs");
    const RowMatrix other_features = random_matrix(11, 6, "others"), other_outputs = random_matrix(11, 9, "more");
    NormalEquations equations(6, 9), others(6, 9);
    equations.add(features.topRows(17), outputs.topRows(17));
    equations.add(features.bottomRows(23), outputs.bottomRows(23));
    others.add(other_features, other_outputs);
    const double ridge = 0.3;
    // As least squares: a row sqrt(40 ridge) I of features with no outputs.
    Eigen::MatrixXd stacked(46, 6), targets = Eigen::MatrixXd::Zero(46, 9);
    stacked << features, std::sqrt(40 * ridge) * Eigen::MatrixXd::Identity(6, 6);
    targets.topRows(40) = outputs;
    const Eigen::MatrixXd expected = stacked.colPivHouseholderQr().solve(targets);
    CHECK((equations.solve(ridge) - expected).norm() < 1e-12 * expected.norm());
    const double on_others = (other_outputs - other_features * expected).norm() / std::sqrt(99.0);
    CHECK(others.errors(equations, {100.0, ridge})[1] == Approx(on_others));
    CHECK(equations.errors(equations, {ridge})[0] == Approx((outputs - features * expected).norm() / std::sqrt(360.0)));
    CHECK(others.error_without() == Approx(other_outputs.norm() / std::sqrt(99.0)));
    CHECK_THROWS_AS(NormalEquations(6, 9).solve(0), SolverError);
    CHECK_THROWS_AS(equations.add(features, other_outputs), Error);
}

TEST_CASE_METHOD(Scene, "Correctives that are linear in the pose are recovered, from the training split alone")
{
    LinearCorrectives truth;
    truth.joints = corrective_joints(tube);
    REQUIRE(truth.joints.size() >= 2);
    REQUIRE(std::find(truth.joints.begin(), truth.joints.end(), 0) == truth.joints.end());
    truth.posing = test::bending;
    const Eigen::Index num_features = 9 * Eigen::Index(truth.joints.size());
    truth.blend_shapes = (0.004 * random_matrix(num_features, 6 * tube.num_wrap_vertices(), "truth")).cast<float>();
    // Enough poses for all features, and some more.
    const int num_poses = int(num_features) + 30;
    add_poses(num_poses, 0.6);
    const RestOffsets at_rest(tube);
    for (int i = 0; i < num_poses; ++i) {
        const bool train = i < num_poses - 10;
        const SamplePair pair{i % 2, i};
        Points vertices = at_rest.vertices(posed(pair), truth.offsets(poses.poses[i]));
        const bool spoilt = i == 3;  // one that did not converge
        if (!train || spoilt) vertices.array() += 0.1;
        samples.add(pair, train ? "train" : "test", vertices);
        samples.statistics["converged"].push_back(!spoilt);
    }
    const CorrectivesFit fitted = fit(1e-9);
    CHECK(fitted.num_train == num_poses - 11);
    CHECK(fitted.num_unconverged == 1);
    CHECK(fitted.num_validation == 0);
    CHECK(fitted.train_without > 2e-3);
    CHECK(fitted.train_error < 1e-4 * fitted.train_without);
    for (int i = num_poses - 10; i < num_poses; ++i) {
        const Points expected = truth.offsets(poses.poses[i]);
        CHECK((fitted.correctives.offsets(poses.poses[i]) - expected).norm() < 0.01 * expected.norm());
    }
    CHECK_THROWS_WITH(fit(0), Catch::Contains("validation"));

    // As a method, from a file; the rest pose stays as it is.
    const std::string path = folder.file("correctives.h5");
    write_correctives(path, fitted.correctives, tube, Provenance{});
    MethodTable table;
    register_linear_correctives(table);
    CHECK_THROWS_WITH(table.find("linear-correctives").make(poser), Catch::Contains("--correctives"));
    const LinearCorrectives read = read_correctives(path, tube);
    CHECK(read.blend_shapes == fitted.correctives.blend_shapes);
    CHECK(read.posing.bone_wrap == BoneWrap::lbs);
    CHECK(read.ridge == 1e-9);
    CHECK(read.offsets(Pose::rest(tube.skeleton.num_joints())).norm() == 0);
    CHECK_THROWS_AS(read_correctives(path, test::tube_template(6, 6)), InputError);
    Template other = tube;
    other.file_sha256 = "1";
    LinearCorrectives foreign = read;
    foreign.template_sha256 = "2";
    write_correctives(folder.file("foreign.h5"), foreign, tube, Provenance{});
    CHECK_THROWS_WITH(read_correctives(folder.file("foreign.h5"), other), Catch::Contains("hash"));
}

TEST_CASE_METHOD(Scene,
                 "Correctives fitted to a deformation that is not linear in the pose beat skinning on unseen poses")
{
    const PoissonReconstruction small(RestOperators(tube.prisms, tube.rest.volume_vertices), tube.num_wrap_vertices());
    const PoissonReconstruction large(RestOperators(tube.prisms, bodies.bodies[1].volume_vertices),
                                      tube.num_wrap_vertices());
    std::vector<SamplePair> unseen;
    for (int i = 0; i < 40; ++i) {
        poses.poses.push_back(test::tube_pose(-1 + 0.05 * i));
        const SamplePair pair{i / 2 % 2, i};
        const std::string split = i % 4 == 1 ? "validation" : i % 4 == 3 ? "test" : "train";
        samples.add(pair, split, gradient_skinning(posed(pair), pair.body_idx == 0 ? small : large));
        if (split == "test") unseen.push_back(pair);
    }
    const CorrectivesFit fitted = fit(0);
    CHECK(fitted.validation_error < 0.2 * fitted.validation_without);
    // No other power of ten is better.
    for (const double ridge : {1e-8, 1e-6, 1e-4, 1e-2, 1.0})
        CHECK(fit(ridge).validation_error >= fitted.validation_error);
    const RestOffsets at_rest(tube);
    for (const SamplePair& pair : unseen) {
        const PosedBody body = posed(pair);
        const Points truth = gradient_skinning(body, pair.body_idx == 0 ? small : large);
        const Points corrected = at_rest.vertices(body, fitted.correctives.offsets(body.pose()));
        CHECK((corrected - truth).norm() < 0.3 * (body.skinned_volume() - truth).norm() + 1e-4);
    }
    samples.pairs[0].pose_idx = 40;
    CHECK_THROWS_AS(fit(0), InputError);
}
