// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/error_pictures.h"

#include "ndg/core/error.h"
#include "scene/shapes.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>

using namespace ndg;

namespace {

struct Files {
    Template tube = test::tube_template();
    DeformationSet reference, prediction;
    std::vector<SamplePair> pairs = {{0, 0}, {0, 1}, {0, 2}, {0, 3}};
    int num_wrap = tube.num_wrap_vertices();

    Files()
    {
        reference.method = "FEM";
        prediction.method = "NDG";
        const double skin_mm[] = {2, 8, 4, 100};
        for (int i = 0; i < 4; ++i) {
            Points volume = tube.rest.volume_vertices;
            reference.add(pairs[i], i == 0 ? "train" : "test", volume);
            volume.col(1).tail(num_wrap).array() += 1e-3 * skin_mm[i];
            volume(num_wrap, 0) += 0.020;  // one muscle vertex by 20 mm
            prediction.add(pairs[i], i == 0 ? "train" : "test", volume);
        }
        reference.statistics["converged"] = {1, 1, 1, 0};
    }
};

}  // namespace

TEST_CASE_METHOD(Files, "Errors are means of skin and muscle over the converged samples of the split")
{
    const Eigen::VectorXd errors = mean_vertex_errors(tube, reference, prediction, "test");
    REQUIRE(errors.size() == num_wrap);
    CHECK(1e3 * errors[1] == Approx(3.0).epsilon(1e-4));   // half of (8 + 4) / 2
    CHECK(1e3 * errors[0] == Approx(13.0).epsilon(1e-4));  // and half of 20
    CHECK_THROWS_AS(mean_vertex_errors(tube, reference, prediction, "validation"), InputError);
    DeformationSet incomplete = prediction;
    incomplete.pairs[2] = {5, 5};
    CHECK_THROWS_WITH(mean_vertex_errors(tube, reference, incomplete, "test"), Catch::Contains("body 0 in pose 2"));
}

TEST_CASE_METHOD(Files, "The worst samples come first, and those without a converged reference not at all")
{
    CHECK(worst_samples(tube, reference, prediction, "test", 5) == std::vector<SamplePair>{{0, 1}, {0, 2}});
    CHECK(worst_samples(tube, reference, prediction, "test", 1) == std::vector<SamplePair>{{0, 1}});
}

TEST_CASE_METHOD(Files, "A picture of errors is red where they are large and has a column a prediction")
{
    PictureSettings settings;
    settings.height = 96;
    settings.samples_per_axis = 1;
    const auto redness = [](const Image& image) {
        long red = 0;
        for (const Pixel& pixel : image.pixels) red += std::max(0, int(pixel[0]) - int(pixel[2]) - 20);
        return red;
    };
    const Image coarse = errors_picture(tube, {reference, prediction}, "test", 1000.0, settings);
    const Image fine = errors_picture(tube, {reference, prediction}, "test", 3.0, settings);
    CHECK(redness(fine) > 10 * redness(coarse) + 1000);
    const Image twice = errors_picture(tube, {reference, prediction, prediction}, "test", 3.0, settings);
    CHECK(redness(twice) == Approx(2.0 * double(redness(fine))).epsilon(0.02));
    CHECK_THROWS_AS(errors_picture(tube, {reference}, "test", 3.0, settings), InputError);
}
