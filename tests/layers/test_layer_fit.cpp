// SPDX-License-Identifier: Apache-2.0
// Layers with free skin vertices, and batches of them.
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/layers/bone_carrying.h"
#include "ndg/layers/layer_batch.h"
#include "ndg/wraps/prism_barrier.h"
#include "support/described.h"
#include "support/support.h"

#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// Three nested open tubes about y.
LayerSurfaces tubes(int rings, int segments, Triangles& triangles)
{
    LayerSurfaces surfaces;
    surfaces.skin.resize(rings * segments, 3);
    triangles.resize(2 * (rings - 1) * segments, 3);
    int t = 0;
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < segments; ++k) {
            const double angle = 2.0 * M_PI * k / segments;
            const int v = r * segments + k, next = r * segments + (k + 1) % segments;
            surfaces.skin.row(v) << 0.06 * std::cos(angle), 0.02 * r, 0.06 * std::sin(angle);
            if (r + 1 == rings) continue;
            triangles.row(t++) << v, v + segments, next;
            triangles.row(t++) << next, v + segments, next + segments;
        }
    surfaces.muscle = surfaces.bone = surfaces.skin;
    for (const int axis : {0, 2}) {
        surfaces.muscle.col(axis) *= 0.8;
        surfaces.bone.col(axis) *= 0.5;
    }
    return surfaces;
}

double smallest_scaled_jacobian(const LayerSurfaces& surfaces, const Triangles& triangles)
{
    Points volume(3 * surfaces.skin.rows(), 3);
    volume << surfaces.bone, surfaces.muscle, surfaces.skin;
    return min_scaled_jacobian(volume, layer_prisms(triangles, static_cast<int>(surfaces.skin.rows())));
}

}  // namespace

TEST_CASE("The penalty of prisms has the gradient of differences, for inverted prisms too", "[layers]")
{
    Random random(5, "prisms");
    int active = 0, inverted = 0;
    for (int trial = 0; trial < 40; ++trial) {
        PrismVertices prism;
        prism << 0.02, 0.0, 0.003, 0.0, 0.02, 0.003, 0.0, 0.0, 0.003, 0.02, 0.0, 0.0, 0.0, 0.02, 0.0, 0.0, 0.0, 0.0;
        for (Eigen::Index i = 0; i < prism.size(); ++i) prism.data()[i] += 0.003 * random.normal();
        PrismVertices gradient = PrismVertices::Zero();
        Eigen::Matrix<double, 18, 18> hessian = Eigen::Matrix<double, 18, 18>::Zero();
        const double value = prism_penalty(prism, 0.3, 0.004, &gradient, &hessian);
        active += value > 0.0;
        inverted += prism_min_scaled_jacobian(prism) < 0.0;
        constexpr double step = 1e-8;
        for (int v = 0; v < 6; ++v)
            for (int c = 0; c < 3; ++c) {
                PrismVertices low = prism, high = prism;
                low(v, c) -= step;
                high(v, c) += step;
                const double slope = (prism_penalty(high, 0.3, 0.004, nullptr, nullptr) -
                                      prism_penalty(low, 0.3, 0.004, nullptr, nullptr)) /
                                     (2.0 * step);
                CHECK(gradient(v, c) == Approx(slope).epsilon(1e-4).margin(1e-3));
            }
        const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 18, 18>> eigen(hessian);
        CHECK(eigen.eigenvalues().minCoeff() > -1e-9 * std::max(1.0, eigen.eigenvalues().maxCoeff()));
    }
    CHECK(active > 20);
    CHECK(inverted > 3);
}

TEST_CASE("Good layers stay as they are; bad ones are repaired where they are bad", "[layers]")
{
    Triangles triangles;
    const LayerSurfaces good = tubes(15, 20, triangles);
    LayerFitReport report;
    const LayerSurfaces same = fit_layers(triangles, good, {}, report);
    CHECK(same.bone == good.bone);
    CHECK(same.skin == good.skin);
    CHECK(report.moved_vertices == 0);
    CHECK(report.max_skin_displacement == 0.0);

    LayerSurfaces bad = good;
    const int v = 7 * 20 + 5, other = 3 * 20 + 12;
    bad.bone.row(v) = 1.3 * bad.skin.row(v);              // out through the skin
    bad.muscle.row(other) = 1.05 * bad.skin.row(other);   // as is this
    bad.bone.row(other + 20) << bad.bone.row(other + 1);  // slid over its neighbour
    REQUIRE(smallest_scaled_jacobian(bad, triangles) < 0.0);
    const LayerSurfaces repaired = fit_layers(triangles, bad, {}, report);
    CHECK(smallest_scaled_jacobian(repaired, triangles) >= LayerFitOptions{}.min_scaled_jacobian);
    CHECK(report.min_scaled_jacobian == Approx(smallest_scaled_jacobian(repaired, triangles)).margin(1e-9));
    CHECK(report.moved_vertices < 160);
    CHECK(report.mean_skin_displacement < 0.0005);
    const Eigen::VectorXd moved = (repaired.skin - bad.skin).rowwise().norm();
    CHECK(report.max_skin_displacement == Approx(moved.maxCoeff()));
    CHECK(report.mean_skin_displacement == Approx(moved.mean()));
    // Far away nothing moves.
    CHECK((repaired.bone - bad.bone).bottomRows(20).norm() == 0.0);

    // The skin is held: the stiffer its springs, the less of the repair it takes.
    LayerFitOptions stiff;
    stiff.skin_spring = 1000.0;
    LayerFitReport stiff_report;
    fit_layers(triangles, bad, stiff, stiff_report);
    CHECK(stiff_report.max_skin_displacement < 0.5 * report.max_skin_displacement + 1e-6);
    LayerFitOptions wrong;
    wrong.min_scaled_jacobian = 0.9;
    CHECK_THROWS_AS(fit_layers(triangles, good, wrong, report), InputError);
}

