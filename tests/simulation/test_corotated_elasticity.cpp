// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/corotated_elasticity.h"

#include "ndg/elastic/layered_body.h"
#include "ndg/geometry/prism.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <Eigen/Cholesky>

using namespace ndg;

namespace {

double largest_distance(const Points& a, const Points& b)
{
    return (a - b).rowwise().norm().maxCoeff();
}

/// Equations 22 and 23 as dense least squares: a row an entry of every corner's strain, and one its trace.
Points by_least_squares(const Template& tube, const Body& body, const PosedBody& posed)
{
    const std::vector<Lame> materials = prism_materials(tube, MaterialOptions());
    const std::vector<Eigen::Matrix3d> rotations = blend_rotations(tube.volume_weights(), posed.world_from_rest());
    const int fixed = tube.num_wrap_vertices(), num_unknowns = 6 * fixed;
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(num_unknowns, num_unknowns);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(num_unknowns);
    for (int p = 0; p < tube.num_prisms(); ++p) {
        const PrismVertices rest = gather_prism(body.volume_vertices, tube.prisms, p);
        const PrismGradient g = prism_gradient_operator(rest);
        for (int corner = 0; corner < 6; ++corner) {
            const Eigen::Matrix3d& r = rotations[tube.prisms(p, corner)];
            Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(10, num_unknowns);
            Eigen::VectorXd targets(10);
            for (int entry = 0; entry < 9; ++entry) {
                const int i = entry / 3, j = entry % 3;
                double constant = i == j ? -1.0 : 0.0;
                // (R^T F)_ij = sum_a (R^T x_a)_i g_ja.
                for (int a = 0; a < 6; ++a) {
                    const int v = tube.prisms(p, a);
                    for (int c = 0; c < 3; ++c) {
                        const double factor = 0.5 * (r(c, i) * g(j, a) + r(c, j) * g(i, a));
                        if (v < fixed) {
                            constant += factor * posed.bone_wrap()(v, c);
                        } else {
                            rows(entry, 3 * (v - fixed) + c) += factor;
                        }
                    }
                }
                targets[entry] = -constant;
            }
            rows.row(9) = rows.row(0) + rows.row(4) + rows.row(8);
            targets[9] = targets[0] + targets[4] + targets[8];
            Eigen::VectorXd weights = Eigen::VectorXd::Constant(10, materials[p].mu);
            weights[9] = materials[p].lambda / 2;
            weights *= prism_volume(rest) / 6;
            normal += rows.transpose() * weights.asDiagonal() * rows;
            right += rows.transpose() * weights.cwiseProduct(targets);
        }
    }
    const Eigen::VectorXd solution = normal.ldlt().solve(right);
    Points vertices(tube.num_volume_vertices(), 3);
    vertices.topRows(fixed) = posed.bone_wrap();
    vertices.bottomRows(2 * fixed) = Eigen::Map<const Points>(solution.data(), 2 * fixed, 3);
    return vertices;
}

}  // namespace

TEST_CASE("Co-rotated elasticity minimises equation 22 with the bone wrap given, whichever body comes next")
{
    const Template tube = test::tube_template(4, 5);
    const BodyPoser poser(tube, test::bending);
    Body large = tube.rest;
    for (Points* points : {&large.volume_vertices, &large.joint_positions}) *points *= 1.3;
    CorotatedElasticity corotated(tube);
    for (const Body* body : {&tube.rest, static_cast<const Body*>(&large), &tube.rest}) {
        const PosedBody posed = poser.pose(*body, test::tube_pose(1.2));
        const Points vertices = corotated.deform(posed);
        CHECK(largest_distance(vertices, by_least_squares(tube, *body, posed)) < 1e-8);
        CHECK(largest_distance(vertices, posed.skinned_volume()) > 1e-3);
    }
}

TEST_CASE("Co-rotated elasticity leaves the rest pose as it is and moves rigidly with the root")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube, test::bending);
    MethodTable table;
    register_corotated_elasticity(table);
    const auto corotated = table.find("corotated").make(poser);
    Pose pose = Pose::rest(tube.skeleton.num_joints());
    CHECK(largest_distance(corotated->deform(poser.pose(tube.rest, pose)), tube.rest.volume_vertices) < 1e-9);
    pose.parent_from_joint[0] = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -1, 2).normalized()).toRotationMatrix();
    pose.root_translation << 0.2, 0.7, -0.4;
    const PosedBody posed = poser.pose(tube.rest, pose);
    Points expected = tube.rest.volume_vertices;
    for (Eigen::Index i = 0; i < expected.rows(); ++i)
        expected.row(i) = (posed.world_from_rest()[0] * Eigen::Vector3d(expected.row(i).transpose())).transpose();
    CHECK(largest_distance(corotated->deform(posed), expected) < 1e-9);
}
