// SPDX-License-Identifier: Apache-2.0
// Wraps around anatomy: envelopes and energy by themselves, then a small trunk with bones and a muscle.
#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/wraps/anatomy_wraps.h"
#include "ndg/wraps/bone_interior.h"
#include "ndg/wraps/envelope.h"
#include "ndg/wraps/wrap_optimiser.h"
#include "wraps/gradient_error.h"

#include <Eigen/Cholesky>

#include <catch2/catch.hpp>

#include <cmath>
#include <random>

using namespace ndg;
using Catch::Matchers::Contains;
using test::gradient_error;

namespace {

/// An oval tube of skin along y from 0 to 0.5 m, half axes 0.09 and 0.07 m, open at both ends, that hangs on `joint`.
WrapSkin trunk_skin(int rings, int segments, const char* joint)
{
    WrapSkin skin;
    const Skeleton& skeleton = standard_skeleton();
    skin.joint_positions = Points::Zero(skeleton.num_joints(), 3);
    double height = 0.05;
    for (const char* name : {"pelvis", "spine_1", "spine_2", "spine_3", "spine_4", "spine_5"}) {
        skin.joint_positions.row(skeleton.joint(name)) << 0.0, height, -0.02;
        height += 0.08;
    }
    skin.vertices.resize(rings * segments, 3);
    skin.weights = RowMatrix::Zero(rings * segments, skeleton.num_joints());
    skin.weights.col(skeleton.joint(joint)).setOnes();
    skin.triangles.resize(2 * (rings - 1) * segments, 3);
    int t = 0;
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < segments; ++k) {
            const double angle = 2.0 * M_PI * (k + 0.5 * (r % 2)) / segments;
            skin.vertices.row(r * segments + k) << 0.09 * std::cos(angle), 0.5 * r / (rings - 1),
                -0.07 * std::sin(angle);
            if (r + 1 == rings) continue;
            const int a = r * segments + k, b = r * segments + (k + 1) % segments;
            const int c = a + segments, d = b + segments;
            if (r % 2 == 0) {
                skin.triangles.row(t++) << a, b, c;
                skin.triangles.row(t++) << b, d, c;
            } else {
                skin.triangles.row(t++) << a, b, d;
                skin.triangles.row(t++) << a, d, c;
            }
        }
    return skin;
}

/// A closed ball drawn out from `from` to `to`.
AnatomyMesh capsule(const char* name, const char* layer, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
                    double radius)
{
    constexpr int rings = 14, sectors = 16;
    AnatomyMesh mesh;
    mesh.name = name;
    mesh.layer = parse_name<AnatomyLayer>(layer);
    const Eigen::Vector3d axis = (to - from).normalized(), u = axis.unitOrthogonal(), w = axis.cross(u);
    mesh.vertices.resize((rings + 1) * sectors, 3);
    mesh.triangles.resize(2 * rings * sectors, 3);
    int t = 0;
    for (int r = 0; r <= rings; ++r)
        for (int s = 0; s < sectors; ++s) {
            const double polar = M_PI * r / rings, around = 2.0 * M_PI * s / sectors;
            const Eigen::Vector3d direction =
                std::cos(polar) * axis + std::sin(polar) * (std::cos(around) * u + std::sin(around) * w);
            mesh.vertices.row(r * sectors + s) = ((r <= rings / 2 ? to : from) + radius * direction).transpose();
            if (r == rings) continue;
            const int a = r * sectors + s, b = r * sectors + (s + 1) % sectors;
            mesh.triangles.row(t++) << a, a + sectors, b;
            mesh.triangles.row(t++) << b, a + sectors, b + sectors;
        }
    return mesh;
}

/// A smooth field without kinks, linear so that the grid holds it exactly.
ScalarGrid linear_field(const Points& around, const Eigen::Vector3d& slope, double shift)
{
    ScalarGrid grid;
    grid.box = grid_around(around, 0.05, 0.02);
    grid.values.resize(grid.box.count());
    for (int k = 0; k < grid.box.size[2]; ++k)
        for (int j = 0; j < grid.box.size[1]; ++j)
            for (int i = 0; i < grid.box.size[0]; ++i)
                grid.values[grid.box.index(i, j, k)] = static_cast<float>(slope.dot(grid.box.node(i, j, k)) + shift);
    return grid;
}

