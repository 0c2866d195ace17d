// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/tetrahedra.h"
#include "support/h5_damage.h"
#include "tube_body.h"

#include <catch2/catch.hpp>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>
#include <set>

using namespace ndg;

namespace {

struct TubeAvatar {
    test::TubeBody scene;
    AvatarOptions options = test::tube_options();
    AvatarReport report;
    Eigen::VectorXd shape;
    Avatar avatar;

    explicit TubeAvatar(int rings = 25, int segments = 12) : scene(rings, segments)
    {
        shape = scene.body.people_shapes.row(2).transpose();
        avatar = make_avatar(scene.body, shape, options, {}, report);
        avatar.name = "tube_2";
    }
};

double least_volume(const Avatar& avatar)
{
    return tetrahedron_volumes(avatar.rest, avatar.tetrahedra).minCoeff();
}

double mean(const std::vector<double>& values)
{
    double sum = 0;
    for (const double value : values) sum += value / double(values.size());
    return sum;
}

/// What every avatar must be.
void check_consistent(const Avatar& avatar)
{
    const auto w = Eigen::Index(avatar.skin_of_inner.size());
    CHECK(least_volume(avatar) > 0);
    CHECK(avatar.num_held > w);
    CHECK(avatar.num_held < 2 * w);
    for (Eigen::Index v = 0; v < w; ++v) {
        const int skin = avatar.skin_of_inner[v], outer = avatar.volume_vertex_of_skin[skin];
        REQUIRE(outer >= w);
        REQUIRE(outer < 2 * w);
        CHECK(avatar.rest.row(outer) == avatar.skin_vertices.row(skin));
        CHECK((avatar.rest.row(v) - avatar.rest.row(outer)).norm() == Approx(avatar.thickness[v]));
        CHECK(avatar.thickness[v] >= avatar.min_thickness[v] - 1e-12);
        CHECK(avatar.thickness[v] <= avatar.max_thickness[v] + 1e-12);
        CHECK((avatar.control_weights.row(v) - avatar.control_weights.row(outer)).norm() < 1e-12);
        CHECK((RowMatrix(avatar.weights).row(outer) - RowMatrix(avatar.skin_weights).row(skin)).norm() == 0);
    }
    CHECK(weights_defect(RowMatrix(avatar.weights)).empty());
    CHECK(weights_defect(avatar.control_weights).empty());
    CHECK((avatar.normals.rowwise().norm().array() - 1).abs().maxCoeff() < 1e-12);
    // The skin among the volume's triangles faces outward: it encloses, with the inner surface, what the tetrahedra
    // fill.
    const Points normals = triangle_normals(avatar.rest, avatar.skin_triangles);
    for (Eigen::Index t = 0; t < avatar.skin_triangles.rows(); ++t)
        CHECK(normals.row(t).dot(avatar.normals.row(avatar.skin_triangles(t, 0))) > 0);
}

}  // namespace

TEST_CASE("The tube gets an avatar: a hollow cylinder of soft tissue without inverted tetrahedra")
{
    const TubeAvatar tube;
    check_consistent(tube.avatar);
    CHECK(tube.report.num_unfolded == 0);
    CHECK(tube.report.num_thin <= 24);
    CHECK(tube.report.largest_stretch < 3);
    const SoftRegion region = avatar_region(tube.avatar);
    Points outer(region.size(), 3);
    for (int v = 0; v < region.size(); ++v) outer.row(v) = tube.avatar.rest.row(region.outer[v]);
    const TriangleMesh surface = layer_surface(region, outer, tube.avatar.rest.topRows(region.size()));
    CHECK(tube.report.quality.total_volume ==
          Approx(enclosed_volume(surface.vertices, surface.triangles)).epsilon(1e-9));
    // In the middle the tissue is as thick as asked for, and lies straight below the skin.
    int in_the_middle = 0;
    for (int v = 0; v < region.size(); ++v) {
        if (outer(v, 1) < 0.2 || outer(v, 1) > 0.6) continue;
        ++in_the_middle;
        CHECK(tube.avatar.thickness[v] == Approx(0.03));
        const Eigen::RowVector3d to_axis = outer.row(v).cwiseProduct(Eigen::RowVector3d(-1, 0, -1));
        CHECK(tube.avatar.inward.row(v).dot(to_axis.normalized()) > 0.95);
    }
    CHECK(in_the_middle >= 96);
    CHECK(tube.report.quality.least_dihedral > 0.01);
    // Normals point away from the axis all through, also inside.
    for (Eigen::Index v = 0; v < tube.avatar.rest.rows(); ++v) {
        const Eigen::RowVector3d from_axis = tube.avatar.rest.row(v).cwiseProduct(Eigen::RowVector3d(1, 0, 1));
        const double y = tube.avatar.rest(v, 1);
        if (y > 0.2 && y < 0.7) CHECK(tube.avatar.normals.row(v).dot(from_axis.normalized()) > 0.8);
    }
}

