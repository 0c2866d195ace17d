// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/fit_picture.h"

#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;

namespace {

/// Unit normals all around, those of one half after those of the other.
Points directions(int count)
{
    Points result(count, 3);
    for (int i = 0; i < count; ++i) {
        const double height = 1.0 - (2.0 * i + 1.0) / count, radius = std::sqrt(1.0 - height * height);
        result.row(i) << radius * std::cos(2.4 * i), height, radius * std::sin(2.4 * i);
    }
    return result;
}

/// Share of the pixels of the bottom third that are more red than blue, and the other way round.
std::pair<double, double> red_and_blue(const Image& image)
{
    int red = 0, blue = 0;
    for (int y = image.height * 7 / 10; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const Pixel& pixel = image.at(x, y);
            red += pixel[0] > pixel[2] + 60;
            blue += pixel[2] > pixel[0] + 60;
        }
    }
    const double total = double(image.width) * image.height;
    return {red / total, blue / total};
}

}  // namespace

TEST_CASE("where the scan lies outside the fit is red, where inside blue")
{
    FitPicture fit;
    fit.surface.resize(6, 3);
    fit.surface << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
    fit.triangles.resize(8, 3);
    fit.triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
    fit.normals = directions(2000);
    fit.spacing = 0.05;
    fit.title = "octahedron";
    const auto scan = [&](double offset) {
        fit.points.resize(fit.normals.rows(), 3);
        for (Eigen::Index i = 0; i < fit.points.rows(); ++i) {
            // On the octahedron |x| + |y| + |z| = 1, and `offset` away from it.
            const Eigen::RowVector3d n = fit.normals.row(i);
            const Eigen::RowVector3d face(std::copysign(1, n[0]), std::copysign(1, n[1]), std::copysign(1, n[2]));
            fit.points.row(i) = n / n.cwiseAbs().sum() + offset / std::sqrt(3.0) * face;
        }
    };
    scan(0.02);
    const auto [red_outside, blue_outside] = red_and_blue(fit_picture(fit, 0.02, 120));
    CHECK(red_outside > 0.05);
    CHECK(blue_outside < 0.001);
    scan(-0.02);
    const auto [red_inside, blue_inside] = red_and_blue(fit_picture(fit, 0.02, 120));
    CHECK(blue_inside > 0.05);
    CHECK(red_inside < 0.001);
}
