// SPDX-License-Identifier: Apache-2.0
// Who is drawn, and how MakeHuman's body becomes that person.
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/people/body_sampling.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using Catch::Matchers::Contains;

TEST_CASE("Adults follow the published means and shares, and depend on seed and index alone", "[adults]")
{
    constexpr int count = 4000;
    for (const bool male : {false, true}) {
        const AdultStatistics& published = adult_statistics(male);
        double stature_sum = 0, stature_squares = 0;
        int obese = 0, severely_obese = 0, above = 0;
        for (int i = 0; i < count; ++i) {
            // Nearly uncut: 14 to 50.
            const Adult adult = sample_adult(5, 2 * i + male, 14.0, 50.0);
            REQUIRE(adult.male == male);
            stature_sum += adult.stature_m / count;
            stature_squares += adult.stature_m * adult.stature_m / count;
            obese += adult.bmi >= 30.0;
            severely_obese += adult.bmi >= 40.0;
            above += adult.bmi >= std::exp(published.log_bmi_mean());
            CHECK((adult.age_years >= 20.0 && adult.age_years <= 75.0));
        }
        CHECK(stature_sum == Approx(published.mean_stature_m).margin(0.005));
        CHECK(std::sqrt(stature_squares - stature_sum * stature_sum) ==
              Approx(published.stature_deviation_m).margin(0.004));
        CHECK(obese / double(count) == Approx(published.published_obese).margin(0.03));
        CHECK(severely_obese / double(count) == Approx(published.published_severely_obese).margin(0.03));
        CHECK(above / double(count) == Approx(0.5).margin(0.03));
    }
    const Adult a = sample_adult(7, 3, 17.0, 45.0), b = sample_adult(7, 3, 17.0, 45.0);
    CHECK(a.bmi == b.bmi);
    CHECK(a.bmi != sample_adult(8, 3, 17.0, 45.0).bmi);
    CHECK(a.stature_m != sample_adult(7, 5, 17.0, 45.0).stature_m);
    for (int i = 0; i < 300; ++i) {
        const double bmi = sample_adult(1, i, 20.0, 25.0).bmi;
        CHECK((bmi >= 20.0 && bmi <= 25.0));
    }
    CHECK_THROWS_AS(sample_adult(1, -1, 17.0, 45.0), InputError);
    CHECK_THROWS_WITH(sample_adult(1, 0, 30.0, 30.5), Contains("30.5"));
    BodySamplingOptions options;
    options.detail_spread = 2.0;
    CHECK_THROWS_WITH(options.check(), Contains("detail-spread: expected a number in [0, 0.5], got 2"));
}

TEST_CASE("MakeHuman's body takes the stature and the body mass index asked for", "[makehuman]")
{
    if (test::data_folder().empty()) return;
    const MakeHuman source(test::data_folder() + "/makehuman");
    const auto measure = [&](const MakeHumanParameters& p) {
        const ParametricSurface surface = source.evaluate(p);
        const double height = stature(surface.vertices);
        return std::make_pair(height,
                              body_density * enclosed_volume(surface.vertices, surface.triangles) / (height * height));
    };
    for (const bool male : {false, true})
        for (const double bmi : {17.0, 24.0, 33.0, 45.0}) {
            MakeHumanParameters wished;
            wished.muscle = male ? 0.8 : 0.3;
            wished.details.assign(makehuman_details().size(), 0.2);
            const Adult adult{male, 60.0, male ? 1.80 : 1.55, bmi};
            const MakeHumanParameters p =
                makehuman_parameters(source, adult, wished, usual_proportions(male ? 1.0 : 0.0));
            const auto [height, reached] = measure(p);
            CHECK(height == Approx(adult.stature_m).margin(0.0011));
            CHECK(reached == Approx(bmi).margin(0.06));
            CHECK(p.muscle <= wished.muscle);
            CHECK(p.age > 0.7);
        }
    // Details change who it is, not how tall and heavy.
    const MakeHumanParameters one = sample_parameters(source, 3, 4, {}), same = sample_parameters(source, 3, 4, {});
    CHECK(one.details == same.details);
    CHECK(one.details != sample_parameters(source, 3, 6, {}).details);
    MakeHumanParameters wrong;
    wrong.details = {0.1};
    CHECK_THROWS_WITH(wrong.check(), Contains("1 details"));
    wrong.details.assign(makehuman_details().size(), 0.0);
    wrong.details[2] = 1.5;
    CHECK_THROWS_WITH(wrong.check(), Contains(makehuman_details()[2]) && Contains("1.5"));
    wrong.details.clear();
    wrong.fullness = 4.0;
    CHECK_THROWS_WITH(wrong.check(), Contains("fullness is 4"));
}
