// SPDX-License-Identifier: Apache-2.0
// Measures of the procedural template body and of bodies spoilt in known ways.
#include "ndg/body/anatomy.h"
#include "ndg/body_source/bone_cover.h"
#include "ndg/core/angles.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/measures/measure_report.h"
#include "ndg/procedural/body.h"
#include "ndg/template_build/landmarks.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// The procedural body with layers of 10 mm of fat and 10 mm of muscle all over, its bones where their maker puts them.
const Template& small_template()
{
    static const Template made = [] {
        const TemplateSource source = ProceduralBody().source(ProceduralParameters());
        Template t;
        t.skeleton = standard_skeleton();
        t.skin_triangles = t.wrap_triangles = source.surface.triangles;
        t.skin_weights = sparsify_weights(source.weights);
        t.rest.name = "template";
        t.rest.skin_vertices = source.surface.vertices;
        t.rest.joint_positions = source.joint_positions;
        const Eigen::Index n = t.rest.skin_vertices.rows();
        for (int v = 0; v < n; ++v) t.wrap_to_skin.push_back(v);
        t.prisms = layer_prisms(t.wrap_triangles, int(n));
        t.tetrahedra.resize(0, 4);
        const Points inward = -vertex_normals(t.rest.skin_vertices, t.skin_triangles);
        t.rest.volume_vertices.resize(3 * n, 3);
        t.rest.volume_vertices << t.rest.skin_vertices + 0.02 * inward, t.rest.skin_vertices + 0.01 * inward,
            t.rest.skin_vertices;
        t.rest.interior_vertices.resize(0, 3);
        // No bone is embedded: all follow the skin about their joint.
        const TriangleMesh joined = join_meshes(source.anatomy);
        t.anatomy_vertices = joined.vertices;
        t.anatomy_triangles = joined.triangles;
        RowMatrix weights = RowMatrix::Zero(joined.vertices.rows(), t.skeleton.num_joints());
        weights.col(0).setOnes();
        t.anatomy_weights = sparsify_weights(weights);
        t.embedding.elements.assign(joined.vertices.rows(), -1);
        t.embedding.vertices = RowMatrixI::Zero(joined.vertices.rows(), 6);
        t.embedding.weights = RowMatrix::Zero(joined.vertices.rows(), 6);
        int vertex = 0, triangle = 0;
        for (const AnatomyMesh& mesh : source.anatomy) {
            const int vertices = int(mesh.vertices.rows()), triangles = int(mesh.triangles.rows());
            t.anatomy_parts.push_back({mesh.name, mesh.layer, vertex, vertex + vertices, triangle, triangle + triangles,
                                       mesh.fma_id, mesh.side});
            vertex += vertices;
            triangle += triangles;
        }
        const TriangleTree surface(t.rest.skin_vertices, t.skin_triangles);
        for (const NamedPoint& point : skin_landmarks(t.rest.skin_vertices, source.weights, t.rest.joint_positions)) {
            const ClosestPoint closest = surface.closest(point.position);
            t.landmarks.push_back({point.name, closest.triangle_idx, closest.barycentric});
        }
        return t;
    }();
    return made;
}

const BodyMeasure& row(const MeasuredBody& body, const std::string& name)
{
    const auto found = std::find_if(body.measures.begin(), body.measures.end(),
                                    [&](const BodyMeasure& measure) { return measure.name == name; });
    INFO(name);
    REQUIRE(found != body.measures.end());
    return *found;
}

MeasuredBody measured(const Body& body)
{
    return measure_body(small_template(), body, Person());
}

/// The template with every point of body and bones moved by `move`.
template <typename Move>
MeasuredBody measured_moved(const Move& move)
{
    Template t = small_template();
    for (Points* points : {&t.rest.skin_vertices, &t.rest.joint_positions, &t.rest.volume_vertices,
                           &t.rest.interior_vertices, &t.anatomy_vertices})
        for (Eigen::Index v = 0; v < points->rows(); ++v) points->row(v) = move(Eigen::RowVector3d(points->row(v)));
    return measure_body(t, t.rest, Person());
}

const std::vector<std::string>& levels()
{
    static const std::vector<std::string> names = {"C7", "T1",  "T2",  "T3",  "T4", "T5", "T6", "T7", "T8",
                                                   "T9", "T10", "T11", "T12", "L1", "L2", "L3", "L4", "L5"};
    return names;
}

}  // namespace

