// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/retarget_report.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <cmath>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

constexpr double degree = M_PI / 180.0;

}  // namespace

TEST_CASE("reports name the worst clip and are JSON that says what was done")
{
    std::vector<RetargetReport> reports(3);
    for (int k = 0; k < 3; ++k) {
        reports[k].clip_name = std::vector<std::string>{"a", "танец", "c"}[k];
        reports[k].mean_error = std::vector<double>{0.001, 0.009, 0.004}[k];
        reports[k].num_frames = 100;
        reports[k].joint_errors = {{"head", 0.001, 0.002, 0.003, 0.004}};
    }
    reports[0].limits_checked = true;
    reports[0].limit_hits = {{"left_shin", 3, 10 * degree, 1}};
    reports[0].num_violating_frames = 90;
    reports[0].num_far_frames = 8;
    reports[2].limits_checked = true;
    reports[2].limit_hits = {{"left_shin", 20, 15 * degree, 2}, {"head", 70, 30 * degree, 5}};
    reports[1].segment_errors = {{"trunk", 3 * degree, 4 * degree}, {"left_thigh", 21 * degree, 25 * degree}};
    const RetargetSummary summary = summarise(reports);
    CHECK(summary.median_error == Approx(0.004));
    CHECK(summary.worst_clip == "танец");
    const std::string table = report_table(reports);
    CHECK(summary.num_checked_frames == 200);
    CHECK(summary.limit_hits[0].joint == "head");
    CHECK(summary.limit_hits[1].num_far_frames == 3);
    CHECK_THAT(table, Contains("45.0 % of the frames have a joint outside its published range, 4.0 % one more than 10 "
                               "degrees: head 2.5 %, left_shin 1.5 %"));
    CHECK_THAT(table, Contains("21.0 degrees in the mean at worst (left_thigh of танец)"));
    CHECK_THAT(table, Contains("worst 9.00 mm (танец)") && Contains("4.00 mm (median"));
    const nlohmann::json json = nlohmann::json::parse(report_json(reports));
    CHECK(json["format"] == "ndg-motion-report");
    CHECK(json["worst_clip"] == "танец");
    CHECK(json["reports"].size() == 3);
    CHECK(json["reports"][1]["joints"][0]["max_mm"] == Approx(2.0));
    CHECK(json["reports"][0]["limit_hits"][0]["frames"] == 3);
    CHECK(json["reports"][0]["limit_hits"][0]["far_frames"] == 1);
    CHECK(json["reports"][1]["segments"][1]["mean_degrees"] == Approx(21.0));
    CHECK_FALSE(json["reports"][1].contains("limit_hits"));
    reports[1].clip_name = "caf\xe9";  // a file name of another encoding
    CHECK_NOTHROW(nlohmann::json::parse(report_json(reports)));
}
