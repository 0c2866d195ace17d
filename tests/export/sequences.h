// SPDX-License-Identifier: Apache-2.0
// A small sequence for the tests of writers.
#pragma once

#include "ndg/export/mesh_sequence.h"

namespace ndg::test {

/// A translucent tetrahedron, a solid one and two coloured triangles with a scalar; each frame lies 1 m higher.
inline MeshSequence body_like(int num_frames = 1)
{
    const Triangles faces = (Triangles(4, 3) << 0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2).finished();
    MeshSequence sequence;
    sequence.meshes = {{"skin", faces, {0.8f, 0.7f, 0.6f}, 0.4f},
                       {"bones", faces, {1.0f, 0.6f, 0.2f}},
                       {"muscle_wrap", faces.topRows(2), {1, 0, 0}}};
    sequence.num_frames = num_frames;
    sequence.credits = "CC0 1.0";
    sequence.frame = [](int frame_idx) {
        Points corners = (Points(4, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1).finished();
        corners.col(1).array() += frame_idx;
        Eigen::VectorXf depth(4);
        depth << 0.25f, -0.5f, 2.0f, 0.0f;
        return std::vector<MeshFrame>{
            {corners}, {0.5 * corners}, {corners, VertexColours::Constant(4, 3, 0.5f), {{"depth", depth}}}};
    };
    return sequence;
}

/// body_like with its skin on two joints, the second of which turns; one morph.
inline MeshSequence rig_like(int num_frames = 1)
{
    MeshSequence sequence = body_like(num_frames);
    Rig rig;
    rig.rest_vertices = (Points(4, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1).finished();
    rig.joint_names = {"pelvis", "spine_1"};
    rig.parents = {-1, 0};
    rig.joint_positions = (Points(2, 3) << 0, 0.25, 0, 0, 0.75, 0).finished();
    rig.weight_joints = RowMatrixI::Zero(4, 4);
    rig.weight_joints.col(1).setOnes();
    rig.weights = RowMatrix::Zero(4, 4);
    rig.weights.leftCols(2) << 1, 0, 0.75, 0.25, 0, 1, 0.5, 0.5;
    for (int f = 0; f < num_frames; ++f)
        rig.rotations.push_back(
            {Eigen::Quaterniond::Identity(), Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * f, Eigen::Vector3d::UnitZ()))});
    rig.root_translations = Points::Constant(num_frames, 3, 0.5);
    rig.morphs = {Points::Constant(4, 3, 0.125)};
    rig.morph_weights = RowMatrix::Ones(num_frames, 1);
    sequence.rig = rig;
    return sequence;
}

/// One prism and one tetrahedron over files that need not be there; each frame lies 1 m higher.
inline MeshSequence volume_like(int num_frames = 1)
{
    MeshSequence sequence;
    sequence.num_frames = num_frames;
    sequence.credits = "CC0 1.0 \"& more\"";
    VolumeSequence volume;
    volume.grids = {
        {"flesh", CellKind::wedge, {"/a/template.h5", "/volume/prisms", {1, 6}}, {{"layer", Eigen::VectorXf::Ones(1)}}},
        {"bone_interior", CellKind::tetrahedron, {"/a/template.h5", "/bone_interior/tetrahedra", {1, 4}}, {}}};
    volume.frame = [num_frames](int frame_idx) {
        Points corners = (Points(6, 3) << 0, 0, 1, 1, 0, 1, 0, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0).finished().rowwise() +
                         Eigen::RowVector3d(0, frame_idx, 0);
        VolumeFrame flesh, inside;
        flesh.vertices = corners;
        flesh.stored_vertices = {"/a/samples.h5", "/deformations/vertices", {std::size_t(num_frames), 6, 3}, frame_idx};
        flesh.point_fields["error"] = Eigen::VectorXf::LinSpaced(6, 0.0f, float(frame_idx));
        inside.vertices = corners.topRows(4);
        inside.cell_fields["determinant"] = Eigen::VectorXf::Constant(1, 1.0f + float(frame_idx));
        return std::vector<VolumeFrame>{flesh, inside};
    };
    sequence.volume = volume;
    return sequence;
}

}  // namespace ndg::test
