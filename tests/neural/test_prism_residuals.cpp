// SPDX-License-Identifier: Apache-2.0
// Residuals of prisms: targets against closed forms, predictions and their invariances.
#include "ndg/neural/prism_residuals.h"

#include "ndg/core/error.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

#include <functional>

using namespace ndg;
using namespace ndg::test;

namespace {

using RowMatrix3f = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;

Eigen::Matrix3d prism_matrix(const GradientsF& rows, Eigen::Index p)
{
    return Eigen::Map<const RowMatrix3f>(rows.row(p).data()).cast<double>();
}

/// Residuals of `vertices` of `body` in `pose`.
GradientsF target_of(const Template& tube, const NetworkOptions& options, const Body& body, const Pose& pose,
                     const Points& vertices)
{
    const BodyPoser poser(tube, test::bending);
    GradientsF target(tube.num_prisms(), 9);
    make_output_space(tube, options)
        ->target(poser.pose(body, pose), RestOperators(tube.prisms, body.volume_vertices), vertices.cast<float>(),
                 target.data());
    return target;
}

/// The F that minimises the integral of |x - mean x - F (X - mean X)|^2 over the reference prism, X and x the rest and
/// the deformed point at the same coordinates (NDG supplement, equation 5): normal equations by Gauss quadrature.
Eigen::Matrix3d best_affine_map(const PrismVertices& rest, const PrismVertices& deformed)
{
    Eigen::Matrix3d moments = Eigen::Matrix3d::Zero(), mixed = Eigen::Matrix3d::Zero();
    const double offset = 0.5 / std::sqrt(3.0);
    for (const double xi : {0.5 - offset, 0.5 + offset})
        for (int corner = 0; corner < 3; ++corner) {
            const double alpha = corner == 0 ? 2.0 / 3 : 1.0 / 6, beta = corner == 1 ? 2.0 / 3 : 1.0 / 6;
            const Eigen::RowVector3d x_rest = prism_point(rest, alpha, beta, xi) - rest.colwise().mean();
            const Eigen::RowVector3d x = prism_point(deformed, alpha, beta, xi) - deformed.colwise().mean();
            moments += x_rest.transpose() * x_rest;
            mixed += x.transpose() * x_rest;
        }
    return mixed * moments.inverse();
}

double smallest_determinant(const RowMatrixF& predictions)
{
    double smallest = 1e30;
    for (Eigen::Index i = 0; i < predictions.size(); i += 9)
        smallest = std::min<double>(smallest, Eigen::Map<const RowMatrix3f>(predictions.data() + i).determinant());
    return smallest;
}

}  // namespace

TEST_CASE("a target is the best affine map of each prism, seen from the prism's blended rotation")
{
    const Synthetic s = make_synthetic(8, 2);
    const Body& body = s.bodies.bodies[2];
    const Pose pose = arm_pose(0.9, 0.3, -0.4);
    Points vertices = bulged_tube(s.tube, body, pose);
    Random random(4, "dents");
    for (Eigen::Index k = 0; k < vertices.size(); ++k) vertices.data()[k] += 0.01 * random.normal();
    const GradientsF residuals = target_of(s.tube, small_network(), body, pose, vertices);
    const auto world_from_rest = forward_kinematics(s.tube.skeleton, body.joint_positions, pose);
    const SkinningWeights weights = s.tube.prism_weights();
    for (Eigen::Index p = 0; p < residuals.rows(); ++p) {
        Eigen::Vector4d blend = Eigen::Vector4d::Zero();  // of quaternions; the joints turn too little for other signs
        for (int k = 0; k < max_influences; ++k) {
            Eigen::Vector4d joint =
                Eigen::Quaterniond(Eigen::Matrix3d(world_from_rest[weights.joints(p, k)].linear())).coeffs();
            blend += weights.weights(p, k) * (joint.w() < 0 ? -joint : joint);
        }
        const Eigen::Matrix3d rotation = Eigen::Quaterniond(blend.normalized()).toRotationMatrix();
        const Eigen::Matrix3d gradient = best_affine_map(gather_prism(body.volume_vertices, s.tube.prisms, p),
                                                         gather_prism(vertices, s.tube.prisms, p));
        REQUIRE((prism_matrix(residuals, p) - rotation.transpose() * gradient).norm() < 2e-5);
    }
}

TEST_CASE("an affine deformation in the rest pose is its own residual")
{
    const Synthetic s = make_synthetic(8, 2);
    Eigen::Matrix3d map;
    map << 1.1, 0.2, -0.1, 0.05, 0.9, 0.3, -0.2, 0.1, 1.2;
    const Body& body = s.bodies.bodies[0];
    const GradientsF residuals =
        target_of(s.tube, small_network(), body, tube_pose(0), body.volume_vertices * map.transpose());
    for (Eigen::Index p = 0; p < residuals.rows(); ++p) REQUIRE((prism_matrix(residuals, p) - map).norm() < 1e-5);
}

