// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/tables.h"

#include "ndg/core/error.h"
#include "ndg/evaluate/report.h"
#include "support/h5_damage.h"
#include "support/support.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

using namespace ndg;
using nlohmann::json;

namespace {

struct Fixture {
    Template tube = test::tube_template();
    BodySet bodies;
    std::vector<SamplePair> test_pairs = {{1, 4}, {0, 2}, {1, 5}};

    Fixture()
    {
        for (int b = 0; b < 2; ++b) {
            bodies.bodies.push_back(tube.rest);
            bodies.bodies.back().volume_vertices *= 1.0 + 0.1 * b;
        }
    }

    /// Deformed vertices of a pair: the body moved by a distance that depends on the pose, plus `offset` metres in x.
    Points deformed(const SamplePair& pair, double offset) const
    {
        Points points = bodies.bodies[std::size_t(pair.body_idx)].volume_vertices;
        points.col(1).array() += 0.25 * pair.pose_idx;
        points.col(0).array() += offset;
        return points;
    }

    NamedDeformations file(const std::string& method, double offset) const
    {
        NamedDeformations result{method + ".h5", {}};
        result.set.method = method;
        result.set.num_volume_vertices = tube.num_volume_vertices();
        result.set.add({0, 0}, "train", deformed({0, 0}, offset));
        // Stored in another order than the split lists them.
        for (auto pair = test_pairs.rbegin(); pair != test_pairs.rend(); ++pair)
            result.set.add(*pair, "test", deformed(*pair, offset));
        result.set.statistics["converged"] = {1, 1, 0, 1};
        return result;
    }

    std::vector<MethodMetrics> rows(const std::vector<NamedDeformations>& predictions) const
    {
        return evaluate_methods(tube, bodies, test_pairs, "test", file("FEM", 0.0), predictions);
    }