TEST_CASE("The template body has the bones of people; depths follow its own fat", "[measures]")
{
    const Template& made = small_template();
    const MeasuredBody body = measured(made.rest);
    CHECK(body.stature_m == Approx(ProceduralParameters().stature_m).margin(0.002));
    for (std::size_t level = 0; level < levels().size(); ++level) {
        const BodyMeasure& depth = row(body, levels()[level] + " spinous process, depth");
        CHECK(depth.gate);
        CHECK(depth.high == Approx(spinous_depth(double(level), body.bmi) + 0.012));
    }
    for (const char* level : {"T1", "T2", "T3", "T4", "T8", "T12"})
        CHECK_FALSE(row(body, std::string(level) + " spinous process, depth").outside());
    for (const char* name :
         {"thoracic kyphosis T1 to T12", "lumbar lordosis T12 to S1", "shoulder joints apart", "hip joint, height",
          "knee joint, height", "biacromial breadth over stature", "biiliac breadth over stature",
          "bones on the other side", "femur, length", "tibia, length", "humerus, length", "radius, length",
          "ulna, length", "legs, left to right", "femoral head, diameter", "femur, epicondylar breadth"}) {
        INFO(row(body, name).failure());
        CHECK(row(body, name).gate);
        CHECK_FALSE(row(body, name).outside());
    }
    // From the drawing board's vertebrae: C7, T2 and T11, L1 at (height, z) 1.429 -0.037, 1.392 -0.048, 1.195 -0.048,
    // 1.139 -0.037.
    const double drawn = std::atan2(0.011, 0.037) + std::atan2(0.011, 0.056);
    CHECK(row(body, "thoracic kyphosis T1 to T12").value == Approx(drawn).margin(2.0 * radians_per_degree));
    // Both sides of the procedural body are the same.
    CHECK(row(body, "joints, left to right").value < 1e-9);
    CHECK(row(body, "legs, left to right").value < 1e-3);
}

TEST_CASE("A body whose bones stand too far forward fails by name", "[measures]")
{
    Template spoilt = small_template();
    spoilt.anatomy_vertices.col(2).array() += 0.03;
    const MeasuredBody before = measured(small_template().rest), after = measure_body(spoilt, spoilt.rest, Person());
    const std::string sentences = failure_report({after});
    // Less where the back slopes, since depth is the distance to the nearest skin.
    for (const std::string level : {"T2", "T4", "T6", "T8", "T10"}) {
        const std::string name = level + " spinous process, depth";
        CHECK(row(after, name).value - row(before, name).value == Approx(0.03).margin(0.01));
        CHECK(row(after, name).outside());
        CHECK_THAT(sentences, Contains(name));
    }
    CHECK_THAT(sentences, Contains("body template is outside"));
    CHECK(row(after, "femur, length").value == Approx(row(before, "femur, length").value).epsilon(1e-6));
    // But for vertices at the limit of what counts as the front of a vertebra.
    CHECK(row(after, "thoracic kyphosis T1 to T12").value ==
          Approx(row(before, "thoracic kyphosis T1 to T12").value).margin(0.01));
}

TEST_CASE("A mirrored body is caught, a grown one keeps its proportions", "[measures]")
{
    const Template& made = small_template();
    const MeasuredBody before = measured(made.rest);
    const MeasuredBody mirrored =
        measured_moved([](Eigen::RowVector3d p) { return Eigen::RowVector3d(-p.x(), p.y(), p.z()); });
    CHECK(row(mirrored, "bones on the other side").value > 100);
    CHECK(row(mirrored, "bones on the other side").outside());

    const MeasuredBody grown = measured_moved([](Eigen::RowVector3d p) { return 1.1 * p; });
    CHECK(grown.bmi == Approx(1.1 * before.bmi));
    for (const char* name : {"femur, length", "radius, length", "femoral head, diameter", "fat layer, mean"})
        CHECK(row(grown, name).value == Approx(1.1 * row(before, name).value).epsilon(0.005));
    for (const char* name : {"rib cage, depth over breadth", "biacromial breadth over stature", "thigh",
                             "thoracic kyphosis T1 to T12", "trunk, share of mass"})
        CHECK(row(grown, name).value == Approx(row(before, name).value).epsilon(0.005));
}