TEST_CASE("a rigid motion with the root has the identity as residual")
{
    const Synthetic s = make_synthetic(8, 2);
    const Body& body = s.bodies.bodies[0];
    Pose pose = tube_pose(0);
    pose.parent_from_joint[0] = rotation_about({1, 2, -0.5}, 2.2);
    pose.root_translation << 0.3, -0.2, 5;
    const Points moved = linear_blend_skinning(body.volume_vertices, s.tube.volume_weights(),
                                               forward_kinematics(s.tube.skeleton, body.joint_positions, pose));
    for (const bool rotation : {true, false}) {
        NetworkOptions options = small_network();
        options.rotation = rotation;
        const GradientsF residuals = target_of(s.tube, options, body, pose, moved);
        for (Eigen::Index p = 0; p < residuals.rows(); ++p)
            REQUIRE((prism_matrix(residuals, p) - Eigen::Matrix3d::Identity()).norm() < 1e-4);
    }
}

TEST_CASE("an untrained model is gradient skinning, exactly")
{
    const Synthetic s = make_synthetic(8, 2);
    const BodyPoser poser(s.tube, test::bending);
    RestCache rest(s.tube);
    for (const std::string& parametrisation : names<ParametrisationKind>()) {
        CAPTURE(parametrisation);
        NetworkOptions options = small_network();
        options.parametrisation = parse_name<ParametrisationKind>(parametrisation);
        const NeuralModel model = s.model(options);
        const std::vector<float> neutral = neutral_prediction(model.output_space());
        REQUIRE(model.output_space().width() == 9 * s.tube.num_prisms());
        for (const int i : {1, 6, 7}) {
            const RowMatrixF prediction = model.predict({s.input(model, i, i)});
            for (Eigen::Index k = 0; k < prediction.cols(); ++k) {
                REQUIRE(neutral[k] == (k % 9 % 4 == 0 ? 1.0F : 0.0F));
                REQUIRE(prediction(0, k) == neutral[k]);
            }
            const PosedBody posed = poser.pose(s.bodies.bodies[i], s.poses.poses[i]);
            const GradientsF gradients = model.output_space().gradients(posed, prediction.data());
            for (Eigen::Index p = 0; p < gradients.rows(); ++p)
                REQUIRE((prism_matrix(gradients, p) - posed.prism_rotations()[p]).cwiseAbs().maxCoeff() < 1e-7);
            const Points skinned = rest.poisson(posed.body()).reconstruct(posed.prism_rotations(), posed.bone_wrap());
            CHECK((model.output_space().vertices(posed, rest, prediction.data()) - skinned).cwiseAbs().maxCoeff() <
                  1e-6);
        }
    }
}

TEST_CASE("vertices of a deformation's own residuals are the deformation")
{
    const Synthetic s = make_synthetic(8, 2);
    const BodyPoser poser(s.tube, test::bending);
    RestCache rest(s.tube);
    const PosedBody posed = poser.pose(s.bodies.bodies[3], arm_pose(0.7, -0.2, 0.5));
    const Points deformed = bulged_tube(s.tube, posed.body(), posed.pose());  // with the skinned bone wrap
    for (const bool rotation : {true, false}) {
        NetworkOptions options = small_network();
        options.rotation = rotation;
        const auto space = make_output_space(s.tube, options);
        std::vector<float> target(space->width());
        space->target(posed, rest.operators(posed.body()), deformed.cast<float>(), target.data());
        CHECK((space->vertices(posed, rest, target.data()) - deformed).cwiseAbs().maxCoeff() < 1e-6);
    }
}

TEST_CASE("predictions turn with the root")
{
    const Synthetic s = make_synthetic(24, 8);
    const BodyPoser poser(s.tube, test::bending);
    const Eigen::Matrix3d turn = rotation_about({1, -2, 0.7}, 2.5);
    for (const bool rotation : {true, false}) {
        NetworkOptions options = small_network();
        options.rotation = rotation;
        const NeuralModel model = moved_model(s, options);
        for (const int i : {1, 6, 7}) {
            PoseInput input = s.input(model, i, i);
            const auto gradients = [&] {
                return model.output_space().gradients(poser.pose(s.bodies.bodies[i], input.pose),
                                                      model.predict({input}).data());
            };
            const GradientsF before = gradients();
            input.pose.parent_from_joint[0] = turn * input.pose.parent_from_joint[0];
            const GradientsF after = gradients();
            for (Eigen::Index p = 0; p < before.rows(); ++p)
                REQUIRE((prism_matrix(after, p) - turn * prism_matrix(before, p)).cwiseAbs().maxCoeff() < 5e-6);
        }
    }
}

TEST_CASE("predicted determinants are positive whatever the weights")
{
    const Synthetic s = make_synthetic(24, 8);
    const BodyPoser poser(s.tube, test::bending);
    for (const char* parametrisation : {"exponential", "lu", "qr"}) {
        CAPTURE(parametrisation);
        NetworkOptions options = small_network();
        options.parametrisation = parse_name<ParametrisationKind>(parametrisation);
        const NeuralModel model = moved_model(s, options);
        std::vector<PoseInput> inputs;
        for (int i = 0; i < 20; ++i)  // far outside of the training poses and bodies
            inputs.push_back({8.0 * model.input_space().encode(s.bodies.bodies[i % 8]),
                              arm_pose(0.3 * i - 3, 0.5 * i, 1.0 - 0.2 * i)});
        const RowMatrixF residuals = model.predict(inputs);
        CHECK(smallest_determinant(residuals) > 0);
        CHECK(smallest_determinant(residuals) < 0.99);  // the network has moved at all
        for (int i = 0; i < 20; ++i)
            CHECK(smallest_determinant(model.output_space().gradients(poser.pose(s.bodies.bodies[0], inputs[i].pose),
                                                                      residuals.row(i).data())) > 0);
    }
}
