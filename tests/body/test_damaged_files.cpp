// SPDX-License-Identifier: Apache-2.0
// Files with wrong content are refused with a sentence that says what is wrong.
#include "file_samples.h"
#include "support/support.h"

#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

TEST_CASE("Damaged templates are refused", "[files]")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("template.h5");
    Template tube = tube_template(5, 6);
    tube.source_vertices = RowMatrixI::Zero(tube.rest.skin_vertices.rows(), 3);
    tube.source_barycentric = RowMatrix::Constant(tube.rest.skin_vertices.rows(), 3, 1.0 / 3.0);
    tube.source_joint_offsets = Points::Zero(num_standard_joints, 3);
    tube.examples = {{"person", tube.rest.skin_vertices, tube.rest.joint_positions}};
    write_template(path, tube, example_provenance());
    const std::vector<Damage> damages = {
        {"put('/examples/skin_vertices', f['/examples/skin_vertices'][:, :31])", {"/examples/skin_vertices", "31"}},
        {"f['/examples/skin_vertices'][0, 3, 2] = np.nan", {"/examples/skin_vertices", "nan"}},
        {"del f['/examples/joint_positions']", {"/examples/joint_positions"}},
        {"f.attrs['format'] = 'ndg-bodies'", {"ndg-bodies", "ndg-template"}},
        {"f.attrs['format_version'] = 77", {"2"}},
        {"del f['/skin/vertices']", {"/skin/vertices"}},
        {"f['/skin/vertices'][3, 1] = np.nan", {"/skin/vertices", "nan"}},
        {"f['/skin/triangles'][7, 2] = 32", {"/skin/triangles", "32"}},
        {"f['/skin/triangles'][7, 2] = -1", {"/skin/triangles", "-1"}},
        {"put('/skin/weights', f['/skin/weights'][:31])", {"/skin/weights", "31"}},
        {"f['/skin/weights'][4, 0] = 0.25", {"/skin/weights[4]", "sums to"}},
        {"f['/skin/weights'][4, :2] = (1.5, -0.5)", {"/skin/weights[4, 0]", "1.5"}},
        {"f['/skin/weight_joints'][4, 0] = 60", {"/skin/weight_joints", "60"}},
        {"put('/skeleton/parents', f['/skeleton/parents'][:59])", {"/skeleton/parents"}},
        {"f['/skeleton/parents'][4] = 7", {"/skeleton/parents[4]", "7"}},
        {"f['/skeleton/parents'][4] = 1", {"/skeleton/parents[4]", "1"}},
        {"names = f['/skeleton/joint_names'].asstr()[...]; names[8] = 'skull'; put('/skeleton/joint_names', names)",
         {"/skeleton/joint_names[8]", "skull", "head"}},
        {"f['/skeleton/joint_positions'][59, 0] = np.inf", {"/skeleton/joint_positions", "inf"}},
        {"f['/volume/wrap_to_skin'][3] = 4", {"/volume/wrap_to_skin[4]", "4"}},
        {"f['/volume/wrap_to_skin'][3] = 99", {"/volume/wrap_to_skin", "99"}},
        {"f['/volume/prisms'][0, 0] = 31", {"/volume/prisms[0]"}},
        {"put('/volume/prisms', f['/volume/prisms'][:-1])", {"/volume/prisms", "95"}},
        {"f['/volume/vertices'][35] *= 0.1", {"/volume", "Jacobian"}},
        {"f['/bone_interior/vertices'][2, 1] += 1.0", {"/bone_interior/tetrahedra", "volume"}},
        {"f['/bone_interior/tetrahedra'][2, 1] = 35", {"/bone_interior/tetrahedra", "35"}},
        {"f['/bone_interior/weights'][1] = 0", {"/bone_interior/weights[1]", "0"}},
        {"f['/anatomy/part_ranges'][1, 1] = 70", {"/anatomy/part_ranges[1]", "70"}},
        {"f['/anatomy/part_ranges'][1, 0] = 40", {"/anatomy/triangles[60]", "muscle"}},
        {"put('/anatomy/part_layers', ['bone', 'hair'])", {"/anatomy/part_layers[1]", "hair"}},
        {"put('/anatomy/part_layers', ['bone'])", {"/anatomy/part_layers"}},
        {"f['/anatomy/triangles'][0, 0] = 64", {"/anatomy/triangles", "64"}},
        {"f['/anatomy/embedding_elements'][0] = 168", {"/anatomy/embedding_elements", "168"}},
        {"f['/anatomy/embedding_vertices'][0, 0] = 95", {"/anatomy/embedding_vertices", "95"}},
        {"f['/anatomy/embedding_weights'][9] += 0.1", {"/anatomy/embedding_weights[9]"}},
        {"f['/anatomy/embedding_distances'][9] = -0.1", {"/anatomy/embedding_distances[9]", "-0.1"}},
        {"f['/source/barycentric'][9, 0] = 0.5", {"/source/barycentric[9]"}},
        {"f['/source/vertices'][9, 0] = -2", {"/source/vertices", "-2"}},
        {"put('/source/vertices', f['/source/vertices'][:9])", {"/source/vertices", "9"}},
    };
    check_damages(path, damages, [](const std::string& copy) { read_template(copy); });
}

