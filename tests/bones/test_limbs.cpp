// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/knee.h"
#include "ndg/bones/limbs.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/rotation.h"
#include "ndg/geometry/triangle_mesh.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

constexpr double degree = M_PI / 180;

/// Closed, outward: `rings` x `segments` quads of an ellipsoid and its two poles.
TriangleMesh ellipsoid(const Eigen::RowVector3d& centre, const Eigen::RowVector3d& half, int rings = 24,
                       int segments = 32)
{
    TriangleMesh mesh;
    mesh.vertices.resize(rings * segments + 2, 3);
    std::vector<Eigen::RowVector3i> triangles;
    const int south = rings * segments, north = south + 1;
    mesh.vertices.row(south) = centre - Eigen::RowVector3d(0, half.y(), 0);
    mesh.vertices.row(north) = centre + Eigen::RowVector3d(0, half.y(), 0);
    for (int r = 0; r < rings; ++r)
        for (int s = 0; s < segments; ++s) {
            const double latitude = M_PI * ((r + 1.0) / (rings + 1) - 0.5), turn = 2 * M_PI * s / segments;
            mesh.vertices.row(r * segments + s) =
                centre + half.cwiseProduct(Eigen::RowVector3d(std::cos(latitude) * std::sin(turn), std::sin(latitude),
                                                              std::cos(latitude) * std::cos(turn)));
            const int next = (s + 1) % segments, a = r * segments + s, b = r * segments + next;
            if (r == 0) triangles.emplace_back(south, b, a);
            if (r + 1 == rings) {
                triangles.emplace_back(a, b, north);
            } else {
                triangles.emplace_back(a, b, b + segments);
                triangles.emplace_back(a, b + segments, a + segments);
            }
        }
    mesh.triangles.resize(Eigen::Index(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(Eigen::Index(t)) = triangles[t];
    return mesh;
}

Eigen::Isometry3d about(const Eigen::Vector3d& point, const Eigen::Matrix3d& rotation)
{
    return Eigen::Translation3d(point) * Eigen::Isometry3d(rotation) * Eigen::Translation3d(-point);
}

double largest(const Eigen::Isometry3d& a)
{
    return (a.matrix() - Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("The scapula turns up with the arm as measured")
{
    CHECK(scapula_upward_turn(60 * degree) == Approx(26 * degree));
    CHECK(scapula_upward_turn(105 * degree) == Approx(38.95 * degree));
    CHECK(scapula_upward_turn(170 * degree) > scapula_upward_turn(120 * degree));
    CHECK(scapula_upward_turn(-1) == Approx(scapula_upward_turn(0)));
}

TEST_CASE("The shoulder's bones rest at rest; a raised arm turns the scapula up along the ribs on both sides")
{
    const TriangleMesh ribs = ellipsoid({0, 1.25, 0}, {0.14, 0.22, 0.1});
    const RibCage cage(ribs.vertices);
    CHECK(cage.height({0.16, 1.25, 0}) == Approx(0.02).margin(1e-3));
    CHECK(cage.height({0, 1.25, -0.07}) < 0);
    for (const double side : {1.0, -1.0}) {
        const Eigen::Vector3d joint(side * 0.19, 1.38, -0.03), elbow(side * 0.35, 1.2, -0.03),
            inner(side * 0.02, 1.4, 0.06);
        TriangleMesh clavicle = ellipsoid({side * 0.10, 1.41, 0.02}, {0.08, 0.006, 0.006});
        const TriangleMesh scapula = ellipsoid({side * 0.11, 1.32, -0.10}, {0.05, 0.07, 0.005});
        const ShoulderMotion shoulder(joint, elbow, inner, clavicle.vertices, scapula.vertices, cage);
        const Eigen::Isometry3d rest = Eigen::Isometry3d::Identity();
        CHECK(largest(shoulder.bones(rest, rest, rest).scapula) < 1e-9);
        CHECK(largest(shoulder.bones(rest, rest, rest).clavicle) < 1e-9);

        const auto raised = shoulder.bones(rest, rest, about(joint, about_z(side * 100 * degree)));
        const double turn = rotation_angle(raised.scapula.linear(), Eigen::Matrix3d::Identity());
        CHECK(turn > 20 * degree);
        CHECK(turn < 45 * degree);
        const Eigen::Vector3d inferior(side * 0.11, 1.25, -0.10);
        const Eigen::Vector3d moved = raised.scapula * inferior;
        CHECK(side * (moved.x() - inferior.x()) > 0.02);  // outwards round the ribs
        CHECK(std::abs(cage.height(moved) - cage.height(inferior)) < 0.012);
        CHECK((raised.scapula * joint - joint).norm() < 0.02);
        CHECK((raised.clavicle * inner - inner).norm() < 1e-12);
    }
}

TEST_CASE("The radius turns by the pronation about the axis to the wrist; the ulna goes round without turning")
{
    const Eigen::Vector3d elbow(0.3, 1.2, 0), wrist(0.3, 0.95, 0);
    const TriangleMesh radius = ellipsoid({0.315, 1.07, 0}, {0.008, 0.12, 0.008});
    const TriangleMesh ulna = ellipsoid({0.288, 1.09, 0}, {0.008, 0.13, 0.008});
    const ForearmMotion forearm(elbow, wrist, radius.vertices, ulna.vertices);
    const Eigen::Isometry3d rest = Eigen::Isometry3d::Identity();
    CHECK(largest(forearm.bones(rest, rest).radius) < 1e-12);
    const double pronation = 1.2;
    // A bent wrist changes nothing.
    const auto bones = forearm.bones(rest, about(wrist, about_y(-pronation) * about_z(0.5)));
    CHECK(rotation_angle(bones.radius.linear(), Eigen::Matrix3d::Identity()) == Approx(pronation).margin(0.05));
    CHECK((bones.radius * wrist - wrist).norm() < 1e-12);
    CHECK((bones.ulna * elbow - elbow).norm() < 1e-12);
    CHECK(rotation_angle(bones.ulna.linear(), Eigen::Matrix3d::Identity()) < 8 * degree);
    // Their lower ends stay together.
    const Eigen::Vector3d low_radius(0.315, 0.96, 0), low_ulna(0.288, 0.97, 0);
    CHECK((bones.radius * low_radius - bones.ulna * low_ulna).norm() ==
          Approx((low_radius - low_ulna).norm()).margin(0.004));
}

TEST_CASE("Tibia and kneecap keep their distance to the femur however far the knee bends")
{
    const Eigen::Vector3d hip(0, 0.9, 0), knee(0, 0.5, 0);
    // The condyle's centre lies beside the joint's: without shifts the gaps would change by centimetres.
    const TriangleMesh femur = ellipsoid({0, 0.495, -0.003}, {0.035, 0.03, 0.036});
    const TriangleMesh tibia = ellipsoid({0, 0.40, 0}, {0.03, 0.062, 0.025});
    const TriangleMesh patella = ellipsoid({0, 0.505, 0.045}, {0.02, 0.02, 0.01});
    const KneeMotion motion(hip, knee, femur.vertices, femur.triangles, tibia.vertices, patella.vertices);
    const TriangleTree tree(femur.vertices, femur.triangles);
    const auto gap = [&](const TriangleMesh& bone, const Eigen::Isometry3d& moved) {
        double least = 1;
        for (Eigen::Index v = 0; v < bone.vertices.rows(); ++v)
            least = std::min(least, tree.signed_distance(moved * bone.vertices.row(v).transpose()));
        return least;
    };
    const Eigen::Isometry3d rest = Eigen::Isometry3d::Identity();
    CHECK(largest(motion.bones(rest, rest).shank) < 1e-5);
    CHECK(largest(motion.bones(rest, rest).patella) < 1e-5);
    const double tibia_gap = gap(tibia, rest), patella_gap = gap(patella, rest);
    for (int angle = 0; angle <= 145; angle += 29) {
        const Eigen::Isometry3d shin = about(knee, about_x(angle * degree));
        CHECK(motion.flexion(rest, shin) == Approx(angle * degree).margin(1e-12));
        const auto bones = motion.bones(rest, shin);
        CAPTURE(angle);
        CHECK(gap(tibia, bones.shank) == Approx(tibia_gap).epsilon(0.15));
        CHECK(gap(patella, bones.patella) == Approx(patella_gap).epsilon(0.15));
        CHECK(rotation_angle(bones.shank.linear(), shin.linear()) < 1e-9);
    }
    // In deep flexion the kneecap lies below the condyles and looks down, not back.
    const auto deep = motion.bones(rest, about(knee, about_x(120 * degree)));
    const Eigen::Vector3d place = deep.patella * Eigen::Vector3d(0, 0.505, 0.045) - knee;
    CHECK(place.y() < -0.03);
    CHECK(std::abs(place.z()) < 0.02);
    CHECK((deep.patella.linear() * Eigen::Vector3d::UnitZ()).y() < -0.9);
}