    Report report() const
    {
        Report report;
        report.split = "test";
        report.rows = rows({file("NDG", 0.001), file("Gradient Skinning", 0.002), file("LBS", 0.004)});
        report.counts = count_data(tube, bodies, 6, {test_pairs}, file("FEM", 0.0), "residual below 1e-3 N");
        report.seconds_json = R"({"simulate-fem": 12.5, "train": 3})";
        report.licences = {"A & B, CC0"};
        return report;
    }
};

std::string content(const std::string& path)
{
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

}  // namespace

TEST_CASE_METHOD(Fixture, "Rows come in the order given and samples are matched by pair")
{
    const std::vector<MethodMetrics> table = rows({file("NDG", 0.001), file("Other", 0.1), file("LBS", 0.004)});
    std::vector<std::string> methods;
    for (const MethodMetrics& method : table) methods.push_back(method.method);
    CHECK(methods == std::vector<std::string>{"FEM", "NDG", "Other", "LBS"});
    CHECK(table[0].mean.position_error_mm == 0);
    CHECK(table[0].mean.gradient_error == 0);
    // A shift by 1 mm is 1 mm in every sample; samples are float32. A wrong match would give at least 250 mm.
    for (const SampleMetrics& sample : table[1].samples) CHECK(sample.position_error_mm == Approx(1.0).epsilon(1e-3));
    CHECK(table[3].mean.position_error_mm == Approx(4.0).epsilon(1e-3));
    // Shifts leave gradients and volumes alone, up to float32 storage.
    CHECK(table[3].mean.gradient_error < 1e-8);
    CHECK(table[3].mean.volume_error < 1e-8);
}

TEST_CASE_METHOD(Fixture, "What does not fit together is an input error that names it")
{
    NamedDeformations incomplete = file("NDG", 0.0);
    incomplete.set.pairs.back() = {0, 5};
    CHECK_THROWS_WITH(rows({incomplete}), Catch::Contains("NDG.h5") && Catch::Contains("body 1 in pose 4"));
    CHECK_THROWS_AS(rows({incomplete}), InputError);

    NamedDeformations doubled = file("NDG", 0.0);
    doubled.set.add({1, 4}, "test", deformed({1, 4}, 0.0));
    CHECK_THROWS_WITH(rows({doubled}), Catch::Contains("twice"));

    NamedDeformations leaked = file("NDG", 0.0);
    leaked.set.pair_splits.back() = "train";
    CHECK_THROWS_WITH(rows({leaked}), Catch::Contains("split train"));

    NamedDeformations other_template = file("NDG", 0.0);
    other_template.set.num_volume_vertices += 3;
    CHECK_THROWS_AS(rows({other_template}), InputError);

    CHECK_THROWS_AS(rows({file("NDG", 0.0), file("NDG", 0.1)}), InputError);
    NamedDeformations otherwise_posed = file("NDG", 0.0);
    otherwise_posed.set.posing.bone_wrap = BoneWrap::lbs;
    CHECK_THROWS_WITH(rows({otherwise_posed}),
                      Catch::Contains("bone-wrap lbs") && Catch::Contains("FEM.h5 with rigid"));
    CHECK_THROWS_AS(rows({file("FEM", 0.0)}), InputError);
    CHECK_THROWS_AS(evaluate_methods(tube, bodies, {}, "test", file("FEM", 0.0), {}), InputError);
    CHECK_THROWS_AS(evaluate_methods(tube, bodies, {{2, 4}}, "test", file("FEM", 0.0), {}), InputError);
}

TEST_CASE_METHOD(Fixture, "Samples without a converged reference are left out of every mean alike and counted")
{
    NamedDeformations reference = file("FEM", 0.0);
    reference.set.statistics["converged"] = {1, 1, 1, 1};
    CHECK(compared_pairs(test_pairs, "test", reference).pairs == test_pairs);
    // Stored are train (0, 0), then test (1, 5), (0, 2), (1, 4). The prediction of (1, 5) is far off.
    reference.set.statistics["converged"] = {1, 0, 1, 1};
    NamedDeformations prediction = file("NDG", 0.001);
    Points far = deformed({1, 5}, 100.0);
    Eigen::Map<RowMatrixF>(prediction.set.vertices[1].data(), far.rows(), 3) = far.cast<float>();
    const ComparedPairs compared = compared_pairs(test_pairs, "test", reference);
    CHECK(compared.unconverged == 1);
    CHECK(compared.failed == 0);
    CHECK(compared.pairs == std::vector<SamplePair>{{1, 4}, {0, 2}});
    const auto table = evaluate_methods(tube, bodies, compared.pairs, "test", reference, {prediction});
    CHECK(table[1].samples.size() == 2);
    CHECK(table[1].mean.position_error_mm == Approx(1.0).epsilon(1e-3));

    const std::vector<SamplePair> more = {{1, 4}, {0, 2}, {1, 5}, {0, 9}};
    CHECK_THROWS_WITH(compared_pairs(more, "test", reference),
                      Catch::Contains("FEM.h5") && Catch::Contains("body 0 in pose 9"));
    reference.set.failures = {{{0, 9}, "test", "the elements turned over"}};
    CHECK(compared_pairs(more, "test", reference).failed == 1);
    CHECK(compared_pairs(more, "test", reference).pairs == compared.pairs);
    const TableCounts counts = count_data(tube, bodies, 10, compared_pairs(more, "test", reference), reference, "");
    CHECK(counts.evaluated_samples == 2);
    CHECK(counts.unconverged_samples == 1);
    CHECK(counts.failed_samples == 1);

    reference.set.statistics["converged"] = {1, 0, 0, 0};
    CHECK_THROWS_AS(compared_pairs(test_pairs, "test", reference), InputError);
}

TEST_CASE_METHOD(Fixture, "A file that is damaged is an input error from inside the parallel loop too")
{
    const test::TemporaryFolder folder;
    write_deformations(folder.file("fem.h5"), file("FEM", 0.0).set, test::example_provenance());
    const NamedDeformations reference{folder.file("fem.h5"), open_deformations(folder.file("fem.h5"))};
    test::run_python("f = h5py.File('" + folder.file("fem.h5") +
                     "', 'r+')\nf['deformations/vertices'][2, 5, 1] = np.nan\n");
    CHECK_THROWS_AS(evaluate_methods(tube, bodies, test_pairs, "test", reference, {file("NDG", 0.001)}), InputError);
}

TEST_CASE_METHOD(Fixture, "Counts say what the table was made from")
{
    const TableCounts counts = count_data(tube, bodies, 6, {test_pairs}, file("FEM", 0.0), "criterion");
    CHECK(counts.bodies == 2);
    CHECK(counts.poses == 6);
    CHECK(counts.samples == 4);
    CHECK(counts.evaluated_samples == 3);
    CHECK(counts.evaluated_bodies == 2);
    CHECK(counts.evaluated_poses == 3);
    CHECK(counts.fem_converged_share == 0.75);
    CHECK(counts.invalid_rest_prisms == 0);

    NamedDeformations unknown = file("FEM", 0.0);
    unknown.set.statistics.clear();
    CHECK_THROWS_AS(count_data(tube, bodies, 6, {test_pairs}, unknown, ""), InputError);

    BodySet broken = bodies;
    broken.bodies[0].volume_vertices.col(0) *= -1;
    CHECK(count_data(tube, broken, 6, {test_pairs}, file("FEM", 0.0), "").invalid_rest_prisms == tube.num_prisms());
}

TEST_CASE_METHOD(Fixture, "The JSON tables hold exactly the agreed keys")
{
    const json tables = json::parse(tables_json(report()));
    std::vector<std::string> keys;
    for (const auto& [key, value] : tables.items()) keys.push_back(key);
    CHECK(keys == std::vector<std::string>{"command", "commit", "counts", "seconds", "spread", "table1"});
    REQUIRE(tables["table1"].size() == 4);
    for (const auto& [method, figures] : tables["table1"].items()) {
        INFO(method);
        std::vector<std::string> names;
        for (const auto& [name, value] : figures.items()) {
            names.push_back(name);
            CHECK(value.is_number());
        }
        CHECK(names == std::vector<std::string>{"E_corner", "E_grad_e3", "E_inv", "E_pos_mm", "E_vol_e3"});
    }
    CHECK(tables["table1"]["LBS"]["E_pos_mm"].get<double>() == Approx(4.0).epsilon(1e-3));
    const json& counts = tables["counts"];
    for (const char* name : {"bodies", "poses", "samples", "prisms", "volume_vertices", "test_samples", "test_bodies",
                             "test_poses", "fem_converged_share", "invalid_rest_prisms", "train_samples"}) {
        INFO(name);
        CHECK(counts[name].is_number());
    }
    CHECK(counts["test_samples"] == 3);
    CHECK(counts["train_samples"] == 1);
    CHECK(counts["prisms"] == tube.num_prisms());
    CHECK(counts["fem_convergence_criterion"] == "residual below 1e-3 N");
    CHECK(tables["seconds"]["simulate-fem"] == 12.5);
    // Row order survives in the text.
    const std::string text = tables_json(report());
    CHECK(text.find("\"FEM\"") < text.find("\"NDG\""));
    CHECK(text.find("\"NDG\"") < text.find("\"Gradient Skinning\""));
    CHECK(text.find("\"Gradient Skinning\"") < text.find("\"LBS\""));
}

TEST_CASE_METHOD(Fixture, "Gradient and volume errors are reported in thousandths")
{
    Report small = report();
    small.rows[1].mean = {2.5, 0.0011, 9, 11, 0.00375};
    const json figures = json::parse(tables_json(small))["table1"]["NDG"];
    CHECK(figures["E_pos_mm"] == 2.5);
    CHECK(figures["E_grad_e3"].get<double>() == Approx(1.1));
    CHECK(figures["E_inv"] == 9.0);
    CHECK(figures["E_vol_e3"].get<double>() == Approx(3.75));
    // The paper's figures stand in brackets, and ratios beside the paper's ratios.
    small.rows[3].mean = {10.0, 0.0022, 18, 11, 0.015};
    const std::string markdown = results_markdown(small);
    CHECK_THAT(markdown, Catch::Contains("| NDG | 2.500 (3.19) | 1.100 (1.11) | 9.00 (9.22) | 11.00 | 3.750 (3.75) |"));
    CHECK_THAT(markdown, Catch::Contains("| LBS | 4.00 (2.37) | 2.00 (13.55) | 2.00 (18.18) | 4.00 (10.85) |"));
    CHECK_THAT(markdown, Catch::Contains("as the paper prints it"));
}

TEST_CASE_METHOD(Fixture, "Tables 2 and 3 are taken over, Table 4 has NDG and its variants")
{
    const test::TemporaryFolder folder;
    Report full = report();
    full.variants = {full.rows[3]};
    full.variants[0].method = "NDG no rotation";
    full.beyond_paper = {full.rows[2]};
    full.unseen_path = folder.file("unseen.json");
    full.protrusion_path = folder.file("protrusion.json");
    std::ofstream(full.unseen_path) << tables_json(report());
    std::ofstream(full.protrusion_path) << R"({"table3": {"NDG": {"intersecting_frames": 5.0, "protruding_frames": 0.0,
        "protrusion_mm": 0.0, "max_protrusion_mm": 0.0, "frames": 60, "deepest": ""}},
        "counts": {"table3_pairs": 100, "table3_colliding_pairs": 40, "table3_bodies": 4,
        "table3_bodies_intersecting_at_rest": 2, "table3_bodies_protruding_at_rest": 0}})";
    const json tables = json::parse(tables_json(full));
    CHECK(tables["table2"] == json::parse(tables_json(report()))["table1"]);
    CHECK(tables["table3"]["NDG"]["intersecting_frames"] == 5.0);
    CHECK(tables["counts"]["table3_colliding_pairs"] == 40);
    CHECK(tables["counts"]["table2_test_samples"] == 3);
    CHECK(tables["table4"].size() == 2);
    CHECK(tables["table4"]["NDG"] == tables["table1"]["NDG"]);
    CHECK(tables["beyond_paper"].size() == 1);
    CHECK_THAT(results_markdown(full), Catch::Contains("100 pairs of body and pose, 40 of them left out") &&
                                           Catch::Contains("| SKEL (the paper's) | 100.0 | 100.0 | 4.1 |"));
    std::ofstream(full.protrusion_path) << "{}";
    CHECK_THROWS_WITH(tables_json(full), Catch::Contains("protrusion.json has no table3"));
}