TEST_CASE("No tetrahedron is inverted at the least, the greatest and random thicknesses")
{
    TubeAvatar tube;
    Avatar& avatar = tube.avatar;
    const auto c = std::size_t(avatar.control_weights.cols());
    int kept = 0, made = 0;
    const auto change = [&](const std::vector<double>& thickness) {
        const VolumeChange how = change_thickness(avatar, thickness, tube.options);
        (how == VolumeChange::same_tetrahedra ? kept : made)++;
        check_consistent(avatar);
    };
    const double before = mean(avatar.thickness);
    change(avatar.max_thickness);
    CHECK(mean(avatar.thickness) > before + 0.005);
    change(avatar.min_thickness);
    CHECK(mean(avatar.thickness) < before - 0.005);
    for (std::uint64_t trial = 0; trial < 6; ++trial) {
        Random random(1, "thickness", trial);
        std::vector<double> values;
        for (std::size_t i = 0; i < c; ++i) values.push_back(random.uniform(0.001, 0.1));
        const std::vector<double> field = thickness_field(avatar, values);
        change(field);
        for (std::size_t v = 0; v < field.size(); ++v) CHECK(avatar.thickness[v] <= field[v] + 1e-12);
    }
    CHECK(kept > 0);

    // A small change keeps the tetrahedra, and vertices inside go along.
    const Avatar start = avatar;
    std::vector<double> closer = avatar.thickness;
    for (std::size_t v = 0; v < closer.size(); ++v) closer[v] = std::max(avatar.min_thickness[v], closer[v] - 1e-4);
    REQUIRE(move_inner_surface(avatar, closer));
    CHECK(avatar.tetrahedra == start.tetrahedra);
    const double moved = (avatar.rest - start.rest).rowwise().norm().maxCoeff();
    CHECK(moved > 0.5e-4);
    CHECK(moved < 1.01e-4);
    for (std::size_t v = 0; v < avatar.skin_of_inner.size(); ++v) {
        const int outer = avatar.volume_vertex_of_skin[avatar.skin_of_inner[v]];
        CHECK(avatar.rest.row(outer) == start.rest.row(outer));
    }

    std::vector<double> too_thick = avatar.max_thickness;
    too_thick[3] += 0.01;
    CHECK_THROWS_WITH(move_inner_surface(avatar, too_thick),
                      Catch::Contains("inner vertex 3") && Catch::Contains("outside its bounds"));
    too_thick.pop_back();
    CHECK_THROWS_AS(move_inner_surface(avatar, too_thick), InputError);
    CHECK_THROWS_AS(thickness_field(avatar, {0.01}), InputError);
    CHECK_THROWS_AS(thickness_field(avatar, std::vector<double>(c, -0.01)), InputError);
}

TEST_CASE("An avatar with values at its control points has them there")
{
    const test::TubeBody scene;
    const AvatarOptions options = test::tube_options();
    AvatarReport report;
    std::vector<double> values;
    for (int c = 0; c < options.control_points; ++c) values.push_back(0.02 + 0.004 * c);
    const Avatar avatar = make_avatar(scene.body, Eigen::VectorXd(), options, values, report);
    check_consistent(avatar);
    int inside = 0;
    for (std::size_t v = 0; v < avatar.skin_of_inner.size(); ++v)
        for (int c = 0; c < options.control_points; ++c) {
            const int skin = avatar.skin_of_inner[v];
            if (skin != avatar.control_vertices[c] && skin != avatar.mirror_vertices[c]) continue;
            const bool bounded = values[c] > avatar.max_thickness[v] || values[c] < avatar.min_thickness[v];
            if (bounded) continue;
            ++inside;
            CHECK(avatar.thickness[v] == Approx(values[c]));
        }
    CHECK(inside >= 2);
    CHECK_THROWS_AS(make_avatar(scene.body, Eigen::VectorXd(), options, {0.01}, report), InputError);
}

