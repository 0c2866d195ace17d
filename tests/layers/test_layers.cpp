// SPDX-License-Identifier: Apache-2.0
// Making templates and bodies: pieces that need no data.
#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/layers/layer_batch.h"
#include "ndg/makehuman/files.h"
#include "ndg/template_build/region_cut.h"
#include "ndg/wraps/bone_interior.h"
#include "ndg/wraps/wrap_skin.h"
#include "support/support.h"

#include <zlib.h>
#include <catch2/catch.hpp>

#include <cmath>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// A tube of skin along the left upper arm and forearm, radius 0.05 m.
WrapSkin tube_skin(int rings, int segments)
{
    WrapSkin skin;
    const Skeleton& skeleton = standard_skeleton();
    skin.joint_positions.resize(skeleton.num_joints(), 3);
    for (int j = 0; j < skeleton.num_joints(); ++j) skin.joint_positions.row(j) << 10.0 + j, 0.0, 0.0;
    const int upper = skeleton.joint("left_upper_arm"), fore = skeleton.joint("left_forearm");
    skin.joint_positions.row(upper) << 0.0, -0.1, 0.0;
    skin.joint_positions.row(fore) << 0.0, 0.5, 0.0;
    skin.joint_positions.row(skeleton.joint("left_forearm_twist")) << 0.0, 0.8, 0.0;
    skin.joint_positions.row(skeleton.joint("left_hand")) << 0.0, 1.1, 0.0;
    skin.vertices.resize(rings * segments, 3);
    skin.weights = RowMatrix::Zero(rings * segments, skeleton.num_joints());
    skin.triangles.resize(2 * (rings - 1) * segments, 3);
    int t = 0;
    for (int r = 0; r < rings; ++r)
        for (int k = 0; k < segments; ++k) {
            const double angle = 2.0 * M_PI * k / segments, y = static_cast<double>(r) / (rings - 1);
            const int v = r * segments + k, next = r * segments + (k + 1) % segments;
            skin.vertices.row(v) << 0.05 * std::cos(angle), y, 0.05 * std::sin(angle);
            skin.weights(v, y < 0.5 ? upper : fore) = 1.0;
            if (r + 1 == rings) continue;
            skin.triangles.row(t++) << v, v + segments, next;
            skin.triangles.row(t++) << next, v + segments, next + segments;
        }
    return skin;
}

}  // namespace

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

TEST_CASE("bone interior fills the wrap, its weights blend, and it follows the wrap", "[build]")
{
    const WrapSkin skin = tube_skin(9, 8);
    const BoneInterior interior = fill_bone_wrap(skin.vertices, skin.triangles, skin.weights);
    const int num_wrap = static_cast<int>(skin.vertices.rows());
    CHECK(interior.vertices.rows() >= 2);
    CHECK(interior.tetrahedra.maxCoeff() < num_wrap + interior.vertices.rows());
    CHECK((interior.weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-9);
    CHECK(interior.weights.minCoeff() > -1e-9);

    const Points same = transfer_interior(skin.vertices, interior.vertices, interior.tetrahedra, skin.vertices);
    CHECK((same - interior.vertices).norm() < 1e-10);
    Points moved_wrap = skin.vertices;
    moved_wrap.rowwise() += Eigen::RowVector3d(0.1, -0.2, 0.3);
    const Points moved = transfer_interior(skin.vertices, interior.vertices, interior.tetrahedra, moved_wrap);
    CHECK(((moved - interior.vertices).rowwise() - Eigen::RowVector3d(0.1, -0.2, 0.3)).norm() < 1e-9);
}

TEST_CASE("a skin of another tessellation is refused by name", "[build]")
{
    const Template tube = test::tube_template();
    Body skin = tube.rest;
    skin.name = "someone";
    skin.skin_vertices.conservativeResize(5, 3);
    CHECK_THROWS_WITH(build_layers(tube, skin, {}, 0.05), Contains("someone") && Contains("5 skin vertices"));
    BodySet skins;
    skins.parameter_names = {"sex"};
    CHECK_THROWS_WITH(people_of_skins(skins, "skins.h5", {}), Contains("skins.h5") && Contains("age_years"));
}

TEST_CASE("targets are read, and bad ones named", "[build]")
{
    const test::TemporaryFolder folder;
    const auto write = [&](const std::string& name, const std::string& text) {
        gzFile file = gzopen(folder.file(name).c_str(), "wb");
        REQUIRE(file != nullptr);
        gzwrite(file, text.data(), static_cast<unsigned>(text.size()));
        gzclose(file);
        return folder.file(name);
    };
    const MakeHumanTarget target = read_makehuman_target(write("good.gz", "# comment\n2 .5 -1 0\n0 0 0 3e-1\n"), 3);
    REQUIRE(target.vertices == std::vector<int>{2, 0});
    CHECK(target.offsets(0, 0) == 0.5);
    CHECK(target.offsets(1, 2) == 0.3);
    CHECK_THROWS_WITH(read_makehuman_target(write("range.gz", "3 0 0 0\n"), 3),
                      Contains("range.gz") && Contains("vertex 3"));
    CHECK_THROWS_WITH(read_makehuman_target(write("word.gz", "1 0 x 0\n"), 3), Contains("line 1"));
    CHECK_THROWS_AS(read_makehuman_target(folder.file("missing.gz"), 3), InputError);
}