TEST_CASE_METHOD(Fixture, "Spreads are standard deviations of the means of bodies and of poses")
{
    Report spread = report();
    MethodMetrics& row = spread.rows[1];
    row.pairs = {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
    row.samples = {{1, 0, 0, 0, 0}, {3, 0, 0, 0, 0}, {5, 0, 0, 0, 0}, {7, 0, 0, 0, 0}};
    const json found = json::parse(tables_json(spread))["spread"]["NDG"];
    CHECK(found["E_pos_mm_over_bodies"].get<double>() == Approx(4 / std::sqrt(2.0)));  // means 2 and 6
    CHECK(found["E_pos_mm_over_poses"].get<double>() == Approx(2 / std::sqrt(2.0)));   // means 3 and 5
    CHECK(found["E_pos_mm_largest"] == 7.0);
}

TEST_CASE_METHOD(Fixture, "The report folder holds the tables, the text and a page that shows its pictures")
{
    const test::TemporaryFolder folder;
    std::filesystem::create_directories(folder.file("report"));
    std::ofstream(folder.file("report/layers.png")) << "picture";
    std::ofstream(folder.file("report/notes.txt")) << "text";
    write_report(folder.file("report/tables.json"), report());
    CHECK(content(folder.file("report/tables.json")) == tables_json(report()));
    CHECK(content(folder.file("report/results.md")) == results_markdown(report()));
    const std::string page = content(folder.file("report/index.html"));
    CHECK_THAT(page, Catch::Contains("<img src=\"data:image/png;base64,cGljdHVyZQ==\" alt=\"layers.png\""));
    CHECK_THAT(page, Catch::Contains("<svg"));
    CHECK_THAT(page, !Catch::Contains("notes.txt"));
    CHECK_THAT(page, Catch::Contains("A &amp; B, CC0"));
    CHECK_THAT(page, !Catch::Contains("http"));
    std::size_t files = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.file("report"))) {
        CHECK(entry.path().extension() != ".tmp");
        ++files;
    }
    CHECK(files == 5);
}

