// SPDX-License-Identifier: Apache-2.0
// Scans as they come: in pieces, clothed, with a floor, in other poses and meshes; each is fitted where it shows skin,
// or refused in a sentence.
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/registration/fit_report.h"
#include "ndg/scan/scan_simulation.h"
#include "registration/makehuman_people.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

struct DifficultScan {
    ScanFault fault;
    int person;
    std::string defect;   ///< part of the sentence that refuses it; empty: it passes
    std::string warning;  ///< part of a warning; empty: there is none
    std::string note;     ///< part of what is said to have been done to it
    LengthUnit unit = LengthUnit::metre;
    Axis up = Axis::y;
};

const std::vector<DifficultScan>& difficult_scans()
{
    static const std::vector<DifficultScan> scans = {
        {ScanFault::pieces, 0, "", "", "wound inside out"},
        {ScanFault::clothes, 1, "", "left thigh, right thigh, left shin, right shin, left foot, right foot", ""},
        {ScanFault::floor, 2, "", "", "a floor under the feet was cut away"},
        {ScanFault::t_pose, 3, "", "", ""},
        {ScanFault::arms_raised, 0, "", "", ""},
        {ScanFault::large_triangles, 1, "", "", ""},
        {ScanFault::hair, 2, "", "hair or a hat on the head", ""},
        {ScanFault::fists, 3, "", "left hand, right hand not open", ""},
        {ScanFault::no_feet, 0, "too little of left foot", "", ""},
        {ScanFault::child, 1, "is a child's", "", ""},
        {ScanFault::none, 2, "", "", "", LengthUnit::millimetre, Axis::z},
        {ScanFault::mirrored, 3, "", "", "wound inside out"}};
    return scans;
}

/// Four people of proportions and shapes that are not drawn for the examples.
SkinnedSurface person(const MakeHuman& source, const std::string& folder, int index)
{
    const auto parameters = [](double sex, double age, double weight, double muscle, double height,
                               double proportions) {
        MakeHumanParameters p;
        p.sex = sex;
        p.age = age;
        p.weight = weight;
        p.muscle = muscle;
        p.height = height;
        p.proportions = proportions;
        return p;
    };
    switch (index) {
        case 0:
            return test::makehuman_person(source, folder, parameters(0.0, 0.6, 0.55, 0.4, 0.45, 0.95),
                                          {{"hip/hip-trans-backward", 0.6}, {"torso/torso-scale-vert-incr", 0.4}});
        case 1:
            return test::makehuman_person(source, folder, parameters(1.0, 0.55, 0.6, 0.75, 0.6, 0.9),
                                          {{"torso/torso-scale-vert-decr", 0.4}, {"neck/neck-scale-depth-incr", 0.5}});
        case 2:
            return test::makehuman_person(source, folder, parameters(1.0, 0.75, 0.75, 0.4, 0.5, 0.1),
                                          {{"stomach/stomach-navel-out", 0.5}, {"torso/torso-trans-backward", 0.4}});
        default:
            return test::makehuman_person(source, folder, parameters(0.0, 0.52, 0.4, 0.55, 0.55, 0.1),
                                          {{"legs/l-lowerleg-scale-horiz-incr", 0.4},
                                           {"legs/r-lowerleg-scale-horiz-incr", 0.4},
                                           {"hip/hip-scale-vert-incr", 0.4}});
    }
}

/// Mean distance of the fitted skin to the true one where the scan shows skin, m, weighted by area.
double error_on_skin(const Points& fitted, const Triangles& triangles, const Points& truth,
                     const Triangles& true_triangles, const std::vector<char>& covered,
                     const std::vector<char>& left_out)
{
    const TriangleTree tree(truth, true_triangles);
    const Eigen::VectorXd areas = vertex_areas(fitted, triangles);
    double sum = 0.0, area = 0.0;
    for (Eigen::Index v = 0; v < fitted.rows(); ++v) {
        const ClosestPoint closest = tree.closest(fitted.row(v).transpose());
        Eigen::Index corner = 0;
        closest.barycentric.maxCoeff(&corner);
        if (left_out[v] || covered[true_triangles(closest.triangle_idx, corner)]) continue;
        sum += areas[v] * closest.distance;
        area += areas[v];
    }
    return sum / area;
}

std::string joined(const std::vector<std::string>& sentences)
{
    std::string all;
    for (const std::string& sentence : sentences) all += sentence + "; ";
    return all;
}

}  // namespace

