// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/pose_directions.h"
#include "ndg/avatar/soft_region.h"
#include "ndg/core/error.h"
#include "support/h5_damage.h"
#include "tube_body.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("A statistical body reproduces the skins and joints of its bodies by their shapes")
{
    const test::TubeBody scene;
    REQUIRE(scene.body.num_shapes() == 3);
    // Bodies are scaled along three axes, so three directions and affine weights say all of them.
    CHECK(scene.errors.largest_skin < 1e-6);
    CHECK(scene.errors.largest_joint < 1e-3);
    CHECK(scene.errors.largest_held_out < 3e-3);
    CHECK(scene.errors.largest_held_out > 0);
    for (std::size_t b = 0; b < scene.bodies.bodies.size(); ++b) {
        const int person = scene.body.person(scene.bodies.bodies[b].name);
        REQUIRE(person == int(b));
        const Points rest = scene.body.rest_vertices(scene.body.people_shapes.row(person).transpose());
        CHECK((rest - scene.bodies.bodies[b].skin_vertices).cwiseAbs().maxCoeff() < 1e-6);
    }
    CHECK_THROWS_WITH(scene.body.person("nobody"), Catch::Contains("nobody") && Catch::Contains("tube_0"));
    const Eigen::VectorXd too_long = Eigen::VectorXd::Zero(4);
    CHECK_THROWS_WITH(scene.body.rest_vertices(too_long), Catch::Contains("4 shape parameters"));
}

