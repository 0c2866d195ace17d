// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/random.h"
#include "ndg/registration/articulated_model.h"
#include "ndg/registration/rest_pose.h"
#include "scan/template_skin.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("inverse skinning undoes skinning, and joints follow a scaled skin")
{
    const SkinnedSurface& skin = test::template_skin();
    const ArticulatedModel model(skin);
    Eigen::VectorXd parameters = Eigen::VectorXd::Zero(model.num_parameters());
    CHECK((model.posed_vertices(parameters) - skin.vertices).cwiseAbs().maxCoeff() < 1e-12);
    Random random(9, "parameters");
    for (Eigen::Index p = 0; p < parameters.size(); ++p) parameters[p] = 0.08 * random.normal();
    const auto world_from_rest =
        forward_kinematics(standard_skeleton(), model.rest_joints(parameters), model.pose(parameters));
    const Points posed = model.posed_vertices(parameters);
    const Points rest = unpose(posed, skin.weights, world_from_rest);
    CHECK((rest - model.rest_vertices(parameters)).cwiseAbs().maxCoeff() < 1e-9);

    const JointRegressor regressor(skin.vertices, skin.weights, skin.joint_positions);
    CHECK((regressor.joints(skin.vertices) - skin.joint_positions).rowwise().norm().maxCoeff() < 1e-3);
    const Points moved = (1.1 * skin.vertices).rowwise() + Eigen::RowVector3d(0.3, -0.2, 0.1);
    const Points expected = (1.1 * skin.joint_positions).rowwise() + Eigen::RowVector3d(0.3, -0.2, 0.1);
    CHECK((regressor.joints(moved) - expected).rowwise().norm().maxCoeff() < 2e-3);
}

TEST_CASE("the model's derivative for a joint is rotation about that joint")
{
    const SkinnedSurface& skin = test::template_skin();
    const ArticulatedModel model(skin);
    const Eigen::VectorXd rest = Eigen::VectorXd::Zero(model.num_parameters());
    const std::vector<int> rows = {0, 50, 200, 500};
    const Eigen::MatrixXd jacobian = model.jacobian(rest, rows);
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const Eigen::Vector3d arm = (skin.vertices.row(rows[i]) - skin.joint_positions.row(0)).transpose();
        for (int axis = 0; axis < 3; ++axis) {
            const Eigen::Vector3d expected = Eigen::Vector3d::Unit(axis).cross(arm);
            CHECK((jacobian.block<3, 1>(3 * Eigen::Index(i), axis) - expected).norm() < 1e-6);
        }
        CHECK((jacobian.block<3, 1>(3 * Eigen::Index(i), 6) - arm).norm() < 1e-6);
    }
}
