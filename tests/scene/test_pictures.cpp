// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/pictures.h"

#include "ndg/core/error.h"
#include "ndg/scene/colour_map.h"
#include "scene/shapes.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

PictureSettings small_settings()
{
    PictureSettings settings;
    settings.height = 96;
    settings.samples_per_axis = 1;
    return settings;
}

/// Pixels that are not background.
int count_shown(const Image& image)
{
    return image.width * image.height - test::count_pixels(image, image.at(0, 0));
}

}  // namespace

TEST_CASE("The diverging map is blue below, red above, grey in the middle, and clamps")
{
    const Eigen::Vector3f low = diverging_colour(-1), middle = diverging_colour(0), high = diverging_colour(1);
    CHECK(low[2] > low[0] + 0.3f);
    CHECK(high[0] > high[2] + 0.3f);
    CHECK((middle.maxCoeff() - middle.minCoeff()) < 0.05f);
    CHECK(diverging_colour(-7) == low);
    CHECK(diverging_colour(7) == high);
    // No jump at the stops.
    for (double value = -1; value < 1; value += 0.01)
        CHECK((diverging_colour(value + 0.01) - diverging_colour(value)).norm() < 0.03f);
}

TEST_CASE("A scaled body changes its volume everywhere by the cube of the scale")
{
    const Template tube = test::tube_template();
    const Points& rest = tube.rest.volume_vertices;
    const Eigen::VectorXd change = volume_change(rest, 1.1 * rest, tube.prisms, tube.num_wrap_vertices());
    REQUIRE(change.size() == tube.num_wrap_vertices());
    for (Eigen::Index w = 0; w < change.size(); ++w) CHECK(change[w] == Approx(1.331 - 1.0));
    // One skin vertex moved outwards: it gains, far away nothing happens.
    Points bulged = rest;
    const int vertex = tube.num_wrap_vertices() / 2;
    const int skin_row = 2 * tube.num_wrap_vertices() + vertex;
    bulged(skin_row, 0) *= 1.2;
    bulged(skin_row, 2) *= 1.2;
    const Eigen::VectorXd local = volume_change(rest, bulged, tube.prisms, tube.num_wrap_vertices());
    CHECK(local[vertex] > 0.01);
    CHECK(local[0] == 0);
}

TEST_CASE("A body in the rest pose has the geometry of the body at rest")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube);
    const BodyGeometry rest = rest_geometry(tube, tube.rest);
    const BodyGeometry posed =
        posed_geometry(poser.pose(tube.rest, Pose::rest(tube.skeleton.num_joints())), tube.rest.volume_vertices);
    CHECK((posed.skin_vertices - rest.skin_vertices).cwiseAbs().maxCoeff() < 1e-6);
    CHECK((posed.anatomy_vertices - rest.anatomy_vertices).cwiseAbs().maxCoeff() < 1e-9);
    CHECK(posed.heading == 0);

    Pose turned = Pose::rest(tube.skeleton.num_joints());
    turned.parent_from_joint[0] = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitY()).toRotationMatrix();
    CHECK(skinned_geometry(poser.pose(tube.rest, turned)).heading == Approx(0.7));
    CHECK_THROWS_AS(posed_geometry(poser.pose(tube.rest, turned), tube.rest.volume_vertices.topRows(3)), Error);
}

TEST_CASE("The wraps and the anatomy become surfaces of their own")
{
    const Template tube = test::tube_template();
    const BodyGeometry geometry = rest_geometry(tube, tube.rest);
    CHECK(muscle_wrap_surface(tube, geometry).vertices ==
          tube.rest.volume_vertices.middleRows(tube.num_wrap_vertices(), tube.num_wrap_vertices()));
    CHECK(bone_wrap_surface(tube, geometry).vertices == tube.rest.volume_vertices.topRows(tube.num_wrap_vertices()));
    CHECK(skin_shell(tube, geometry).opacity < 1);
    Eigen::Index num_triangles = 0;
    for (const SceneSurface& surface : anatomy_surfaces(tube, geometry)) {
        CHECK_NOTHROW(check_surface(surface));
        num_triangles += surface.triangles.rows();
    }
    CHECK(num_triangles == tube.anatomy_triangles.rows());
    const SceneSurface coloured = volume_change_surface(tube, tube.rest, geometry, 0.3);
    CHECK(coloured.vertex_colours.rows() == tube.rest.skin_vertices.rows());
    CHECK((coloured.vertex_colours.row(tube.wrap_to_skin[0]).transpose() - diverging_colour(0)).norm() < 1e-5f);
}

TEST_CASE("Pictures of a body show it")
{
    const Template tube = test::tube_template();
    const BodyGeometry geometry = rest_geometry(tube, tube.rest);
    const Image picture = body_picture(tube, tube.rest, geometry, small_settings());
    CHECK(picture.height == 96);
    CHECK(count_shown(picture) > picture.width * picture.height / 20);
    const Image layers = layers_picture(tube, geometry, small_settings());
    CHECK(layers.height > 2 * 96);
    BodySet bodies;
    bodies.bodies.assign(5, tube.rest);
    const Image sheet = bodies_picture(tube, bodies, 3, small_settings());
    CHECK(count_shown(sheet) > 3 * 100);
}