/// Wraps at shares of the way to the tube's axis, shaken a little.
WrapPair shaken_wraps(const WrapSkin& skin)
{
    std::mt19937 random(5);
    std::uniform_real_distribution<double> shake(-0.0006, 0.0006);
    WrapPair wraps{skin.vertices, skin.vertices};
    for (Eigen::Index v = 0; v < skin.vertices.rows(); ++v)
        for (int c = 0; c < 3; ++c) {
            wraps.bone(v, c) = (c == 1 ? 1.0 : 0.6) * skin.vertices(v, c) + shake(random);
            wraps.muscle(v, c) = (c == 1 ? 1.0 : 0.85) * skin.vertices(v, c) + shake(random);
        }
    return wraps;
}

}  // namespace

TEST_CASE("wraps: the energy's gradient against differences, with every term at work")
{
    const WrapSkin skin = trunk_skin(5, 9, "spine_2");
    const ScalarGrid bone = linear_field(skin.vertices, {0.8, 0.1, -0.5}, 0.003);
    const ScalarGrid muscle = linear_field(skin.vertices, {-0.3, 0.2, 0.9}, -0.004);
    const ScalarGrid cover = linear_field(skin.vertices, {0.5, 0.5, 0.1}, -0.2);
    WrapEnergyOptions options;
    options.active_jacobian = 0.95;
    options.active_thickness = 0.03;
    options.active_area = 0.9;
    options.repulsion = 7.0;
    WrapEnergy energy(skin, bone, muscle, cover, options);
    energy.margins.setConstant(0.001);
    const WrapPair wraps = shaken_wraps(skin);
    WrapPair gradient;
    REQUIRE(std::isfinite(energy.evaluate(wraps, &gradient)));
    const auto at_bone = [&](const Eigen::MatrixXd& at) { return energy.evaluate({at, wraps.muscle}, nullptr); };
    const auto at_muscle = [&](const Eigen::MatrixXd& at) { return energy.evaluate({wraps.bone, at}, nullptr); };
    CHECK(gradient_error(at_bone, wraps.bone, gradient.bone, 1e-7) < 1e-5);
    CHECK(gradient_error(at_muscle, wraps.muscle, gradient.muscle, 1e-7) < 1e-5);

    // A wrap turned inside out is infinitely bad.
    CHECK(std::isinf(energy.evaluate({wraps.muscle, wraps.bone}, nullptr)));
}

TEST_CASE("wraps: the Hessian is exact where the energy is quadratic, and definite with all barriers")
{
    const WrapSkin skin = trunk_skin(5, 9, "spine_2");
    const ScalarGrid bone = linear_field(skin.vertices, {0.8, 0.1, -0.5}, 1.0);
    const ScalarGrid muscle = linear_field(skin.vertices, {-0.3, 0.2, 0.9}, 1.0);
    const ScalarGrid cover = linear_field(skin.vertices, {0.0, 0.0, 0.0}, -1.0);
    WrapEnergyOptions options;
    options.active_jacobian = 1e-9;
    options.active_thickness = 1e-9;
    options.active_area = 1e-9;
    options.min_area = 0.0;
    WrapEnergy energy(skin, bone, muscle, cover, options);
    const WrapPair wraps = shaken_wraps(skin);
    const Eigen::MatrixXd hessian = Eigen::MatrixXd(energy.hessian(wraps)).selfadjointView<Eigen::Lower>();
    WrapPair other = shaken_wraps(skin), first, second;
    other.bone.array() *= 1.001;
    other.muscle.array() += 0.0007;
    energy.evaluate(wraps, &first);
    energy.evaluate(other, &second);
    const Eigen::Index count = skin.vertices.rows();
    Eigen::VectorXd step(6 * count), change(6 * count);
    for (Eigen::Index v = 0; v < count; ++v)
        for (int c = 0; c < 3; ++c) {
            step[6 * v + c] = other.bone(v, c) - wraps.bone(v, c);
            step[6 * v + 3 + c] = other.muscle(v, c) - wraps.muscle(v, c);
            change[6 * v + c] = second.bone(v, c) - first.bone(v, c);
            change[6 * v + 3 + c] = second.muscle(v, c) - first.muscle(v, c);
        }
    // but for the small ridge that keeps it definite
    CHECK((hessian * step - change).norm() < 1e-3 * change.norm());

    energy.options.active_jacobian = 0.95;
    energy.options.active_thickness = 0.03;
    const Eigen::MatrixXd full = Eigen::MatrixXd(energy.hessian(wraps)).selfadjointView<Eigen::Lower>();
    CHECK(full.llt().info() == Eigen::Success);
    CHECK(full.norm() > hessian.norm());
}

