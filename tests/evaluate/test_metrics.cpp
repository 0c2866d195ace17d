// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/metrics.h"

#include "ndg/core/error.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// One prism: base triangle (0,0), (1,0), (0,1) at y = 0 (inner, the last three vertices) and y = 1 (outer, the first).
/// Rows 3-5 stand for the bone wrap, so they are put first in the vertex array.
Points unit_prism_vertices()
{
    Points vertices(6, 3);
    vertices << 0, 0, 0,  //
        0, 0, 1,          //
        1, 0, 0,          //
        0, 1, 0,          //
        0, 1, 1,          //
        1, 1, 0;
    return vertices;
}

Prisms unit_prism()
{
    Prisms prisms(1, 6);
    prisms << 3, 4, 5, 0, 1, 2;
    return prisms;
}

}  // namespace

TEST_CASE("A displaced vertex counts with its distance over the free vertices only")
{
    const Points rest = unit_prism_vertices();
    const BodyMetrics metrics(rest, unit_prism(), 3);
    Points prediction = rest;
    prediction.row(4) += Eigen::RowVector3d(0.003, 0, 0.004);  // 5 mm, one of three free vertices
    const SampleMetrics sample = metrics.evaluate(rest, prediction);
    CHECK(sample.position_error_mm == Approx(5.0 / 3.0));

    Points moved_bone_wrap = rest;
    moved_bone_wrap.row(0) += Eigen::RowVector3d(0.1, 0, 0);
    CHECK(metrics.evaluate(rest, moved_bone_wrap).position_error_mm == 0.0);
}

TEST_CASE("A prism stretched to k times its height has volume error (k - 1)^2")
{
    const Points rest = unit_prism_vertices();
    const BodyMetrics metrics(rest, unit_prism(), 3);
    for (const double k : {0.5, 1.0, 1.25, 3.0}) {
        Points deformed = rest;
        deformed.col(1) *= k;
        const SampleMetrics sample = metrics.evaluate(deformed, deformed);
        CHECK(sample.volume_error == Approx((k - 1) * (k - 1)).margin(1e-12));
        CHECK(sample.inverted_prisms == 0);
        CHECK(sample.position_error_mm == 0);
        CHECK(sample.gradient_error == 0);
    }
}

TEST_CASE("A mirrored prism is inverted and its volume error is four")
{
    const Points rest = unit_prism_vertices();
    const BodyMetrics metrics(rest, unit_prism(), 3);
    Points mirrored = rest;
    mirrored.col(1) *= -1;
    const SampleMetrics sample = metrics.evaluate(rest, mirrored);
    CHECK(sample.inverted_prisms == 1);
    CHECK(sample.volume_error == Approx(4.0));
    // Three free vertices, each moved by 2 m.
    CHECK(sample.position_error_mm == Approx(2000.0));
    // F - F_hat has the single entry 2.
    CHECK(sample.gradient_error == Approx(4.0 / 9.0));
}

TEST_CASE("A flat prism is not inverted")
{
    const Points rest = unit_prism_vertices();
    Points flat = rest;
    flat.col(1).setZero();
    const SampleMetrics sample = BodyMetrics(rest, unit_prism(), 3).evaluate(rest, flat);
    CHECK(sample.inverted_prisms == 0);
    CHECK(sample.volume_error == Approx(1.0));
}

TEST_CASE("Two affine deformations of a body differ in gradient by |F - F_hat|^2 / 9")
{
    const Template tube = test::tube_template();
    const Points& rest = tube.rest.volume_vertices;
    const BodyMetrics metrics(rest, tube.prisms, tube.num_wrap_vertices());
    Eigen::Matrix3d reference_gradient, predicted_gradient;
    reference_gradient << 1.1, 0.2, 0.0, -0.1, 0.9, 0.3, 0.05, 0.0, 1.2;
    predicted_gradient << 1.0, 0.0, 0.1, 0.2, 1.0, 0.0, 0.0, -0.1, 0.8;
    const Points reference = (rest * reference_gradient.transpose()).rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Points predicted = rest * predicted_gradient.transpose();
    const SampleMetrics sample = metrics.evaluate(reference, predicted);
    CHECK(sample.gradient_error == Approx((reference_gradient - predicted_gradient).squaredNorm() / 9.0));
    const double change = predicted_gradient.determinant() - 1.0;
    CHECK(sample.volume_error == Approx(change * change));
    CHECK(sample.inverted_prisms == 0);
}