TEST_CASE("difficult scans are fitted where they show skin, or refused in a sentence", "[slow]")
{
    if (test::data_folder().empty()) return;
    // Once for all sections.
    static const std::string folder = test::data_folder() + "/makehuman";
    static const MakeHuman source(folder);
    static const Template body_template = test::makehuman_skin_template(source, folder);
    static const BodyFitter fitter = [] {
        std::vector<JointExample> examples;
        for (const Skin& example : body_template.examples) {
            examples.push_back({example.skin_vertices, example.joint_positions});
        }
        return BodyFitter(body_template, FitOptions{}, examples);
    }();
    const std::vector<SkinSegment> segments = skin_segments(body_template.skin_weights);
    const auto shoulders = [](const Points& joints) {
        const Skeleton& skeleton = standard_skeleton();
        return (joints.row(skeleton.joint("left_upper_arm")) - joints.row(skeleton.joint("right_upper_arm"))).norm();
    };

    for (const DifficultScan& scan : difficult_scans()) {
        const std::string name = to_name(scan.fault);
        DYNAMIC_SECTION(name)
        {
            ScanSimulationOptions options;
            options.fault = scan.fault;
            const SimulatedScan simulated = simulate_scan(person(source, folder, scan.person), options, 5, scan.person);
            const Points file = simulated.scan.vertices * rotation_to_y_up(scan.up) / metres_of_unit(scan.unit);
            const FittedBody fitted = fitter.fit(name, prepare_scan(name, file, simulated.scan.triangles, {}));
            const FitReport& report = fitted.report;
            INFO(report_line(report));
            std::vector<char> left_out(segments.size(), 0);
            for (std::size_t v = 0; v < segments.size(); ++v) {
                left_out[v] = scan.fault == ScanFault::fists && pair_of(segments[v]) == SegmentPair::hands;
            }
            const double error = error_on_skin(fitted.posed_skin, body_template.skin_triangles, simulated.posed_skin,
                                               simulated.person.triangles, simulated.covered, left_out);
            INFO("mean distance to the true skin " << 1e3 * error << " mm");
            if (scan.defect.empty()) {
                CHECK(report.defects.empty());
                CHECK(error < 0.0012);
                const double true_stature =
                    simulated.person.vertices.col(1).maxCoeff() - simulated.person.vertices.col(1).minCoeff();
                INFO("stature " << report.stature << ", truly " << true_stature);
                CHECK(std::abs(report.stature - true_stature) < 0.02);
                const double true_shoulders = shoulders(simulated.person.joint_positions);
                INFO("shoulder joints " << report.shoulder_breadth << " m apart, truly " << true_shoulders);
                CHECK(std::abs(report.shoulder_breadth - true_shoulders) < 0.03);
            } else {
                REQUIRE(!report.defects.empty());
                CHECK(report.defects.front().find(scan.defect) != std::string::npos);
            }
            if (scan.warning.empty()) {
                CHECK((report.warnings.empty() || !scan.defect.empty()));
            } else {
                CHECK(joined(report.warnings).find(scan.warning) != std::string::npos);
            }
            CHECK(joined(report.notes).find(scan.note) != std::string::npos);
            CHECK(report.unit == to_name(scan.unit));
            CHECK(report.up == to_name(scan.up));
            CHECK(report.flipped_triangles < 8);
        }
    }

    // Bodies of other topologies, as other programs make them.
    const double edge_lengths[] = {0.007, 0.01, 0.014};
    for (int i = 0; i < 3; ++i) {
        DYNAMIC_SECTION("other topology " << i)
        {
            Triangles triangles;
            const Points vertices =
                test::remeshed_and_smoothed(person(source, folder, i), edge_lengths[i], 2, triangles);
            const FittedBody fitted =
                fitter.fit("other topology", prepare_scan("other topology", vertices, triangles, {}));
            INFO(report_line(fitted.report));
            const std::vector<char> none(vertices.rows(), 0), all(fitted.posed_skin.rows(), 0);
            const double error =
                error_on_skin(fitted.posed_skin, body_template.skin_triangles, vertices, triangles, none, all);
            INFO("edges of " << edge_lengths[i] << " m: mean distance " << 1e3 * error << " mm");
            CHECK(fitted.report.defects.empty());
            CHECK(fitted.report.warnings.empty());
            CHECK(error < 0.0008);
            CHECK(fitted.report.scan_to_skin_mean < 0.0008);
        }
    }
}