TEST_CASE("wraps: envelopes lie around each other, and as deep as they should")
{
    const WrapSkin skin = trunk_skin(14, 16, "left_upper_arm");
    constexpr double radius = 0.012;
    const std::vector<AnatomyMesh> anatomy = {
        capsule("shaft", "bone", {0, -0.1, 0}, {0, 0.6, 0}, radius),
        // far too near to the skin
        capsule("sheet", "muscle", {0.086, 0.2, 0}, {0.086, 0.3, 0}, 0.003),
    };
    EnvelopeOptions options;
    options.spacing = 0.003;
    const WrapEnvelopes envelopes = wrap_envelopes(skin, anatomy, options);
    for (const double at : {0.02, 0.03, 0.045})
        CHECK(envelopes.bone.at({0.0, 0.251, at}) ==
              Approx(at - radius - options.bone_dilation * options.spacing).margin(6e-4));
    CHECK(envelopes.bone.at({0.001, 0.251, 0.0}) < -0.005);
    for (double x = -0.08; x <= 0.08; x += 0.007)
        for (double y = 0.05; y < 0.45; y += 0.05) {
            const Eigen::Vector3d point(x, y, 0.006);
            const double depth = -envelopes.skin.at(point);
            if (depth > options.muscle_depth + 0.006)
                CHECK(envelopes.muscle.at(point) <= envelopes.bone.at(point) - options.min_thickness + 1e-6);
            if (depth < options.muscle_depth - 0.001) CHECK(envelopes.muscle.at(point) > 0.0);
        }
    // What sticks out of the skin does not take the envelope with it.
    CHECK(envelopes.muscle.at({0.0885, 0.25, 0.0}) > 0.0);
}

TEST_CASE("wraps: the optimiser only goes down, from a shell or from wraps that are valid")
{
    const WrapSkin skin = trunk_skin(14, 16, "left_upper_arm");
    const std::vector<AnatomyMesh> anatomy = {capsule("shaft", "bone", {0, -0.1, 0}, {0, 0.6, 0}, 0.012)};
    EnvelopeOptions options;
    options.spacing = 0.004;
    const WrapEnvelopes envelopes = wrap_envelopes(skin, anatomy, options);
    WrapEnergy energy(skin, envelopes.bone, envelopes.muscle, envelopes.skin, {});
    const WrapTargets targets;
    WrapOptimiser optimiser(skin, energy, targets, "tube");
    const double shell = energy.evaluate(optimiser.wraps(), nullptr);
    REQUIRE(std::isfinite(shell));
    CHECK(optimiser.flow(12, 0.0) == 12);
    const double first = energy.evaluate(optimiser.wraps(), nullptr);
    CHECK(first < 0.5 * shell);

    WrapOptimiser next(skin, energy, targets, optimiser.wraps());
    CHECK(next.wraps().bone == optimiser.wraps().bone);
    CHECK(next.flow(20, 0.0) > 0);
    CHECK(energy.evaluate(next.wraps(), nullptr) < first);
    // Bounds have risen to what was wanted and hold.
    CHECK(energy.jacobian_bounds.minCoeff() == Approx(targets.min_scaled_jacobian));
    CHECK(energy.thickness_bounds.minCoeff() == Approx(targets.min_thickness));
}