TEST_CASE("A mirrored body has every prism inverted")
{
    const Template tube = test::tube_template();
    const BodyMetrics metrics(tube.rest.volume_vertices, tube.prisms, tube.num_wrap_vertices());
    Points mirrored = tube.rest.volume_vertices;
    mirrored.col(0) *= -1;
    CHECK(metrics.evaluate(mirrored, mirrored).inverted_prisms == tube.num_prisms());
    CHECK(metrics.evaluate(mirrored, mirrored).corner_inverted_prisms == tube.num_prisms());
    CHECK(metrics.evaluate(tube.rest.volume_vertices, tube.rest.volume_vertices).corner_inverted_prisms == 0);
}

TEST_CASE("One inverted prism of two is counted, and lies in the first bin of volume changes")
{
    const Points prism = unit_prism_vertices();
    Points rest(12, 3);  // both bone wraps first, as in bodies
    rest << prism.topRows(3), prism.topRows(3).rowwise() + Eigen::RowVector3d(5, 0, 0), prism.bottomRows(3),
        prism.bottomRows(3).rowwise() + Eigen::RowVector3d(5, 0, 0);
    Prisms prisms(2, 6);
    prisms << 6, 7, 8, 0, 1, 2, 9, 10, 11, 3, 4, 5;
    Points deformed = rest;
    deformed.middleRows(6, 3).col(1) *= -1.0;  // the first one is turned inside out
    deformed.bottomRows(3).col(1) *= 1.26;     // the second grows by 26 %
    const SampleMetrics sample = BodyMetrics(rest, prisms, 6).evaluate(rest, deformed);
    CHECK(sample.inverted_prisms == 1);
    CHECK(sample.corner_inverted_prisms == 1);
    CHECK(sample.volume_error == Approx((4.0 + 0.26 * 0.26) / 2));
    CHECK(sample.volume_changes[0] == 0.5);
    int bin = 0;
    while (std::abs(volume_bin_centre(bin) - 0.26) > 1.0 / volume_bins) ++bin;
    CHECK(sample.volume_changes[bin] == 0.5);
}

TEST_CASE("Means are arithmetic, figure by figure")
{
    const SampleMetrics mean = mean_metrics({{1, 2, 3, 5, 4}, {3, 6, 0, 9, 8}});
    CHECK(mean.position_error_mm == 2);
    CHECK(mean.gradient_error == 4);
    CHECK(mean.inverted_prisms == 1.5);
    CHECK(mean.corner_inverted_prisms == 7);
    CHECK(mean.volume_error == 6);
    CHECK_THROWS_AS(mean_metrics({}), Error);
}

TEST_CASE("Bodies that cannot be measured are refused")
{
    const Points rest = unit_prism_vertices();
    Points flat = rest;
    flat.col(1).setZero();
    CHECK_THROWS_AS(BodyMetrics(flat, unit_prism(), 3), InputError);
    Prisms out_of_range = unit_prism();
    out_of_range(0, 2) = 6;
    CHECK_THROWS_AS(BodyMetrics(rest, out_of_range, 3), InputError);
    CHECK_THROWS_AS(BodyMetrics(rest, unit_prism(), 6), InputError);
    CHECK_THROWS_AS(BodyMetrics(rest, unit_prism(), 3).evaluate(rest, rest.topRows(5)), Error);
}