TEST_CASE("Kyphosis and lordosis are the bends of the spine, in their signs", "[measures]")
{
    const Template& made = small_template();
    const MeasuredBody before = measured(made.rest);
    // z -> z + c/2 (y - y0)^2 leans a vertical line at height y by c (y - y0): more kyphosis, less lordosis.
    const double c = -0.6;
    const double pelvis = made.rest.joint_positions(0, 1);
    const MeasuredBody bent = measured_moved([&](Eigen::RowVector3d p) {
        return Eigen::RowVector3d(p.x(), p.y(), p.z() + 0.5 * c * std::pow(p.y() - pelvis, 2));
    });
    const double kyphosis =
        row(bent, "thoracic kyphosis T1 to T12").value - row(before, "thoracic kyphosis T1 to T12").value;
    const double lordosis =
        row(bent, "lumbar lordosis T12 to S1").value - row(before, "lumbar lordosis T12 to S1").value;
    // Thoracic spine about 0.25 m, lumbar about 0.17 m; with c < 0 the upper end leans back.
    CHECK(kyphosis == Approx(c * 0.25).margin(0.05));
    CHECK(lordosis == Approx(-c * 0.17).margin(0.05));
}

TEST_CASE("The hip joint's regression is Harrington's", "[measures]")
{
    const Template& made = small_template();
    const Points anatomy = anatomy_at_rest(made, made.rest);
    const auto part = [&](const std::string& name) {
        const auto found = std::find_if(made.anatomy_parts.begin(), made.anatomy_parts.end(),
                                        [&](const AnatomyPart& p) { return p.name == name; });
        REQUIRE(found != made.anatomy_parts.end());
        return Points(anatomy.middleRows(found->vertex_begin, found->vertex_end - found->vertex_begin));
    };
    // Landmarks by scanning vertices; the body is symmetric, so that the pelvic frame is turned about x alone.
    const Points hip = part("Left hip bone"), tibia = part("Left tibia");
    const double middle = 0.5 * (hip.col(1).minCoeff() + hip.col(1).maxCoeff());
    Eigen::RowVector3d asis(0, 0, -1e9), psis(0, 0, 1e9), malleolus(1e9, 0, 0);
    for (Eigen::Index v = 0; v < hip.rows(); ++v) {
        if (hip(v, 1) < middle) continue;
        if (hip(v, 2) > asis.z()) asis = hip.row(v);
        if (hip(v, 2) < psis.z()) psis = hip.row(v);
    }
    for (Eigen::Index v = 0; v < tibia.rows(); ++v)
        if (tibia(v, 1) < tibia.col(1).minCoeff() + 0.035 && tibia(v, 0) < malleolus.x()) malleolus = tibia.row(v);
    const double width = 2e3 * asis.x(), depth = 1e3 * std::hypot(asis.y() - psis.y(), asis.z() - psis.z()),
                 leg = 1e3 * (asis - malleolus).norm();
    const double tilt = std::atan2(asis.y() - psis.y(), asis.z() - psis.z());
    const double x = -0.24 * depth - 9.9, y = -0.16 * width - 0.04 * leg - 7.1, z = 0.28 * depth + 0.16 * width + 7.9;
    Body body = made.rest;
    for (const double side : {1.0, -1.0})
        body.joint_positions.row(made.skeleton.joint(side > 0 ? "left_thigh" : "right_thigh")) << 1e-3 * side * z,
            asis.y() + 1e-3 * (x * std::sin(tilt) + y * std::cos(tilt)),
            asis.z() + 1e-3 * (x * std::cos(tilt) - y * std::sin(tilt));
    const std::string name = "hip joints, distance from regression";
    CHECK(row(measured(body), name).value < 0.002);
    CHECK(row(measured(made.rest), name).value > 0.005);

    // The mean over bodies has a gate of its own.
    MeasuredBody near, far;
    near.measures = far.measures = {row(measured(made.rest), name)};
    near.measures[0].value = 0.005;
    far.measures[0].value = 0.018;
    std::vector<MeasuredBody> bodies(5, near);
    bodies.resize(10, far);
    CHECK(common_failures(bodies).empty());
    bodies.front() = far;
    bodies.push_back(far);
    CHECK_THAT(common_failures(bodies).front(), Contains("13.3 mm in the mean of 11 bodies, allowed 12.0 mm"));
    CHECK_THAT(failure_report(bodies), Contains("13.3 mm in the mean"));
    CHECK(common_failures({far}).empty());
}

