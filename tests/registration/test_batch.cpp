// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "ndg/registration/batch_report.h"
#include "ndg/registration/fit_part.h"
#include "ndg/scan/scan_simulation.h"
#include "registration/person.h"
#include "support/described.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <fstream>

using namespace ndg;

TEST_CASE("a batch's key knows all options and the examples")
{
    CHECK(test::undescribed_bytes<FitOptions>().empty());
    const std::string key = fit_key({}, {"template"});
    FitOptions other;
    other.nonrigid.tangential *= 1 + 1e-15;
    CHECK(fit_key(other, {"template"}) != key);
    CHECK(fit_key({}, {"template", "examples"}) != key);
}

TEST_CASE("a batch reports bad scans, goes on, and starts again where it was stopped", "[slow]")
{
    const test::TemporaryFolder folder;
    const SkinnedSurface& skin = test::template_skin();
    ScanSimulationOptions simulation;
    simulation.points = 10000;
    const SimulatedScan simulated = simulate_scan(skin, simulation, 1, 1);
    write_mesh(folder.file("a.ply"), simulated.scan.vertices, simulated.scan.triangles);
    std::ofstream(folder.file("b.obj")) << "v 0 0 nan\n";
    std::ofstream(folder.file("c.stl")).flush();
    const std::vector<std::string> files = scan_files({folder.path()});
    REQUIRE(files.size() == 3);
    FitOptions options;
    options.rounds = 1;
    options.articulated.samples = 600;
    options.nonrigid.iterations = 6;
    const BodyFitter fitter(test::skin_template(), options);
    BatchOptions batch;
    const auto never = [] { return false; };
    const PartStore store(folder.file("out.h5"), scan_parts, "key", false);
    CHECK_THROWS_AS(fit_batch(fitter, files, options, skin.triangles, batch, store, [] { return true; }), Interrupted);
    const auto entries = fit_batch(fitter, files, options, skin.triangles, batch, store, never);
    REQUIRE(entries.size() == 3);
    CHECK(entries[0].failure.empty());
    CHECK(entries[1].failure.find("b.obj") != std::string::npos);
    CHECK(entries[2].failure.find("c.stl") != std::string::npos);
    // From the part: the same numbers, its time included.
    const auto again = fit_batch(fitter, files, options, skin.triangles, batch, store, never);
    CHECK(again[0].fitted.report.seconds == entries[0].fitted.report.seconds);
    CHECK(again[0].fitted.body.skin_vertices == entries[0].fitted.body.skin_vertices);
    CHECK(batch_skins(again, false, [](const std::string&) { return std::make_pair(0.0, 30.0); }).bodies.size() == 1);
    CHECK(batch_poses(again, false).size() == 1);
    const TrueBody truth = {"a", simulated.posed_skin, simulated.posed_joints, skin.vertices, skin.joint_positions};
    const BatchReport report(again, {{truth}}, skin.triangles);
    CHECK(report.scans == 3);
    CHECK(report.fitted == 1);
    CHECK(report.passed == 1);
    CHECK(report.worst == "a");
    CHECK(report.errors.at("a").surface_mean < 0.002);
    CHECK(report.text(again).find("not passed: b, c") != std::string::npos);
    write_file(folder.file("report.json"), report.json(again));
    const ReportedFit reported = read_reported_fit(folder.file("report.json"), "");
    CHECK(reported.name == "a");
    CHECK(reported.file == folder.file("a.ply"));
    CHECK(reported.unit == LengthUnit::metre);
    CHECK_THROWS_AS(read_reported_fit(folder.file("report.json"), "b"), InputError);

    // A fit that misses the gate is worse than a good one, and is no body of the set.
    std::vector<BatchEntry> two = {again[0], again[0]};
    two[1].fitted.body.name = "missed";
    two[1].fitted.report.defects = {"too far"};
    CHECK(BatchReport(two, {}, skin.triangles).worst == "missed");
    const auto nobody = [](const std::string&) { return std::make_pair(0.5, 40.0); };
    CHECK(batch_skins(two, false, nobody).bodies.size() == 1);
    CHECK(batch_skins(two, true, nobody).bodies.size() == 2);
    CHECK_THROWS_AS(scan_files({folder.file("a.ply"), folder.file("a.ply")}), InputError);
}
