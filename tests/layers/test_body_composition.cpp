// SPDX-License-Identifier: Apache-2.0
// Girths, and what they tell of fat and muscle.
#include "ndg/core/error.h"
#include "ndg/layers/body_composition.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <functional>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// Closed surface of revolution about y through (x, ., 0) with the given radius at each angle, from y = 0 to 1.
void add_column(Points& vertices, Triangles& triangles, double x, const std::function<double(double)>& radius)
{
    constexpr int rings = 9, segments = 120;
    const auto first = static_cast<int>(vertices.rows());
    Eigen::Index t = triangles.rows();
    vertices.conservativeResize(first + rings * segments + 2, 3);
    triangles.conservativeResize(t + 2 * segments * rings, 3);
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < segments; ++k) {
            const double angle = 2.0 * M_PI * k / segments;
            vertices.row(first + r * segments + k) << x + radius(angle) * std::cos(angle), r / (rings - 1.0),
                radius(angle) * std::sin(angle);
            const int v = first + r * segments + k, next = first + r * segments + (k + 1) % segments;
            if (r + 1 == rings) continue;
            triangles.row(t++) << v, v + segments, next;
            triangles.row(t++) << next, v + segments, next + segments;
        }
    const int bottom = first + rings * segments, top = bottom + 1;
    vertices.row(bottom) << x, 0.0, 0.0;
    vertices.row(top) << x, 1.0, 0.0;
    for (int k = 0; k < segments; ++k) {
        triangles.row(t++) << bottom, first + k, first + (k + 1) % segments;
        triangles.row(t++) << top, first + (rings - 1) * segments + (k + 1) % segments,
            first + (rings - 1) * segments + k;
    }
}

BodyGirths usual_man()
{
    BodyGirths girths;
    girths.neck = 0.381;
    girths.abdomen = girths.waist = 0.8636;
    girths.hip = 0.97;
    girths.upper_arm = 0.32;
    girths.thigh = 0.55;
    girths.calf = 0.37;
    return girths;
}

constexpr double inch = 0.0254;

}  // namespace

TEST_CASE("A girth is the length of a tape around the limb asked for", "[layers]")
{
    Points vertices(0, 3);
    Triangles triangles(0, 3);
    add_column(vertices, triangles, 0.0, [](double) { return 0.2; });
    // A second limb beside it, with hollows that a tape bridges.
    add_column(vertices, triangles, 1.0, [](double angle) { return 0.1 * (1.0 + 0.3 * std::cos(4.0 * angle)); });
    const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
    CHECK(section_girth(vertices, triangles, {0.02, 0.43, 0.03}, up) == Approx(2.0 * M_PI * 0.2).epsilon(1e-3));
    // Outside of both, the nearer one counts.
    CHECK(section_girth(vertices, triangles, {0.3, 0.43, 0.0}, up) == Approx(2.0 * M_PI * 0.2).epsilon(1e-3));
    // The hull of a cross with four round arms: longer than the square through its tips, shorter than the circle.
    const double hull = section_girth(vertices, triangles, {1.0, 0.43, 0.0}, up);
    CHECK(hull > 4.0 * std::sqrt(2.0) * 0.13);
    CHECK(hull < 2.0 * M_PI * 0.13);
    // A plane tilted by 30 degrees cuts an ellipse (Ramanujan's approximation of its length).
    const double a = 0.2 / std::cos(M_PI / 6.0), b = 0.2, h = std::pow((a - b) / (a + b), 2);
    const double ellipse = M_PI * (a + b) * (1.0 + 3.0 * h / (10.0 + std::sqrt(4.0 - 3.0 * h)));
    CHECK(section_girth(vertices, triangles, {0.0, 0.5, 0.0}, {0.0, std::cos(M_PI / 6.0), std::sin(M_PI / 6.0)}) ==
          Approx(ellipse).epsilon(1e-3));
    CHECK(section_girth(vertices, triangles, {0.0, 1.5, 0.0}, up) == 0.0);
    // Through vertices exactly.
    CHECK(section_girth(vertices, triangles, {0.0, 0.5, 0.0}, up) == Approx(2.0 * M_PI * 0.2).epsilon(1e-3));
}