TEST_CASE("A whole patch turned inside out comes round", "[layers]")
{
    Triangles triangles;
    const LayerSurfaces good = tubes(15, 20, triangles);
    LayerSurfaces bad = good;
    for (int r = 5; r < 9; ++r)
        for (int k = 3; k < 7; ++k) std::swap(bad.bone(r * 20 + k, 0), bad.bone(r * 20 + (k + 3) % 20, 0));
    REQUIRE(smallest_scaled_jacobian(bad, triangles) < 0.0);
    LayerFitReport report;
    const LayerSurfaces repaired = fit_layers(triangles, bad, {}, report);
    CHECK(smallest_scaled_jacobian(repaired, triangles) > 0.05);
}

TEST_CASE("The bone wrap is pressed under the skin, smoothly and no more than needed", "[layers]")
{
    Triangles triangles;
    const LayerSurfaces good = tubes(25, 20, triangles);
    Points bone = good.bone;
    press_under_skin(good.skin, triangles, 0.004, bone);
    CHECK(bone == good.bone);
    for (int k = 0; k < 20; ++k)
        for (const int axis : {0, 2}) bone(12 * 20 + k, axis) = 1.05 * good.skin(12 * 20 + k, axis);
    const Points before = bone;
    press_under_skin(good.skin, triangles, 0.004, bone);
    const Points normals = vertex_normals(good.skin, triangles);
    const Eigen::VectorXd depth = (good.skin - bone).cwiseProduct(normals).rowwise().sum();
    CHECK(depth.minCoeff() >= 0.004 - 1e-9);
    const auto moved = [&](int ring) { return (bone - before).row(ring * 20).norm(); };
    CHECK(moved(12) < 0.012);
    CHECK(moved(11) > 0.2 * moved(12));
    CHECK(moved(11) < moved(12));
    CHECK(moved(2) < 0.05 * moved(12));
}

TEST_CASE("A skin that fails is set apart, and people must be known", "[layers]")
{
    const test::TemporaryFolder folder;
    const Template tube = test::tube_template();
    const LayerBuilder builder(tube, {});
    SkinSet skins;
    skins.bodies = {tube.rest, tube.rest};
    skins.bodies[0].name = "first";
    skins.bodies[1].name = "second";
    skins.bodies[1].skin_vertices(0, 0) = std::nan("");
    skins.parameter_names = {"age_years", "sex"};
    skins.parameters.resize(2, 2);
    skins.parameters << 30.0, 1.0, 50.0, 0.0;
    std::vector<Person> people = people_of_skins(skins, "skins.h5", {});
    CHECK(people[0].sex == 1.0);
    CHECK(people[1].age_years == 50.0);
    const std::string output = folder.file("bodies.h5");
    const PartStore store(output, body_parts, "key", false);
    CHECK_THROWS_AS(build_layer_batch(builder, skins, people, store, [] { return true; }), Interrupted);
    // The tube has no landmarks to measure girths at, and the second skin is broken besides.
    const LayerBatch batch = build_layer_batch(builder, skins, people, store, [] { return false; });
    CHECK(batch.bodies.bodies.empty());
    REQUIRE(batch.failures.size() == 2);
    CHECK_THAT(batch.failures[1], Contains("second") && Contains("not finite"));
    store.remove();
    CHECK_FALSE(std::filesystem::exists(output + ".parts"));

    skins.parameters(1, 1) = 3.0;
    CHECK_THROWS_WITH(people_of_skins(skins, "skins.h5", {}), Contains("second") && Contains("sex 3"));
    CHECK(test::undescribed_bytes<LayerFitOptions>().empty());
    LayerFitOptions other;
    other.wrap_spring *= 1 + 1e-15;
    CHECK(layers_key(other, "template") != layers_key({}, "template"));
    CHECK(layers_key({}, "another") != layers_key({}, "template"));

    PeopleOptions all_alike{SexSource::unknown, 12.0};
    CHECK_THROWS_WITH(people_of_skins(skins, "skins.h5", all_alike), Contains("12 years"));
    all_alike.age_years = 44.0;
    CHECK(people_of_skins(skins, "skins.h5", all_alike)[1].age_years == 44.0);
}