TEST_CASE("At rest the maps are the identity, and posed they are skinning with pose directions")
{
    const TubeAvatar tube;
    const Avatar& avatar = tube.avatar;
    const AvatarPoser poser(avatar);
    const auto at_rest = poser.world_from_unposed(Pose::rest(60));
    for (const AffineMap& map : at_rest) {
        CHECK((map.leftCols<3>() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
        CHECK(map.col(3).norm() < 1e-12);
    }
    for (std::uint64_t index = 0; index < 3; ++index) {
        const Pose pose = test::random_pose(60, 0.4, index);
        const auto maps = poser.world_from_unposed(pose);
        const Points posed = to_world(maps, avatar.rest);
        const PosedSkin expected = skin_body(tube.scene.body, tube.shape, pose);
        double farthest = 0;
        for (Eigen::Index v = 0; v < avatar.skin_vertices.rows(); ++v) {
            const int volume_vertex = avatar.volume_vertex_of_skin[v];
            if (volume_vertex >= 0)
                farthest = std::max(farthest, (posed.row(volume_vertex) - expected.vertices.row(v)).norm());
        }
        CHECK(farthest < 1e-9);
        CHECK((poser.display_skin(pose, posed) - expected.vertices).rowwise().norm().maxCoeff() < 1e-9);

        Points unposed = avatar.rest;
        Random random(2, "unposed", index);
        for (Eigen::Index i = 0; i < unposed.size(); ++i) unposed.data()[i] += 0.01 * random.normal();
        CHECK((to_unposed(maps, to_world(maps, unposed)) - unposed).cwiseAbs().maxCoeff() < 1e-9);
    }
    // The inside follows by the offsets carried inside: with one joint moved, by that joint's directions.
    const Pose bent = test::tube_pose(0.7);
    const auto maps = poser.world_from_unposed(bent);
    const auto motions = poser.world_from_rest(bent);
    const Eigen::VectorXd features = [&] {
        Eigen::VectorXd f(9 * avatar.pose_joints.size());
        for (std::size_t p = 0; p < avatar.pose_joints.size(); ++p)
            for (int r = 0; r < 3; ++r)
                for (int c = 0; c < 3; ++c)
                    f[9 * Eigen::Index(p) + 3 * r + c] = bent.parent_from_joint[avatar.pose_joints[p]](r, c) - (r == c);
        return f;
    }();
    const RowMatrix weights = avatar.weights;
    for (Eigen::Index v = 0; v < avatar.rest.rows(); v += 37) {
        Eigen::Vector3d rest = avatar.rest.row(v);
        for (int c = 0; c < 3; ++c) rest[c] += features.dot(avatar.pose_directions.col(3 * v + c).cast<double>());
        Eigen::Vector3d expected = Eigen::Vector3d::Zero();
        for (int j = 0; j < 60; ++j) expected += weights(v, j) * (motions[j] * rest);
        CHECK((maps[v] * avatar.rest.row(v).transpose().homogeneous() - expected).norm() < 1e-9);
    }
    CHECK_THROWS_AS(poser.world_from_unposed(Pose::rest(24)), Error);
    CHECK_THROWS_AS(poser.display_skin(bent, avatar.rest.topRows(3)), Error);
}

TEST_CASE("Maps that blending all but collapses stay invertible, and keep the skinned shape")
{
    const TubeAvatar tube;
    const AvatarPoser poser(tube.avatar);
    const Pose folded = test::tube_pose(EIGEN_PI);  // half-way, a direction has no length at all
    const auto maps = poser.world_from_unposed(folded);
    double least = 1e9;
    for (const AffineMap& map : maps) {
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(map.leftCols<3>());
        least = std::min(least, svd.singularValues()[2]);
        CHECK(map.leftCols<3>().determinant() > 0);
    }
    CHECK(least == Approx(least_map_stretch));
    const PosedSkin expected = skin_body(tube.scene.body, tube.shape, folded);
    CHECK(
        (poser.display_skin(folded, to_world(maps, tube.avatar.rest)) - expected.vertices).rowwise().norm().maxCoeff() <
        1e-9);

    // Continuous on the way through the collapse.
    Eigen::Matrix3d before = Eigen::Matrix3d::Identity();
    double largest_step = 0;
    for (int i = 0; i <= 2000; ++i) {
        const double angle = EIGEN_PI * i / 1000.0;
        const Eigen::Matrix3d blend = 0.5 * (Eigen::Matrix3d::Identity() + about_z(angle)) * about_x(0.3);
        const Eigen::Matrix3d raised = stretched_at_least(blend, 0.2);
        if (i > 0) largest_step = std::max(largest_step, (raised - before).norm());
        before = raised;
        if (blend.determinant() >= 0.2) CHECK(raised == blend);
    }
    CHECK(largest_step < 0.7);
    // A mirror image is none any more.
    const Eigen::Matrix3d mirrored = Eigen::Vector3d(1, 0.9, -0.5).asDiagonal();
    CHECK((stretched_at_least(mirrored, 0.2) - Eigen::Matrix3d(Eigen::Vector3d(1, 0.9, 0.2).asDiagonal())).norm() <
          1e-12);
}

TEST_CASE("An avatar goes through its file")
{
    const TubeAvatar tube(13, 8);
    const Avatar& avatar = tube.avatar;
    const test::TemporaryFolder folder;
    const std::string path = folder.file("avatar.h5");
    write_avatar(path, avatar, test::example_provenance());
    const Avatar read = read_avatar(path);
    CHECK(read.name == "tube_2");
    CHECK(read.rest == avatar.rest);
    CHECK(read.num_held == avatar.num_held);
    CHECK(read.tetrahedra == avatar.tetrahedra);
    CHECK(read.skin_triangles == avatar.skin_triangles);
    CHECK(read.normals == avatar.normals);
    CHECK(RowMatrix(read.weights) == RowMatrix(avatar.weights));
    CHECK(read.joint_positions == avatar.joint_positions);
    CHECK(read.skeleton.parents == avatar.skeleton.parents);
    CHECK(read.pose_joints == avatar.pose_joints);
    CHECK(read.pose_directions == avatar.pose_directions);
    CHECK(read.skin_vertices == avatar.skin_vertices);
    CHECK(read.whole_skin_triangles == avatar.whole_skin_triangles);
    CHECK(RowMatrix(read.skin_weights) == RowMatrix(avatar.skin_weights));
    CHECK(read.skin_pose_directions == avatar.skin_pose_directions);
    CHECK(read.volume_vertex_of_skin == avatar.volume_vertex_of_skin);
    CHECK(read.skin_of_inner == avatar.skin_of_inner);
    CHECK(read.inward == avatar.inward);
    CHECK(read.thickness == avatar.thickness);
    CHECK(read.min_thickness == avatar.min_thickness);
    CHECK(read.max_thickness == avatar.max_thickness);
    CHECK(read.control_vertices == avatar.control_vertices);
    CHECK(read.mirror_vertices == avatar.mirror_vertices);
    CHECK(read.control_weights == avatar.control_weights);
    const SoftRegion region = avatar_region(read);
    CHECK(region.triangles.rows() == read.skin_triangles.rows());
    CHECK(int(region.rim.size()) == read.num_held - region.size());

    test::check_damages(
        path,
        {{"f['/volume/vertices'][3, 1] = np.nan", {"/volume/vertices", "not finite"}},
         {"t = f['/volume/tetrahedra'][...]; t[5] = t[5, [0, 2, 1, 3]]; put('/volume/tetrahedra', t)",
          {"/volume/tetrahedra[5]", "volume -"}},
         {"put('/volume/weights', f['/volume/weights'][:, :59])", {"/volume/weights", "expected"}},
         {"f['/volume/weights'][4, 0] += 0.1", {"/volume/weights[4]", "instead of 1"}},
         {"f['/skin/weights'][4, 0] += 0.1", {"/skin/weights[4]", "instead of 1"}},
         {"f['/skeleton/parents'][3] = 7", {"/skeleton/parents[3] is 7", "before their children"}},
         {"f['/layer/thickness'][50] = 0.5", {"/layer/thickness[50] is 0.5 m", "outside its bounds"}},
         {"f['/layer/thickness'][50] = f['/layer/min_thickness'][50]; f['/layer/max_thickness'][50] = 1",
          {"/volume/vertices[50]", "inside of skin vertex"}},
         {"f['/volume/num_held'][0] = 1", {"1 are held"}},
         {"f['/layer/outer_vertices'][1] = f['/layer/outer_vertices'][0]", {"/layer/", "[1]"}},
         {"f['/volume/normals'][2] *= 2", {"/volume/normals[2]", "length 2"}},
         {"f['/control/weights'][2, 0] += 1", {"/control/weights[2]", "instead of 1"}},
         {"put('/pose/volume_directions', f['/pose/volume_directions'][:, :-3])", {"/pose/volume_directions"}}},
        [](const std::string& damaged) { read_avatar(damaged); });
}

TEST_CASE("Bodies without an end of their soft tissue, and options out of range, are refused")
{
    const test::TubeBody scene(9, 6);
    AvatarReport report;
    StatisticalBody body = scene.body;
    body.soft_triangles.clear();
    CHECK_THROWS_WITH(make_avatar(body, Eigen::VectorXd(), test::tube_options(), {}, report),
                      Catch::Contains("soft_triangles"));
    body = scene.body;
    body.vertices(3, 1) = std::nan("");
    CHECK_THROWS_WITH(make_avatar(body, Eigen::VectorXd(), test::tube_options(), {}, report),
                      Catch::Contains("not finite"));
    AvatarOptions options = test::tube_options();
    options.thickness = -1;
    CHECK_THROWS_WITH(make_avatar(scene.body, Eigen::VectorXd(), options, {}, report), Catch::Contains("thickness"));
    options = test::tube_options();
    options.layer.min_thickness = 0.0999;  // more than the tube is wide
    options.layer.rim_thickness = 0.0999;
    CHECK_THROWS_WITH(make_avatar(scene.body, Eigen::VectorXd(), options, {}, report), Catch::Contains("folds over"));
}