TEST_CASE("Girths need the template's landmarks", "[layers]")
{
    const Template tube = test::tube_template();
    CHECK_THROWS_WITH(measure_girths(tube, tube.rest), Contains("landmark") || Contains("girth"));
}

TEST_CASE("Fat follows the circumference formulas in their other published form, in inches", "[layers]")
{
    BodyGirths girths = usual_man();
    const double stature = 70.0 * inch;
    const double men = 86.010 * std::log10(34.0 - 15.0) - 70.041 * std::log10(70.0) + 36.76;
    CHECK(100.0 * fat_share(girths, stature, 80.0, {1.0, 40.0}) == Approx(men).margin(0.4));
    girths.neck = 13.0 * inch;
    girths.waist = 30.0 * inch;
    girths.hip = 39.0 * inch;
    const double women = 163.205 * std::log10(30.0 + 39.0 - 13.0) - 97.684 * std::log10(65.0) - 78.387;
    CHECK(100.0 * fat_share(girths, 65.0 * inch, 65.0, {0.0, 40.0}) == Approx(women).margin(0.4));
    // Between the sexes, between the two.
    const double both = fat_share(girths, 1.7, 75.0, {0.5, 40.0});
    CHECK(both == Approx(0.5 * (fat_share(girths, 1.7, 75.0, {0.0, 40.0}) + fat_share(girths, 1.7, 75.0, {1.0, 40.0})))
                      .epsilon(1e-9));
    // A very heavy woman gets no more than a standard error above the estimate from mass and age.
    girths.waist = 1.3;
    girths.hip = 1.5;
    const double bmi = 40.0, mass = bmi * 1.6 * 1.6;
    CHECK(fat_share(girths, 1.6, mass, {0.0, 30.0}) == Approx(0.01 * (1.2 * bmi + 0.23 * 30.0 - 5.4) + 0.041));
    girths.waist = 0.4;
    CHECK(fat_share(girths, 1.9, 60.0, {1.0, 20.0}) >= 0.04);
}

TEST_CASE("Muscle follows the published model of corrected girths", "[layers]")
{
    const BodyGirths girths = usual_man();
    // 4 mm of fat: a skinfold of 8 mm.
    const double arm = 32.0 - 0.8 * M_PI, thigh = 55.0 - 0.8 * M_PI, calf = 37.0 - 0.8 * M_PI;
    const double expected =
        1.78 * (0.00744 * arm * arm + 0.00088 * thigh * thigh + 0.00441 * calf * calf) + 2.4 - 0.048 * 30.0 + 7.8;
    CHECK(muscle_mass(girths, 1.78, {1.0, 30.0}, 0.004, 66.0) == Approx(expected).epsilon(1e-12));
    CHECK(muscle_mass(girths, 1.78, {1.0, 30.0}, 0.004, 40.0) == Approx(0.65 * 40.0));
    CHECK(muscle_mass(girths, 1.78, {1.0, 30.0}, 0.004, 140.0) == Approx(0.30 * 140.0));

    const BodyComposition man = body_composition(girths, 1.78, 80.0, 1.6, {1.0, 30.0});
    CHECK(man.fat_mass_kg == Approx(man.fat_share * 80.0));
    CHECK(man.subcutaneous_litre == Approx(0.85 * man.fat_mass_kg / (0.80 * 0.92)));
    CHECK(man.mean_fat_thickness_m == Approx(1e-3 * man.subcutaneous_litre / 1.6));
    CHECK(man.muscle_litre == Approx(man.muscle_mass_kg / 1.04));

    // Equal stature and mass: thick limbs and a slim belly are muscle, the other way round is fat.
    BodyGirths strong = girths, heavy = girths;
    strong.upper_arm += 0.06;
    strong.thigh += 0.04;
    strong.abdomen -= 0.05;
    heavy.abdomen += 0.15;
    const BodyComposition a = body_composition(strong, 1.78, 90.0, 1.7, {1.0, 30.0});
    const BodyComposition b = body_composition(heavy, 1.78, 90.0, 1.7, {1.0, 30.0});
    CHECK(a.muscle_mass_kg > b.muscle_mass_kg + 3.0);
    CHECK(a.fat_mass_kg < b.fat_mass_kg - 8.0);
}
