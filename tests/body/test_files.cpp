// SPDX-License-Identifier: Apache-2.0
// What is written is read back, by us and by h5py.
#include "file_samples.h"
#include "ndg/body/stored_pose.h"
#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "support/support.h"

#include <fmt/format.h>
#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

namespace {

void check_equal(const SkinningWeights& a, const SkinningWeights& b)
{
    CHECK(a.joints == b.joints);
    CHECK(a.weights == b.weights);
}

void check_template(const Template& a, const Template& b)
{
    CHECK(a.skeleton.joint_names == b.skeleton.joint_names);
    CHECK(a.skeleton.parents == b.skeleton.parents);
    CHECK(a.skin_triangles == b.skin_triangles);
    check_equal(a.skin_weights, b.skin_weights);
    CHECK(a.wrap_to_skin == b.wrap_to_skin);
    CHECK(a.wrap_triangles == b.wrap_triangles);
    CHECK(a.prisms == b.prisms);
    CHECK(a.tetrahedra == b.tetrahedra);
    check_equal(a.interior_weights, b.interior_weights);
    CHECK(a.anatomy_triangles == b.anatomy_triangles);
    CHECK(a.anatomy_vertices == b.anatomy_vertices);
    REQUIRE(a.anatomy_parts.size() == b.anatomy_parts.size());
    for (std::size_t i = 0; i < a.anatomy_parts.size(); ++i) {
        CHECK(a.anatomy_parts[i].name == b.anatomy_parts[i].name);
        CHECK(a.anatomy_parts[i].layer == b.anatomy_parts[i].layer);
        CHECK(a.anatomy_parts[i].side == b.anatomy_parts[i].side);
        CHECK(a.anatomy_parts[i].fma_id == b.anatomy_parts[i].fma_id);
        CHECK(a.anatomy_parts[i].vertex_begin == b.anatomy_parts[i].vertex_begin);
        CHECK(a.anatomy_parts[i].vertex_end == b.anatomy_parts[i].vertex_end);
        CHECK(a.anatomy_parts[i].triangle_begin == b.anatomy_parts[i].triangle_begin);
        CHECK(a.anatomy_parts[i].triangle_end == b.anatomy_parts[i].triangle_end);
    }
    CHECK(a.skin_region_names == b.skin_region_names);
    CHECK(a.skin_regions == b.skin_regions);
    CHECK(a.source_name == b.source_name);
    CHECK(a.source_joint_offsets == b.source_joint_offsets);
    CHECK(a.anatomy_weights.joints == b.anatomy_weights.joints);
    CHECK(a.anatomy_weights.weights == b.anatomy_weights.weights);
    REQUIRE(a.landmarks.size() == b.landmarks.size());
    for (std::size_t i = 0; i < a.landmarks.size(); ++i) {
        CHECK(a.landmarks[i].name == b.landmarks[i].name);
        CHECK(a.landmarks[i].skin_triangle_idx == b.landmarks[i].skin_triangle_idx);
        CHECK(a.landmarks[i].barycentric == b.landmarks[i].barycentric);
    }
    CHECK(a.embedding.elements == b.embedding.elements);
    CHECK(a.embedding.vertices == b.embedding.vertices);
    CHECK(a.embedding.weights == b.embedding.weights);
    CHECK(a.embedding.distances == b.embedding.distances);
    CHECK(a.rest.name == b.rest.name);
    CHECK(a.rest.skin_vertices == b.rest.skin_vertices);
    CHECK(a.rest.volume_vertices == b.rest.volume_vertices);
    CHECK(a.rest.interior_vertices == b.rest.interior_vertices);
    CHECK(a.rest.joint_positions == b.rest.joint_positions);
    CHECK(a.source_vertices == b.source_vertices);
    CHECK(a.source_barycentric == b.source_barycentric);
    REQUIRE(a.examples.size() == b.examples.size());
    for (std::size_t e = 0; e < a.examples.size(); ++e) {
        CHECK(a.examples[e].skin_vertices == b.examples[e].skin_vertices);
        CHECK(a.examples[e].joint_positions == b.examples[e].joint_positions);
    }
}

double largest_difference(const Points& a, const Points& b)
{
    REQUIRE(a.rows() == b.rows());
    return a.rows() == 0 ? 0.0 : (a - b).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("Templates come back from their file exactly", "[files]")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("template.h5");
    Template tube = tube_template(5, 6);
    const Eigen::Index num_skin = tube.rest.skin_vertices.rows();
    tube.source_vertices = RowMatrixI::Constant(num_skin, 3, 17);
    tube.source_barycentric = RowMatrix::Constant(num_skin, 3, 1.0 / 3.0);
    tube.source_name = "procedural";
    tube.source_joint_offsets = Points::Constant(num_standard_joints, 3, 0.01);
    // Examples are stored in single precision.
    for (const double height : {1.5, 1.75}) {
        tube.examples.push_back(
            {"person", Points::Constant(num_skin, 3, height), Points::Constant(num_standard_joints, 3, 0.5 * height)});
    }
    tube.skin_region_names = {"body", "head"};
    tube.skin_regions.assign(tube.skin_triangles.rows(), 1);
    tube.landmarks = {{"top", 3, {0.2, 0.3, 0.5}}};
    tube.anatomy_parts[1].fma_id = 22431;
    tube.anatomy_parts[1].side = BodySide::left;
    tube.embedding.elements[5] = -1;
    tube.embedding.weights.row(5).setZero();
    tube.embedding.vertices.row(5).setZero();
    write_template(path, tube, example_provenance());
    const Template back = read_template(path);
    check_template(back, tube);
    CHECK(back.file_sha256 == sha256_path(path));
    check_by_h5py(path, "ndg-template",
                  "{'/skeleton/joint_names': (60,), '/skeleton/parents': (60,), '/skeleton/joint_positions': (60, 3),"
                  " '/skin/vertices': (32, 3), '/skin/triangles': (60, 3), '/skin/weight_joints': (32, 8),"
                  " '/skin/weights': (32, 8), '/volume/wrap_to_skin': (30,), '/volume/wrap_triangles': (48, 3),"
                  " '/volume/prisms': (96, 6), '/volume/vertices': (90, 3), '/bone_interior/vertices': (5, 3),"
                  " '/bone_interior/tetrahedra': (72, 4), '/bone_interior/weight_joints': (5, 8),"
                  " '/bone_interior/weights': (5, 8), '/anatomy/vertices': (64, 3), '/anatomy/triangles': (120, 3),"
                  " '/anatomy/part_names': (2,), '/anatomy/part_layers': (2,), '/anatomy/part_ranges': (2, 4),"
                  " '/anatomy/embedding_elements': (64,), '/anatomy/embedding_vertices': (64, 6),"
                  " '/anatomy/embedding_weights': (64, 6), '/anatomy/embedding_distances': (64,),"
                  " '/anatomy/part_sides': (2,), '/anatomy/part_fma_ids': (2,), '/anatomy/weight_joints': (64, 8),"
                  " '/anatomy/weights': (64, 8), '/skin/regions': (60,), '/skin/region_names': (2,),"
                  " '/landmarks/names': (1,), '/landmarks/skin_triangles': (1,), '/landmarks/barycentric': (1, 3),"
                  " '/source/vertices': (32, 3), '/source/barycentric': (32, 3), '/source/joint_offsets': (60, 3),"
                  " '/examples/skin_vertices': (2, 32, 3), '/examples/joint_positions': (2, 60, 3)}",
                  2);
}

TEST_CASE("A template without source, anatomy and bone interior is a template", "[files]")
{
    const TemporaryFolder folder;
    Template tube = tube_template(3, 4);
    tube.anatomy_vertices.resize(0, 3);
    tube.anatomy_triangles.resize(0, 3);
    tube.anatomy_parts.clear();
    tube.embedding = Embedding();
    tube.anatomy_weights = SkinningWeights();
    tube.tetrahedra.resize(0, 4);
    tube.rest.interior_vertices.resize(0, 3);
    tube.interior_weights = SkinningWeights();
    write_template(folder.file("template.h5"), tube, example_provenance());
    const Template back = read_template(folder.file("template.h5"));
    check_template(back, tube);

    const BodySet bodies = example_bodies(back);
    write_bodies(folder.file("bodies.h5"), bodies, example_provenance());
    CHECK(read_bodies(folder.file("bodies.h5"), back).bodies[2].interior_vertices.rows() == 0);
}

TEST_CASE("Bodies and skins come back in single precision", "[files]")
{
    const TemporaryFolder folder;
    const Template tube = tube_template(5, 6);
    const BodySet bodies = example_bodies(tube);
    write_bodies(folder.file("bodies.h5"), bodies, example_provenance());
    write_skins(folder.file("skins.h5"), skins_of(bodies), example_provenance());
    const BodySet back = read_bodies(folder.file("bodies.h5"), tube);
    const SkinSet skins = read_skins(folder.file("skins.h5"), tube);
    REQUIRE(back.bodies.size() == 3);
    REQUIRE(skins.bodies.size() == 3);
    CHECK(back.parameter_names == bodies.parameter_names);
    CHECK(back.parameters == bodies.parameters);
    CHECK(skins.parameters == bodies.parameters);
    for (std::size_t i = 0; i < 3; ++i) {
        const Body &body = bodies.bodies[i], &read = back.bodies[i];
        const Skin& skin = skins.bodies[i];
        CHECK(read.name == body.name);
        CHECK(skin.name == body.name);
        CHECK(largest_difference(read.skin_vertices, body.skin_vertices) < 1e-7);
        CHECK(largest_difference(read.volume_vertices, body.volume_vertices) < 1e-7);
        CHECK(largest_difference(read.interior_vertices, body.interior_vertices) < 1e-7);
        CHECK(largest_difference(read.joint_positions, body.joint_positions) < 1e-6);
        CHECK(largest_difference(skin.skin_vertices, body.skin_vertices) < 1e-7);
        CHECK(largest_difference(skin.joint_positions, body.joint_positions) < 1e-6);
    }
    const std::string common =
        "'/bodies/names': (3,), '/bodies/parameter_names': (2,), '/bodies/parameters': (3, 2),"
        " '/bodies/skin_vertices': (3, 32, 3), '/bodies/joint_positions': (3, 60, 3)";
    check_by_h5py(folder.file("skins.h5"), "ndg-skins", "{" + common + "}");
    check_by_h5py(folder.file("bodies.h5"), "ndg-bodies",
                  "{" + common + ", '/bodies/volume_vertices': (3, 90, 3), '/bodies/interior_vertices': (3, 5, 3)}");
}

TEST_CASE("Bodies without parameters are bodies; none, or uneven ones, are refused", "[files]")
{
    const TemporaryFolder folder;
    const Template tube = tube_template(3, 3);
    BodySet bodies = example_bodies(tube);
    bodies.parameter_names.clear();
    bodies.parameters.resize(0, 0);
    write_skins(folder.file("skins.h5"), skins_of(bodies), example_provenance());
    CHECK(read_skins(folder.file("skins.h5"), tube).parameters.cols() == 0);

    bodies.bodies[1].volume_vertices.conservativeResize(3, 3);
    CHECK_THROWS_AS(write_bodies(folder.file("uneven.h5"), bodies, example_provenance()), Error);
    CHECK_THROWS_AS(write_bodies(folder.file("none.h5"), BodySet(), example_provenance()), Error);
    CHECK_THROWS_AS(read_bodies(folder.file("uneven.h5"), tube), InputError);
}

TEST_CASE("Bodies know the template they belong to", "[files]")
{
    const TemporaryFolder folder;
    write_template(folder.file("a.h5"), tube_template(3, 4), example_provenance());
    Provenance other = example_provenance();
    other.config_json = "{}";
    write_template(folder.file("b.h5"), tube_template(3, 4), other);
    const Template a = read_template(folder.file("a.h5")), b = read_template(folder.file("b.h5"));
    BodySet bodies = example_bodies(a);
    bodies.template_sha256 = a.file_sha256;
    write_bodies(folder.file("bodies.h5"), bodies, example_provenance());
    CHECK(read_bodies(folder.file("bodies.h5"), a).template_sha256 == a.file_sha256);
    CHECK_THROWS_AS(read_bodies(folder.file("bodies.h5"), b), InputError);
    CHECK_THROWS_AS(read_bodies(folder.file("bodies.h5"), tube_template(3, 5)), InputError);
}

TEST_CASE("Poses come back as rotations to double precision", "[files]")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("poses.h5");
    const PoseSet poses = example_poses();
    write_poses(path, poses, example_provenance());
    const PoseSet back = read_poses(path);
    REQUIRE(back.size() == 3);
    for (std::size_t i = 0; i < 3; ++i) {
        for (std::size_t j = 0; j < 60; ++j) {
            const Eigen::Matrix3d& read = back.poses[i].parent_from_joint[j];
            CHECK((read - poses.poses[i].parent_from_joint[j]).norm() < 3e-7);
            CHECK((read * read.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-15);
        }
        CHECK(back.poses[i].root_translation == poses.poses[i].root_translation);
        CHECK(as_stored(poses.poses[i]).parent_from_joint == back.poses[i].parent_from_joint);
    }
    CHECK(back.poses[0].parent_from_joint[5] == Eigen::Matrix3d::Identity());
    CHECK(back.clip_idx == poses.clip_idx);
    CHECK(back.frame_idx == poses.frame_idx);
    CHECK(back.clip_names == poses.clip_names);
    CHECK(back.clip_frame_rates == poses.clip_frame_rates);
    CHECK(back.covering_radius == poses.covering_radius);
    check_by_h5py(path, "ndg-poses",
                  "{'/skeleton/joint_names': (60,), '/poses/rotations': (3, 60, 9), '/poses/root_translations': (3, 3),"
                  " '/poses/clip_idx': (3,), '/poses/frame_idx': (3,), '/poses/covering_radius': (3,),"
                  " '/clips/names': (2,), '/clips/frame_rates': (2,)}");

    CHECK(back.spliced_from.rows() == 0);
    CHECK_FALSE(back.is_spliced(2));

    PoseSet spliced = poses;
    spliced.spliced_from = RowMatrixI::Constant(3, 6, -1);
    spliced.spliced_from.row(2) << 0, 5, 1, 12, 1, 90;
    write_poses(folder.file("spliced.h5"), spliced, example_provenance());
    const PoseSet spliced_back = read_poses(folder.file("spliced.h5"));
    CHECK(spliced_back.spliced_from == spliced.spliced_from);
    CHECK(spliced_back.is_spliced(2));
    CHECK_FALSE(spliced_back.is_spliced(0));

    PoseSet plain = poses;
    plain.covering_radius.clear();
    write_poses(folder.file("plain.h5"), plain, example_provenance());
    CHECK(read_poses(folder.file("plain.h5")).covering_radius.empty());
    CHECK_THROWS_AS(write_poses(folder.file("none.h5"), PoseSet(), example_provenance()), Error);
}

TEST_CASE("Shape spaces come back", "[files]")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("shape_space.h5");
    const BodySet bodies = example_bodies(tube_template(3, 4));
    const ShapeSpace space = example_shape_space(bodies);
    REQUIRE(space.dimension() == 2);
    write_example_shape_space(path, bodies);
    const ShapeSpace back = read_shape_space(path);
    CHECK(back.mean == space.mean);
    CHECK((back.components - space.components).cwiseAbs().maxCoeff() < 1e-7);
    CHECK(back.standard_deviations == space.standard_deviations);
    CHECK(back.explained_variance == space.explained_variance);
    check_by_h5py(path, "ndg-shape-space",
                  "{'/shape_space/mean': (108,), '/shape_space/components': (108, 2),"
                  " '/shape_space/standard_deviations': (2,), '/shape_space/codes': (3, 2),"
                  " '/shape_space/reconstruction_errors': (3,)}");
}