TEST_CASE("Sections stand in one column a body, at one scale, where they are asked")
{
    const Template tube = test::tube_template();
    BodySet bodies;
    bodies.bodies.assign(3, tube.rest);
    bodies.bodies[1].name = "grown";
    for (Points* points : {&bodies.bodies[1].skin_vertices, &bodies.bodies[1].volume_vertices,
                           &bodies.bodies[1].interior_vertices, &bodies.bodies[1].joint_positions})
        *points *= 1.5;
    PictureSettings settings;
    settings.height = 300;
    // Colours that sections_picture gives fat and the inside of the bone wrap.
    const Pixel fat = pixel_from_linear(linear_from_srgb({0.95f, 0.80f, 0.50f})),
                core = pixel_from_linear(linear_from_srgb({0.72f, 0.74f, 0.78f}));
    const auto area = [&](const std::vector<int>& shown, SectionKind kind, const std::string& joint, double offset,
                          const Pixel& colour) {
        return test::count_pixels(section_sheet(tube, bodies, shown, {kind, joint, offset}, settings), colour);
    };
    const int key = 14 * 14;  // the legend's own patch
    for (const SectionKind kind : {SectionKind::sagittal, SectionKind::coronal}) {
        const int small = area({0}, kind, "left_forearm", 0.0, fat) - key;
        CHECK(small > 100);
        CHECK(area({0}, kind, "left_forearm", 0.0, core) - key > 100);
        // Two of them are twice the area; the tallest one is as tall as asked, so that a small one beside it shrinks.
        CHECK(area({0, 2}, kind, "left_forearm", 0.0, fat) - key == Approx(2 * small).epsilon(0.05));
        CHECK(area({0, 1}, kind, "left_forearm", 0.0, fat) - key == Approx(small * (1.0 + 1.0 / 2.25)).epsilon(0.1));
        // Beside the axis less of the inside is cut.
        CHECK(area({0}, kind, "left_forearm", 0.03, core) < area({0}, kind, "left_forearm", 0.0, core));
    }
    CHECK(area({0}, SectionKind::horizontal, "left_forearm", 0.01, fat) - key > 20);
    CHECK_THROWS_AS(area({0}, SectionKind::sagittal, "tail", 0.0, fat), InputError);
    CHECK_THROWS_AS(area({0}, SectionKind::sagittal, "left_forearm", 3.0, fat), InputError);
}

TEST_CASE("The section of a posed body turns with its joint")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube, test::bending);
    PictureSettings settings;
    settings.height = 300;
    const Pixel fat = pixel_from_linear(linear_from_srgb({0.95f, 0.80f, 0.50f}));
    const auto area = [&](double bend, double turn, const std::string& joint) {
        Pose pose = test::tube_pose(bend);
        pose.parent_from_joint[0] = Eigen::AngleAxisd(turn, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
        const PosedBody posed = poser.pose(tube.rest, pose);
        const Image picture =
            posed_section_picture(posed, skinned_geometry(posed), {SectionKind::coronal, joint, 0.0}, settings);
        return test::count_pixels(picture, fat) - 14 * 14;
    };
    const int straight = area(0.0, 0.0, "left_forearm");
    CHECK(straight > 100);
    CHECK(area(0.0, 0.9, "left_forearm") == Approx(straight).epsilon(0.05));
    // Bent about z, the tube stays in the coronal plane, and takes less height: it is drawn larger.
    CHECK(area(1.2, 0.9, "left_forearm") > straight);
    CHECK_THROWS_AS(area(0.0, 0.0, "tail"), InputError);
}

TEST_CASE("A sheet of frames has one row a sample and one column a method")
{
    const Template tube = test::tube_template();
    const BodyPoser poser(tube);
    BodySet bodies;
    bodies.bodies = {tube.rest, tube.rest};
    PoseSet poses;
    poses.poses = {test::tube_pose(0.0), test::tube_pose(0.5), test::tube_pose(1.0)};
    std::vector<DeformationSet> files(2);
    for (std::size_t k = 0; k < files.size(); ++k) {
        files[k].method = k == 0 ? "FEM" : "LBS";
        files[k].num_volume_vertices = tube.num_volume_vertices();
        for (int pose = 0; pose < 3; ++pose)
            files[k].add({pose % 2, pose}, "test",
                         skinned_geometry(poser.pose(tube.rest, poses.poses[std::size_t(pose)])).volume_vertices);
    }
    PictureSettings settings = small_settings();
    settings.volume_colours = true;
    const Image two = frames_picture(poser, bodies, poses, files, "test", 2, settings);
    const Image all = frames_picture(poser, bodies, poses, files, "test", 10, settings);
    CHECK(all.height - two.height >= 96);

    CHECK_THROWS_AS(frames_picture(poser, bodies, poses, files, "train", 2, settings), InputError);
    files[1].pairs[2] = {1, 1};
    CHECK_THROWS_WITH(frames_picture(poser, bodies, poses, files, "test", 3, settings), Catch::Contains("LBS"));
    poses.poses.resize(1);
    CHECK_THROWS_AS(frames_picture(poser, bodies, poses, {files[0]}, "test", 3, settings), InputError);
}