TEST_CASE("The joint regressor is affine and local")
{
    const test::TubeBody scene;
    const RowMatrix regressor = scene.body.joint_regressor;
    CHECK((regressor.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-10);
    Points moved = scene.tube.rest.skin_vertices;
    const Eigen::RowVector3d way(0.3, -1.0, 2.0);
    moved.rowwise() += way;
    const Points expected = scene.body.joint_positions(scene.tube.rest.skin_vertices).rowwise() + way;
    CHECK((scene.body.joint_positions(moved) - expected).cwiseAbs().maxCoeff() < 1e-9);
    // The elbow, on the tube's axis half-way up, sees nothing of the ends.
    const int elbow = scene.tube.skeleton.joint("left_forearm");
    for (Eigen::Index v = 0; v < regressor.cols(); ++v)
        if (std::abs(scene.tube.rest.skin_vertices(v, 1) - 0.5) > 0.25) CHECK(regressor(elbow, v) == 0);
    // One body alone is reproduced too.
    const JointWeights of_one = fit_joint_regressor(scene.tube.rest, {&scene.tube.rest}, 1e-9);
    CHECK((of_one * scene.tube.rest.skin_vertices - scene.tube.rest.joint_positions).rowwise().norm().maxCoeff() <
          0.02);
    CHECK((of_one * scene.tube.rest.skin_vertices - scene.tube.rest.joint_positions).row(elbow).norm() < 1e-5);
    CHECK_THROWS_AS(fit_joint_regressor(scene.tube.rest, {}, 1e-9), InputError);
}

TEST_CASE("Pose directions are those of the correctives, and fade to nothing at the cuts without a step")
{
    const test::TubeBody scene;
    const int num_wrap = scene.tube.num_wrap_vertices();
    const Points& skin = scene.tube.rest.skin_vertices;
    REQUIRE(scene.body.pose_joints == scene.correctives.joints);
    for (int w = 0; w < num_wrap; ++w) {
        const double from_end = std::min(skin(w, 1), 1.0 - skin(w, 1));
        const RowMatrixF expected = scene.correctives.blend_shapes.middleCols<3>(3 * (num_wrap + w));
        const RowMatrixF directions = scene.body.pose_directions.middleCols<3>(3 * w);
        if (from_end < 1e-9) CHECK(directions.cwiseAbs().maxCoeff() == 0);
        if (from_end > 0.06) CHECK((directions - expected).cwiseAbs().maxCoeff() == 0);
    }
    // Beyond: the caps.
    CHECK(scene.body.pose_directions.rightCols<6>().cwiseAbs().maxCoeff() == 0);
}

TEST_CASE("Skinning is linear blend skinning of template, shape and pose directions")
{
    const test::TubeBody scene;
    const Eigen::Vector3d shape(0.5, -1.0, 2.0);
    const Pose pose = test::random_pose(60, 0.4, 1);
    const PosedSkin posed = skin_body(scene.body, shape, pose);
    // By the formula, entry by entry.
    Points rest = scene.body.rest_vertices(shape);
    const Points joints = scene.body.joint_positions(rest);
    for (std::size_t p = 0; p < scene.body.pose_joints.size(); ++p)
        for (int r = 0; r < 3; ++r)
            for (int c = 0; c < 3; ++c) {
                const double feature = pose.parent_from_joint[scene.body.pose_joints[p]](r, c) - (r == c);
                for (Eigen::Index i = 0; i < rest.size(); ++i)
                    rest.data()[i] += feature * double(scene.body.pose_directions(9 * Eigen::Index(p) + 3 * r + c, i));
            }
    const auto motions = forward_kinematics(scene.body.skeleton, joints, pose);
    const Points expected = linear_blend_skinning(rest, scene.tube.skin_weights, motions);
    CHECK((posed.vertices - expected).cwiseAbs().maxCoeff() < 1e-12);
    const Points from_correctives = rest - scene.body.rest_vertices(shape);
    CHECK(from_correctives.cwiseAbs().maxCoeff() > 1e-3);
    const int elbow = scene.tube.skeleton.joint("left_forearm");
    CHECK((posed.joints.row(elbow).transpose() - motions[elbow] * Eigen::Vector3d(joints.row(elbow))).norm() < 1e-12);

    const PosedSkin at_rest = skin_body(scene.body, shape, Pose::rest(60));
    CHECK((at_rest.vertices - scene.body.rest_vertices(shape)).cwiseAbs().maxCoeff() < 1e-14);
    CHECK_THROWS_AS(skin_body(scene.body, shape, Pose::rest(24)), Error);
}

TEST_CASE("A statistical body goes through its file")
{
    const test::TubeBody scene(9, 6);
    const test::TemporaryFolder folder;
    const std::string path = folder.file("body.h5");
    write_statistical_body(path, scene.body, test::example_provenance());
    const StatisticalBody read = read_statistical_body(path);
    CHECK(read.name == scene.body.name);
    CHECK(read.vertices == scene.body.vertices);
    CHECK(read.triangles == scene.body.triangles);
    CHECK(read.shape_directions == scene.body.shape_directions);
    CHECK(read.pose_joints == scene.body.pose_joints);
    CHECK(read.pose_directions == scene.body.pose_directions);
    CHECK(RowMatrix(read.joint_regressor) == RowMatrix(scene.body.joint_regressor));
    CHECK(RowMatrix(read.weights) == RowMatrix(scene.body.weights));
    CHECK(read.skeleton.joint_names == scene.body.skeleton.joint_names);
    CHECK(read.skeleton.parents == scene.body.skeleton.parents);
    CHECK(read.soft_triangles == scene.body.soft_triangles);
    CHECK(read.people == scene.body.people);
    CHECK(read.people_shapes == scene.body.people_shapes);
    test::check_by_h5py(path, "ndg-statistical-body",
                        R"({"/joints/regressor": (60, 56), "/people/names": (12,), "/people/shapes": (12, 3),
            "/pose/directions": (72, 168), "/pose/joint_names": (8,), "/shape/directions": (3, 168),
            "/skeleton/joint_names": (60,), "/skeleton/parents": (60,), "/skin/soft_triangles": (108,),
            "/skin/triangles": (108, 3), "/skin/vertices": (56, 3), "/skin/weights": (56, 60)})");

    SECTION("a bare one: no directions, no people, nothing of soft tissue")
    {
        StatisticalBody bare = scene.body;
        bare.shape_directions.resize(0, 0);
        bare.pose_joints.clear();
        bare.pose_directions.resize(0, 0);
        bare.soft_triangles.clear();
        bare.people.clear();
        const std::string other = folder.file("bare.h5");
        write_statistical_body(other, bare, test::example_provenance());
        const StatisticalBody again = read_statistical_body(other);
        CHECK(again.num_shapes() == 0);
        CHECK(again.pose_joints.empty());
        CHECK(again.soft_triangles.empty());
        const PosedSkin posed = skin_body(again, Eigen::VectorXd(), test::tube_pose(0.5));
        CHECK(posed.vertices.allFinite());
    }
    SECTION("what does not fit together is refused with one sentence")
    {
        test::check_damages(
            path,
            {{"f['/skin/vertices'][3, 1] = np.nan", {"/skin/vertices", "not finite"}},
             {"put('/skin/weights', f['/skin/weights'][:, :59])", {"/skin/weights", "56 x 60"}},
             {"f['/skin/weights'][4, 0] += 0.1", {"/skin/weights[4]", "instead of 1"}},
             {"w = f['/skin/weights'][...]; w[2, 0] -= 1.5; w[2, 1] += 1.5; put('/skin/weights', w)",
              {"/skin/weights[2, 0]", "not a weight"}},
             {"f['/skeleton/parents'][3] = 7", {"/skeleton/parents[3] is 7", "before their children"}},
             {"f['/skeleton/parents'][0] = 0", {"/skeleton/parents[0] is 0", "root"}},
             {"f['/skin/triangles'][2, 0] = 99", {"/skin/triangles", "99"}},
             {"f['/skin/triangles'][2, 0] = f['/skin/triangles'][2, 1]", {"/skin/triangles[2]", "twice"}},
             {"f['/joints/regressor'][5, 0] += 1", {"/joints/regressor[5]", "instead of 1"}},
             {"n = f['/pose/joint_names'][...]; n[0] = 'tail'; put('/pose/joint_names', n)",
              {"/pose/joint_names", "tail"}},
             {"put('/pose/directions', f['/pose/directions'][:-1])", {"/pose/directions", "expected"}},
             {"put('/people/shapes', f['/people/shapes'][:, :2])", {"/people/shapes"}},
             {"put('/shape/directions', f['/shape/directions'][:, :-3])", {"/shape/directions"}}},
            [](const std::string& damaged) { read_statistical_body(damaged); });
    }
}

TEST_CASE("A statistical body is not fitted to what does not suffice")
{
    const Template tube = test::tube_template(9, 6);
    const BodySet bodies = test::tube_bodies(tube, 12);
    const ShapeSpace space = test::tube_space(bodies);
    BodyErrors errors;
    CHECK_THROWS_WITH(fit_statistical_body(tube, bodies, {}, space, nullptr, {}, errors), Catch::Contains("no body"));
    CHECK_THROWS_WITH(fit_statistical_body(tube, bodies, {0, 1, 2}, space, nullptr, {}, errors),
                      Catch::Contains("3 bodies do not determine 3 shape directions"));
    CHECK_THROWS_WITH(
        fit_statistical_body(test::tube_template(10, 6), bodies, test::all_of(bodies), space, nullptr, {}, errors),
        Catch::Contains("shape space"));
    StatisticalBodyOptions few;
    few.shape_directions = 1;
    const StatisticalBody body = fit_statistical_body(tube, bodies, test::all_of(bodies), space, nullptr, few, errors);
    CHECK(body.num_shapes() == 1);
    CHECK(body.pose_directions.size() == 0);
    CHECK(errors.largest_skin > 1e-3);
}
