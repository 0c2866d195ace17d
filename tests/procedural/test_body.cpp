// SPDX-License-Identifier: Apache-2.0
// The procedural body: a closed symmetric skin with the stature and mass that were asked for, its weights and anatomy.
#include "ndg/body/skeleton.h"
#include "ndg/body/skinning.h"
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/intersections.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/procedural/body.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <set>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

const ProceduralBody& shared_body()
{
    static const ProceduralBody body;
    return body;
}

double mass(const ParametricSurface& s)
{
    return body_density * enclosed_volume(s.vertices, s.triangles);
}

/// 1 for an equilateral triangle, 0 for a flat one (Bank 1990).
double worst_shape(const ParametricSurface& s)
{
    double worst = 1.0;
    for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
        const Eigen::RowVector3d a = s.vertices.row(s.triangles(t, 0)), b = s.vertices.row(s.triangles(t, 1)),
                                 c = s.vertices.row(s.triangles(t, 2));
        const double sides = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
        worst = std::min(worst, 2.0 * std::sqrt(3.0) * (b - a).cross(c - a).norm() / sides);
    }
    return worst;
}

double asymmetry(const ProceduralBody& body, const Points& vertices)
{
    double worst = 0.0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        const Eigen::RowVector3d other = vertices.row(body.mirror()[v]);
        worst = std::max(worst, (other - vertices.row(v).cwiseProduct(Eigen::RowVector3d(-1, 1, 1))).norm());
    }
    return worst;
}

}  // namespace

TEST_CASE("the procedural skin is closed, symmetric and stands as agreed", "[procedural]")
{
    const ProceduralBody& body = shared_body();
    const ParametricSurface s = body.evaluate({});
    const Eigen::Index n = s.vertices.rows(), t = s.triangles.rows();
    CHECK(n > 10000);
    CHECK(n < 28000);
    CHECK(t == 2 * n - 4);  // genus 0
    CHECK(closed_surface_defect(s.vertices, s.triangles).empty());
    CHECK(self_intersections(s.vertices, s.triangles).empty());
    CHECK(asymmetry(body, s.vertices) == 0.0);
    CHECK(s.vertices.col(1).minCoeff() == Approx(0.0).margin(1e-12));
    CHECK(stature(s.vertices) == Approx(1.70).epsilon(1e-9));

    const Skeleton& skeleton = standard_skeleton();
    const auto at = [&](const char* name) -> Eigen::RowVector3d { return s.joint_positions.row(skeleton.joint(name)); };
    CHECK(winding_numbers(s.vertices, s.triangles, s.joint_positions).minCoeff() > 0.5);
    CHECK(std::abs(at("pelvis").x()) < 1e-12);
    CHECK(std::abs(at("pelvis").z()) < 0.01);
    CHECK(at("left_hand").x() > 0.4);
    CHECK(at("left_toes").z() > at("left_foot").z() + 0.08);
    CHECK(at("left_eye").z() > at("head").z());
    const Eigen::RowVector3d arm = at("left_hand") - at("left_upper_arm");
    const double off_trunk = std::atan2(arm.x(), -arm.y()) * 180.0 / 3.14159265358979;
    CHECK(off_trunk > 38.0);
    CHECK(off_trunk < 52.0);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[j];
        if (name.rfind("left_", 0) != 0) continue;
        const Eigen::RowVector3d right = s.joint_positions.row(skeleton.joint("right_" + name.substr(5)));
        CHECK((right - s.joint_positions.row(j).cwiseProduct(Eigen::RowVector3d(-1, 1, 1))).norm() < 1e-12);
    }
}