TEST_CASE("Stage times must be an object of numbers")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("seconds.json");
    std::ofstream(path) << R"({"a": 1.5})";
    CHECK(json::parse(read_seconds(path)) == json{{"a", 1.5}});
    for (const char* wrong : {"", "[1]", R"({"a": "long"})", R"({"a": )"}) {
        std::ofstream(path) << wrong;
        CHECK_THROWS_AS(read_seconds(path), InputError);
    }
    CHECK_THROWS_AS(read_seconds(folder.file("missing.json")), InputError);
}

TEST_CASE_METHOD(Fixture, "A stored reference states its convergence criterion by its configuration")
{
    const test::TemporaryFolder folder;
    DeformationSet set = file("FEM", 0.0).set;
    Provenance provenance;
    provenance.tool = "simulate-fem";
    provenance.config_json = R"({"tolerance": 0.001})";
    write_deformations(folder.file("fem.h5"), set, provenance);
    CHECK_THAT(convergence_criterion(folder.file("fem.h5")), Catch::Contains("0.001"));
    provenance.config_json = R"({"simulate-fem": {"relative_tolerance": 2e-05, "absolute_tolerance": 1e-06}})";
    write_deformations(folder.file("fem.h5"), set, provenance);
    CHECK_THAT(convergence_criterion(folder.file("fem.h5")),
               Catch::Contains("at most 2e-05 of") && Catch::Contains("at most 1e-06 N"));
    // What is evaluated after reading back is what was stored.
    NamedDeformations stored{"fem.h5", open_deformations(folder.file("fem.h5"), tube.num_volume_vertices())};
    const auto table = evaluate_methods(tube, bodies, test_pairs, "test", stored, {file("NDG", 0.001)});
    CHECK(table[1].mean.position_error_mm == Approx(1.0).epsilon(1e-3));
    CHECK_THROWS_AS(convergence_criterion(folder.file("missing.h5")), InputError);
}