TEST_CASE("wraps: around two bones and a muscle, inside a skin")
{
    const WrapSkin skin = trunk_skin(20, 18, "left_upper_arm");
    // The capsules of the bones have vertices beyond the cuts only, which must not matter.
    const std::vector<AnatomyMesh> anatomy = {
        capsule("front bone", "bone", {0.014, -0.1, 0.012}, {0.012, 0.6, 0.01}, 0.012),
        capsule("back bone", "bone", {-0.016, -0.1, -0.01}, {-0.018, 0.6, -0.012}, 0.009),
        capsule("muscle", "muscle", {0.05, 0.1, 0.0}, {0.052, 0.4, 0.005}, 0.022),
    };
    AnatomyWrapOptions options;
    const Wraps wraps = anatomy_wraps(skin, anatomy, options);
    CHECK(wraps.min_scaled_jacobian >= options.min_scaled_jacobian);

    double smallest = 1.0;
    for (Eigen::Index t = 0; t < skin.triangles.rows(); ++t) {
        PrismVertices fat, flesh;
        for (int k = 0; k < 3; ++k) {
            const int v = skin.triangles(t, k);
            fat.row(k) = skin.vertices.row(v);
            fat.row(3 + k) = flesh.row(k) = wraps.muscle.row(v);
            flesh.row(3 + k) = wraps.bone.row(v);
        }
        smallest = std::min({smallest, prism_min_scaled_jacobian(fat), prism_min_scaled_jacobian(flesh)});
    }
    CHECK(smallest == Approx(wraps.min_scaled_jacobian).epsilon(1e-3));  // that one is of single-precision positions

    // Winding numbers know nothing of distance grids or pseudonormals.
    const auto share_inside = [&](const Points& wrap, const AnatomyMesh& part) {
        const ClosedBoneWrap closed = close_bone_wrap(wrap, skin.triangles);
        std::vector<Eigen::RowVector3d> inner;
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v)
            if (part.vertices(v, 1) > 0.01 && part.vertices(v, 1) < 0.49) inner.emplace_back(part.vertices.row(v));
        Points points(static_cast<Eigen::Index>(inner.size()), 3);
        for (std::size_t v = 0; v < inner.size(); ++v) points.row(static_cast<Eigen::Index>(v)) = inner[v];
        return (winding_numbers(closed.vertices, closed.triangles, points).array() > 0.5).cast<double>().mean();
    };
    const auto axis_points = [](const Eigen::RowVector3d& from, const Eigen::RowVector3d& to) {
        Points points(40, 3);
        for (int i = 0; i < 40; ++i) points.row(i) = from + (i + 0.5) / 40.0 * (to - from);
        return points;
    };
    AnatomyMesh axes;
    axes.vertices.resize(80, 3);
    axes.vertices << axis_points({0.014, 0.02, 0.012}, {0.012, 0.48, 0.01}),
        axis_points({-0.016, 0.02, -0.01}, {-0.018, 0.48, -0.012});
    CHECK(share_inside(wraps.bone, axes) == 1.0);
    CHECK(share_inside(wraps.muscle, axes) == 1.0);
    CHECK(share_inside(wraps.muscle, anatomy[2]) == 1.0);
    // The muscle lies outside the bone wrap, which has come down to the bones.
    CHECK(share_inside(wraps.bone, anatomy[2]) < 0.5);

    for (const Points* inner : {&wraps.bone, &wraps.muscle}) CHECK(self_intersections(*inner, skin.triangles).empty());
    Points all(3 * skin.vertices.rows(), 3);
    all << wraps.bone, wraps.muscle, skin.vertices;
    Triangles triangles(3 * skin.triangles.rows(), 3);
    const int count = static_cast<int>(skin.vertices.rows());
    triangles << skin.triangles, Triangles(skin.triangles.array() + count),
        Triangles(skin.triangles.array() + 2 * count);
    CHECK(self_intersections(all, triangles).empty());

    // Border vertices stay in the plane of their cut.
    for (int k = 0; k < 18; ++k) {
        CHECK(std::abs(wraps.bone(k, 1)) < 0.003);
        CHECK(std::abs(wraps.muscle(k, 1)) < 0.003);
    }
}

TEST_CASE("wraps: what cannot be wrapped is refused")
{
    const WrapSkin skin = trunk_skin(14, 16, "left_upper_arm");
    const AnatomyMesh muscle = capsule("muscle", "muscle", {0, 0.1, 0}, {0, 0.4, 0}, 0.02);
    CHECK_THROWS_WITH(anatomy_wraps(skin, {muscle}, {}), Contains("no bone to wrap"));
    const AnatomyMesh shaft = capsule("shaft", "bone", {0, -0.1, 0}, {0, 0.6, 0}, 0.015);
    const AnatomyMesh spur = capsule("spur", "bone", {0.0, 0.25, 0.0}, {0.0875, 0.25, 0.0}, 0.002);
    CHECK_THROWS_WITH(anatomy_wraps(skin, {shaft, spur}, {}), Contains("spur sticks out"));
    WrapSkin crumpled = skin;
    crumpled.vertices.row(100) = crumpled.vertices.row(101);
    CHECK_THROWS_WITH(anatomy_wraps(crumpled, {shaft}, {}), Contains("no shell under the skin is valid"));
}
