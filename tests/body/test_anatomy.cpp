// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/anatomy.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

/// The tube with every third anatomy vertex skinned to the forearm instead of embedded.
Template partly_skinned_tube()
{
    Template tube = test::tube_template(7, 8);
    const int forearm = tube.skeleton.joint("left_forearm");
    for (std::size_t i = 0; i < tube.embedding.elements.size(); i += 3) {
        const auto row = static_cast<Eigen::Index>(i);
        tube.embedding.elements[i] = -1;
        tube.embedding.weights.row(row).setZero();
        tube.embedding.vertices.row(row).setZero();
        tube.anatomy_weights.weights.row(row).setZero();
        tube.anatomy_weights.joints.row(row).setZero();
        tube.anatomy_weights.joints(row, 0) = forearm;
        tube.anatomy_weights.weights(row, 0) = 1.0;
    }
    return tube;
}

}  // namespace

TEST_CASE("Anatomy of a body that is a similar copy of the template is the similar copy", "[anatomy]")
{
    const Template tube = partly_skinned_tube();
    CHECK((anatomy_at_rest(tube, tube.rest) - tube.anatomy_vertices).cwiseAbs().maxCoeff() < 1e-9);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    const auto moved = [&](const Points& points) -> Points {
        return (1.15 * points * turn.transpose()).rowwise() + Eigen::RowVector3d(0.1, -0.2, 0.3);
    };
    Body body = tube.rest;
    body.skin_vertices = moved(body.skin_vertices);
    body.volume_vertices = moved(body.volume_vertices);
    body.interior_vertices = moved(body.interior_vertices);
    CHECK((anatomy_at_rest(tube, body) - moved(tube.anatomy_vertices)).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("Anatomy beyond the cuts follows its joint, the rest the volume", "[anatomy]")
{
    const Template tube = partly_skinned_tube();
    const auto world_from_rest = forward_kinematics(tube.skeleton, tube.rest.joint_positions, test::tube_pose(0.8));
    const Points volume = linear_blend_skinning(tube.rest.volume_vertices, tube.volume_weights(), world_from_rest);
    const Points interior = linear_blend_skinning(tube.rest.interior_vertices, tube.interior_weights, world_from_rest);
    const Points embedded = apply_embedding(tube.embedding, volume, interior);
    const Points posed = deformed_anatomy(tube, tube.anatomy_vertices, volume, interior, world_from_rest);
    const auto forearm = static_cast<std::size_t>(tube.skeleton.joint("left_forearm"));
    for (Eigen::Index i = 0; i < posed.rows(); ++i) {
        const Eigen::Vector3d expected =
            i % 3 == 0 ? Eigen::Vector3d(world_from_rest[forearm] * tube.anatomy_vertices.row(i).transpose())
                       : Eigen::Vector3d(embedded.row(i).transpose());
        CHECK((posed.row(i).transpose() - expected).norm() < 1e-12);
    }
}

TEST_CASE("Embedded vertices inherit the weights of the vertices they combine", "[anatomy]")
{
    const Template tube = test::tube_template(7, 8);
    const SkinningWeights weights =
        embedded_weights(tube.embedding, tube.volume_weights(), tube.interior_weights, tube.skeleton.num_joints());
    // The tube's weights are one function of the height; linear elements follow it closely.
    const int forearm = tube.skeleton.joint("left_forearm");
    const double low = tube.anatomy_vertices.col(1).minCoeff(), high = tube.anatomy_vertices.col(1).maxCoeff();
    for (Eigen::Index i = 0; i < weights.size(); ++i) {
        CHECK(weights.weights.row(i).sum() == Approx(1.0));
        double share = 0.0;
        for (int k = 0; k < max_influences; ++k)
            if (weights.joints(i, k) == forearm) share += weights.weights(i, k);
        if (tube.anatomy_vertices(i, 1) == low) CHECK(share < 0.05);
        if (tube.anatomy_vertices(i, 1) == high) CHECK(share > 0.95);
    }
}