TEST_CASE("weights of the procedural body", "[procedural]")
{
    const ProceduralBody& body = shared_body();
    const RowMatrix& weights = body.weights();
    const ParametricSurface s = body.evaluate({});
    REQUIRE(weights.rows() == s.vertices.rows());
    REQUIRE(weights.cols() == num_standard_joints);
    CHECK(weights.minCoeff() >= 0.0);
    CHECK((weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-12);
    CHECK((weights.array() > 0.0).cast<int>().rowwise().sum().maxCoeff() <= max_influences);
    const Skeleton& skeleton = standard_skeleton();
    // No weight of the other side, except near the middle.
    double astray = 0.0;
    for (Eigen::Index v = 0; v < weights.rows(); ++v)
        for (int j = 0; j < num_standard_joints; ++j)
            if (skeleton.joint_names[j].rfind("right_", 0) == 0 && s.vertices(v, 0) > 0.06)
                astray = std::max(astray, weights(v, j));
    CHECK(astray == 0.0);
    // Neighbours differ little: nothing tears.
    double jump = 0.0;
    for (const MeshEdge& edge : mesh_edges(s.triangles, static_cast<int>(s.vertices.rows())))
        jump = std::max(jump, (weights.row(edge.v0) - weights.row(edge.v1)).cwiseAbs().maxCoeff());
    CHECK(jump < 0.6);
    // Every joint that moves skin has some of its own.
    for (const char* name :
         {"pelvis", "spine_3", "neck_1", "head", "jaw", "left_clavicle", "left_upper_arm", "left_forearm_twist",
          "left_hand", "left_thumb_3", "left_pinky_2", "left_thigh", "left_shin", "left_foot", "left_toes"})
        CHECK(weights.col(skeleton.joint(name)).maxCoeff() > 0.7);

    // Bent elbow, knee and hip: no more than a few triangles of the skin turn over.
    Pose pose = Pose::rest(num_standard_joints);
    const auto bend = [&](const char* name, double angle, const Eigen::Vector3d& axis) {
        pose.parent_from_joint[skeleton.joint(name)] = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    };
    bend("left_forearm", -1.0, {0.73, 0.68, 0.0});
    bend("left_shin", 1.0, {1.0, 0.0, 0.0});
    bend("left_thigh", -0.8, {1.0, 0.0, 0.0});
    const Points posed = linear_blend_skinning(s.vertices, sparsify_weights(weights),
                                               forward_kinematics(skeleton, s.joint_positions, pose));
    CHECK(enclosed_volume(posed, s.triangles) == Approx(enclosed_volume(s.vertices, s.triangles)).epsilon(0.03));
}

TEST_CASE("procedural people come out as asked, without folds", "[procedural][slow]")
{
    const ProceduralBody& body = shared_body();
    Random random(5, "test people");
    for (int i = 0; i < 7; ++i) {
        ProceduralParameters p;
        p.stature_m = random.uniform(1.45, 2.0);
        p.sex = i < 2 ? i : random.uniform();
        // The first two are the extremes of the adult range, of middling build.
        p.mass_kg = (i == 0 ? 34.9 : i == 1 ? 17.0 : random.uniform(17.0, 34.9)) * p.stature_m * p.stature_m;
        p.muscularity = i < 2 ? 0.5 : random.uniform();
        p.arm_length = random.uniform(0.93, 1.07);
        p.leg_length = random.uniform(0.95, 1.05);
        p.shoulder_breadth = random.uniform(0.94, 1.06);
        p.hip_breadth = random.uniform(0.94, 1.06);
        const ParametricSurface s = body.evaluate(p);
        INFO("person " << i << ": sex " << p.sex << ", stature " << p.stature_m << ", bmi " << p.bmi());
        CHECK(stature(s.vertices) == Approx(p.stature_m).epsilon(1e-9));
        CHECK(mass(s) == Approx(p.mass_kg).epsilon(0.02));
        CHECK(asymmetry(body, s.vertices) == 0.0);
        CHECK(closed_surface_defect(s.vertices, s.triangles).empty());
        CHECK(self_intersections(s.vertices, s.triangles).empty());
        CHECK(worst_shape(s) > 0.02);
        CHECK(winding_numbers(s.vertices, s.triangles, s.joint_positions).minCoeff() > 0.5);
    }
}

TEST_CASE("procedural parameters do what they say", "[procedural][slow]")
{
    const ProceduralBody& body = shared_body();
    const Skeleton& skeleton = standard_skeleton();
    const ParametricSurface base = body.evaluate({});
    const auto distance = [&](const ParametricSurface& s, const char* a, const char* b) {
        return (s.joint_positions.row(skeleton.joint(a)) - s.joint_positions.row(skeleton.joint(b))).norm();
    };
    ProceduralParameters p;
    p.arm_length = 1.06;
    p.leg_length = 1.04;
    const ParametricSurface longer = body.evaluate(p);
    CHECK(distance(longer, "left_upper_arm", "left_hand") ==
          Approx(1.06 * distance(base, "left_upper_arm", "left_hand")).epsilon(0.01));
    CHECK(distance(longer, "left_thigh", "left_foot") ==
          Approx(1.04 * distance(base, "left_thigh", "left_foot")).epsilon(0.02));
    CHECK(stature(longer.vertices) == Approx(1.70).epsilon(1e-9));

    p = {};
    p.sex = 1.0;
    CHECK(distance(body.evaluate(p), "left_upper_arm", "right_upper_arm") >
          distance(base, "left_upper_arm", "right_upper_arm") + 0.01);

    // At the same stature more mass widens the waist.
    const auto waist = [&](const ParametricSurface& s) {
        const double y = s.joint_positions(skeleton.joint("spine_1"), 1);
        double widest = 0.0;
        for (Eigen::Index v = 0; v < s.vertices.rows(); ++v)
            if (std::abs(s.vertices(v, 1) - y) < 0.02 && std::abs(s.vertices(v, 0)) < 0.25)
                widest = std::max(widest, s.vertices(v, 0));
        return widest;
    };
    p = {};
    p.mass_kg = 90.0;
    CHECK(waist(body.evaluate(p)) > waist(base) + 0.02);

    const auto refused = [&](auto change, const char* words) {
        ProceduralParameters bad;
        change(bad);
        CHECK_THROWS_AS(body.evaluate(bad), InputError);
        CHECK_THROWS_WITH(body.evaluate(bad), Contains(words));
    };
    refused([](ProceduralParameters& q) { q.stature_m = 1.0; }, "stature_m is 1");
    refused([](ProceduralParameters& q) { q.mass_kg = -3.0; }, "mass_kg is -3");
    refused([](ProceduralParameters& q) { q.mass_kg = 200.0; }, "body mass index");
    refused([](ProceduralParameters& q) { q.sex = 1.5; }, "sex is 1.5");
    refused([](ProceduralParameters& q) { q.muscularity = std::nan(""); }, "muscularity is nan");
    refused([](ProceduralParameters& q) { q.arm_length = 1.4; }, "arm_length is 1.4");
    refused([](ProceduralParameters& q) { q.leg_length = 0.5; }, "leg_length is 0.5");
}

TEST_CASE("sampled adults follow the published statistics", "[procedural][slow]")
{
    double stature_sum[2] = {0, 0}, stature_squares[2] = {0, 0}, bmi_sum[2] = {0, 0};
    constexpr int count = 2000;
    for (int i = 0; i < 2 * count; ++i) {
        const ProceduralParameters p = sample_procedural_parameters(3, i);
        p.check();
        stature_sum[i % 2] += p.stature_m / count;
        stature_squares[i % 2] += p.stature_m * p.stature_m / count;
        bmi_sum[i % 2] += p.bmi() / count;
        CHECK((p.sex > 0.5) == (i % 2 == 1));
        CHECK(p.bmi() >= 17.0 - 1e-9);
        CHECK(p.bmi() <= 35.0 + 1e-9);
    }
    CHECK(stature_sum[0] == Approx(1.613).margin(0.006));
    CHECK(stature_sum[1] == Approx(1.753).margin(0.006));
    CHECK(std::sqrt(stature_squares[1] - stature_sum[1] * stature_sum[1]) == Approx(0.075).margin(0.005));
    // The published distributions (means 29.7 and 29.4) between 17 and 35 alone.
    CHECK(bmi_sum[0] == Approx(26.9).margin(0.4));
    CHECK(bmi_sum[1] == Approx(27.5).margin(0.3));
    const ProceduralParameters a = sample_procedural_parameters(3, 17), b = sample_procedural_parameters(3, 17),
                               c = sample_procedural_parameters(4, 17);
    CHECK(a.stature_m == b.stature_m);
    CHECK(a.mass_kg == b.mass_kg);
    CHECK(a.stature_m != c.stature_m);
    CHECK_THROWS_AS(sample_procedural_parameters(3, -1), InputError);
}

TEST_CASE("the procedural anatomy lies inside the skin", "[procedural][slow]")
{
    const ProceduralBody& body = shared_body();
    const TemplateSource source = body.source({});
    CHECK(source.kind == SourceKind::procedural);
    CHECK(source.weights.rows() == source.surface.vertices.rows());
    CHECK(source.joint_positions == source.surface.joint_positions);
    const TriangleTree skin(source.surface.vertices, source.surface.triangles);
    std::set<std::string> names;
    int bones = 0, muscles = 0;
    Eigen::Index vertices = 0;
    for (const AnatomyMesh& part : source.anatomy) {
        INFO(part.name);
        CHECK(names.insert(part.name).second);
        CHECK(closed_surface_defect(part.vertices, part.triangles).empty());
        const bool bone = part.layer == AnatomyLayer::bone;
        (bone ? bones : muscles) += 1;
        if (bone) CHECK_NOTHROW(standard_skeleton().joint(part.joint));
        vertices += part.vertices.rows();
        const bool digit =
            part.name.find("phalanx") != std::string::npos || part.name.find("meta") != std::string::npos;
        const double cover = !bone ? 0.0025 : digit ? 0.0020 : 0.0040;
        double least = 1.0;
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v)
            least = std::min(least, -skin.signed_distance(part.vertices.row(v).transpose()));
        CHECK(least > cover - 1e-4);
        const double middle = part.vertices.col(0).mean();
        CHECK(((part.side == BodySide::left && middle > 0.0) || (part.side == BodySide::right && middle < 0.0) ||
               (part.side == BodySide::middle && std::abs(middle) < 0.004)));
    }
    CHECK(bones > 150);
    CHECK(muscles > 60);
    CHECK(vertices > 20000);
    CHECK(vertices < 80000);  // muscles have a ring every 15 mm
    for (const char* name :
         {"Skull without mandible", "Mandible", "Atlas", "Fifth lumbar vertebra", "Sacrum", "Sternum", "Left first rib",
          "Right twelfth rib", "Left femur", "Right patella", "Left ulna", "Left gluteus maximus",
          "Right rectus abdominis", "Left soleus", "Left latissimus dorsi"})
        CHECK(names.count(name) == 1);
}

TEST_CASE("the procedural body is the same every time", "[procedural][slow]")
{
    const ProceduralBody again;
    CHECK(again.triangles() == shared_body().triangles());
    CHECK(again.weights() == shared_body().weights());
    CHECK(again.evaluate({}).vertices == shared_body().evaluate({}).vertices);
}