TEST_CASE("Thickness of fat is the distance of the wraps", "[measures]")
{
    const Template& made = small_template();
    Body body = made.rest;
    const int n = made.num_wrap_vertices();
    const Points skin = body.volume_vertices.bottomRows(n), normals = vertex_normals(skin, made.wrap_triangles);
    body.volume_vertices.middleRows(n, n) = skin - 0.011 * normals;
    body.volume_vertices.topRows(n) = skin - 0.031 * normals;
    const MeasuredBody flat = measured(body);
    CHECK(row(measured(made.rest), "fat layer, mean").value == Approx(0.010));
    CHECK(row(flat, "fat layer, mean").value == Approx(0.011));
    for (const char* region : {"chest, front", "chest, back", "belly", "small of the back", "buttocks", "thigh, front",
                               "thigh, back", "calf", "upper arm, front", "upper arm, back"}) {
        CHECK(row(flat, std::string("fat, ") + region).value == Approx(0.011));
        CHECK(row(flat, std::string("muscle, ") + region).value == Approx(0.020));
    }
    double sum = 0.0;
    for (const auto& [name, sides] : {std::pair{"head and neck", 1},
                                      {"trunk", 1},
                                      {"upper arm", 2},
                                      {"forearm", 2},
                                      {"hand", 2},
                                      {"thigh", 2},
                                      {"shank", 2},
                                      {"foot", 2}})
        sum += sides * row(measured(made.rest), std::string(name) + ", share of mass").value;
    CHECK(sum == Approx(1.0));
}

TEST_CASE("Joints of a skin are measured without layers", "[measures]")
{
    const Template& made = small_template();
    Skin skin = made.rest;
    CHECK(measure_skin(made, skin, Person()).failures().empty());
    // As the fit of a T pose once gave them.
    const int left = made.skeleton.joint("left_upper_arm"), right = made.skeleton.joint("right_upper_arm");
    const double half = 0.5 * 0.166 * ProceduralParameters().stature_m;
    skin.joint_positions(left, 0) = half;
    skin.joint_positions(right, 0) = -half;
    const std::vector<std::string> failures = measure_skin(made, skin, Person()).failures();
    REQUIRE(failures.size() == 1);
    CHECK_THAT(failures[0], Contains("shoulder joints apart: 0.166, allowed 0.180 to"));
    skin.joint_positions(left, 1) += 0.02;
    CHECK(row(measure_skin(made, skin, Person()), "joints, left to right").value == Approx(0.02));
}

TEST_CASE("Ranges are those of a person's sex, of both where it is not known", "[measures]")
{
    const Spread female{0.224, 0.010}, male{0.237, 0.010};
    CHECK(MeasureTable(Person{0.0, 40}).range(female, male) == std::pair{0.224 - 0.03, 0.224 + 0.03});
    CHECK(MeasureTable(Person{1.0, 40}).range(female, male) == std::pair{0.237 - 0.03, 0.237 + 0.03});
    CHECK(MeasureTable(Person{0.5, 40}).range(female, male) == std::pair{0.224 - 0.03, 0.237 + 0.03});
    MeasureTable table(Person{1.0, 40});
    table.add({"a", "how", MeasureUnit::degree}, 1.0);
    table.add_gate({"b", "how", MeasureUnit::millimetre, "who"}, 0.0621, 0.0044, 0.0284);
    table.add_compared({"c", "how", MeasureUnit::number}, std::nan(""), 0.0, 1.0);
    CHECK_FALSE(table.measures()[0].outside());
    CHECK(table.measures()[1].failure() == "b: 62.1 mm, allowed 4.4 to 28.4 mm");
    CHECK(table.measures()[2].outside());
    MeasuredBody body;
    body.name = "x";
    body.measures = table.measures();
    CHECK(body.failures() == std::vector<std::string>{"b: 62.1 mm, allowed 4.4 to 28.4 mm"});
    CHECK_THAT(body_report(body, false), Contains("57.3 degrees") && Contains("OUTSIDE THE GATE") &&
                                             Contains("outside, no gate") && !Contains("how"));
    CHECK_THAT(measures_report({body}), Contains("how; who") && !Contains("mean"));
    CHECK_THAT(statistics_report({body, body}), Contains("2 bodies") && Contains("2!  how; who"));
}

TEST_CASE("A template without bones has the measures of its joints and layers alone", "[measures]")
{
    const Template tube = test::tube_template();
    const MeasuredBody body = measure_body(tube, tube.rest, Person());
    CHECK(std::none_of(body.measures.begin(), body.measures.end(),
                       [](const BodyMeasure& m) { return m.name.find("spinous") != std::string::npos; }));
    CHECK(row(body, "fat layer, mean").value > 0.0);
}