TEST_CASE("Damaged bodies and skins are refused", "[files]")
{
    const TemporaryFolder folder;
    const Template tube = tube_template(5, 6);
    const BodySet bodies = example_bodies(tube);
    write_bodies(folder.file("bodies.h5"), bodies, example_provenance());
    write_skins(folder.file("skins.h5"), skins_of(bodies), example_provenance());
    const std::vector<Damage> common = {
        {"f['/bodies/skin_vertices'][1, 3, 2] = np.nan", {"/bodies/skin_vertices", "nan"}},
        {"put('/bodies/skin_vertices', f['/bodies/skin_vertices'][:, :31])", {"/bodies/skin_vertices", "31"}},
        {"put('/bodies/joint_positions', f['/bodies/joint_positions'][:2])", {"/bodies/joint_positions", "2 x 60"}},
        {"put('/bodies/parameters', f['/bodies/parameters'][:, :1])", {"/bodies/parameters"}},
        {"f['/bodies/parameters'][0, 1] = np.inf", {"/bodies/parameters", "inf"}},
        {"put('/bodies/names', f['/bodies/names'][:2])", {"/bodies/"}},
        {"del f.attrs['template_sha256']", {"template_sha256"}},
    };
    check_damages(folder.file("skins.h5"), common, [&](const std::string& copy) { read_skins(copy, tube); });
    const std::vector<Damage> damages = {
        {"f['/bodies/volume_vertices'][2, 35] *= 0.1", {"/bodies/volume_vertices[2] (body_2)", "Jacobian"}},
        {"f['/bodies/volume_vertices'][2, 35, 0] = np.nan", {"/bodies/volume_vertices", "nan"}},
        {"put('/bodies/volume_vertices', f['/bodies/volume_vertices'][..., :2])",
         {"/bodies/volume_vertices", "90 x 2"}},
        {"del f['/bodies/interior_vertices']", {"/bodies/interior_vertices"}},
        {"f.attrs['format'] = 'ndg-skins'", {"ndg-skins"}},
    };
    const auto read = [&](const std::string& copy) { read_bodies(copy, tube); };
    check_damages(folder.file("bodies.h5"), common, read);
    check_damages(folder.file("bodies.h5"), damages, read);
}

TEST_CASE("Damaged poses are refused", "[files]")
{
    const TemporaryFolder folder;
    PoseSet poses = example_poses();
    poses.spliced_from = RowMatrixI::Constant(3, 6, -1);
    poses.spliced_from.row(2) << 0, 5, 1, 12, 1, 90;
    write_poses(folder.file("poses.h5"), poses, example_provenance());
    const std::vector<Damage> damages = {
        {"f['/poses/spliced_from'][2, 4] = 2", {"/poses/spliced_from[2]", "clip 2", "there are 2"}},
        {"f['/poses/spliced_from'][2, 3] = -1", {"/poses/spliced_from[2]", "-1 beside"}},
        {"f['/poses/spliced_from'][1, 0] = 0", {"/poses/spliced_from[1]", "-1 beside"}},
        {"put('/poses/spliced_from', f['/poses/spliced_from'][:2])", {"/poses/spliced_from"}},
        {"f['/poses/rotations'][1, 7, 0] = 1.1", {"/poses/rotations[1, 7]", "rotation"}},
        {"f['/poses/rotations'][1, 7] *= -1", {"/poses/rotations[1, 7]", "determinant -1"}},
        {"f['/poses/rotations'][2, 59] = 0", {"/poses/rotations[2, 59]", "rotation"}},
        {"f['/poses/rotations'][0, 0, 0] = np.nan", {"/poses/rotations", "nan"}},
        {"put('/poses/rotations', f['/poses/rotations'][:, :59])", {"/poses/rotations", "3 x 59 x 9"}},
        {"put('/poses/rotations', f['/poses/rotations'][:2])", {"/poses/root_translations"}},
        {"f['/poses/clip_idx'][2] = 2", {"/poses/clip_idx", "2"}},
        {"f['/poses/frame_idx'][2] = -5", {"/poses/frame_idx", "-5"}},
        {"put('/poses/covering_radius', f['/poses/covering_radius'][:2])", {"/poses/covering_radius", "2 values"}},
        {"put('/clips/frame_rates', f['/clips/frame_rates'][:1])", {"/clips/frame_rates"}},
        {"names = f['/skeleton/joint_names'].asstr()[...]; names[2] = 'spine_9'; put('/skeleton/joint_names', names)",
         {"/skeleton/joint_names[2]", "spine_9"}},
    };
    check_damages(folder.file("poses.h5"), damages, [](const std::string& copy) { read_poses(copy); });
}

TEST_CASE("Damaged shape spaces are refused", "[files]")
{
    const TemporaryFolder folder;
    write_example_shape_space(folder.file("space.h5"), example_bodies(tube_template(3, 4)));
    const std::vector<Damage> damages = {
        {"f['/shape_space/components'][...] *= 1.01", {"/shape_space/components", "orthonormal"}},
        {"f['/shape_space/components'][:, 0] = f['/shape_space/components'][:, 1]", {"orthonormal"}},
        {"f['/shape_space/components'][5, 0] = np.nan", {"/shape_space/components", "nan"}},
        {"put('/shape_space/mean', f['/shape_space/mean'][:-1])", {"/shape_space/mean", "107"}},
        {"put('/shape_space/mean', f['/shape_space/mean'][:-3])", {"/shape_space/components"}},
        {"put('/shape_space/standard_deviations', [1.0])", {"/shape_space/standard_deviations"}},
        {"f['/shape_space/standard_deviations'][1] = 0", {"/shape_space/standard_deviations[1]", "0"}},
        {"del f.attrs['explained_variance']", {"explained_variance"}},
    };
    check_damages(folder.file("space.h5"), damages, [](const std::string& copy) { read_shape_space(copy); });
}
