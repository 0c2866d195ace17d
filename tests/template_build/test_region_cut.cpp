// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/template_build/region_cut.h"

#include <catch2/catch.hpp>

using namespace ndg;

TEST_CASE("cutting along zero splits triangles on the line and keeps area", "[build]")
{
    Points vertices(4, 3);
    vertices << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
    Triangles triangles(2, 3);
    triangles << 0, 1, 2, 0, 2, 3;
    Eigen::VectorXd field(4);
    field << -0.25, 0.75, 0.75, -0.25;  // zero at x = 0.25
    const CutSurface cut = cut_along_zero(vertices, triangles, field, 1e-6);
    REQUIRE(cut.triangle_labels.size() == static_cast<std::size_t>(cut.triangles.rows()));
    double negative_area = 0, positive_area = 0;
    const Eigen::VectorXd areas = triangle_areas(cut.vertices, cut.triangles);
    for (Eigen::Index i = 0; i < areas.size(); ++i)
        (cut.triangle_labels[i] == 1 ? negative_area : positive_area) += areas[i];
    CHECK(negative_area == Approx(0.25).epsilon(1e-12));
    CHECK(positive_area == Approx(0.75).epsilon(1e-12));
    CHECK(triangle_normals(cut.vertices, cut.triangles).col(2).minCoeff() == Approx(1.0));
    CHECK(mesh_edges(cut.triangles, static_cast<int>(cut.vertices.rows())).size() > 5);  // manifold, or it throws
}
