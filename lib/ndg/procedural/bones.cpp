// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/bones.h"

#include "ndg/core/error.h"
#include "ndg/geometry/isosurface.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace ndg {

namespace {

std::vector<double> even_axis(double low, double high, double cell)
{
    const int steps = std::max(3, static_cast<int>(std::ceil((high - low) / cell)));
    std::vector<double> planes;
    for (int s = 0; s <= steps; ++s) planes.push_back(low + (high - low) * s / steps);
    return planes;
}

std::string with_side(const std::string& side, std::string name)
{
    name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[0])));
    return side + " " + name;
}

}  // namespace

AnatomyMesh mesh_bone(const BoneSketch& sketch)
{
    const double cell = 0.75 * sketch.edge_length;
    Eigen::AlignedBox3d box = sketch.field.bounds();
    if (!sketch.paired) {  // drawn on the left and mirrored
        const double reach = std::max(std::abs(box.min().x()), std::abs(box.max().x()));
        box.min().x() = -reach;
        box.max().x() = reach;
    }
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(2.0 * cell);
    const Eigen::Vector3d low = box.min() - margin, high = box.max() + margin;
    const GridAxes axes = {even_axis(low.x(), high.x(), cell), even_axis(low.y(), high.y(), cell),
                           even_axis(low.z(), high.z(), cell)};
    TriangleMesh mesh = marching_tetrahedra([&](const Eigen::Vector3d& x) { return sketch.field.value(x); }, axes);
    require(mesh.triangles.rows() > 0, "procedural body: the {} has no surface", sketch.name);
    std::vector<int> labels(mesh.triangles.rows(), 0);
    mesh = remesh_graded(mesh, labels, {sketch.edge_length});
    AnatomyMesh part;
    part.name = sketch.paired ? with_side("Left", sketch.name) : sketch.name;
    part.fma_id = sketch.fma_left;
    part.side = sketch.paired ? BodySide::left : BodySide::middle;
    part.layer = AnatomyLayer::bone;
    part.joint = sketch.joint;
    part.vertices = mesh.vertices;
    part.triangles = mesh.triangles;
    const std::string defect = closed_surface_defect(part.vertices, part.triangles);
    require(defect.empty(), "procedural body: the {} is not a closed surface: {}", sketch.name, defect);
    return part;
}

AnatomyMesh mirrored_part(const AnatomyMesh& left, int fma_id)
{
    AnatomyMesh right = left;
    right.name = "Right" + left.name.substr(4);
    right.fma_id = fma_id;
    right.side = BodySide::right;
    if (left.joint.rfind("left_", 0) == 0) right.joint = "right_" + left.joint.substr(5);
    right.vertices.col(0) *= -1.0;
    right.triangles.col(1).swap(right.triangles.col(2));
    return right;
}

std::vector<AnatomyMesh> procedural_bones(const BodyLayout& layout)
{
    std::vector<BoneSketch> sketches = head_bone_sketches(layout);
    for (auto* draw : {&trunk_bone_sketches, &limb_bone_sketches, &hand_bone_sketches, &foot_bone_sketches}) {
        std::vector<BoneSketch> more = (*draw)(layout);
        std::move(more.begin(), more.end(), std::back_inserter(sketches));
    }
    std::vector<AnatomyMesh> bones;
    for (const BoneSketch& sketch : sketches) {
        bones.push_back(mesh_bone(sketch));
        if (sketch.paired) bones.push_back(mirrored_part(bones.back(), sketch.fma_right));
    }
    return bones;
}

}  // namespace ndg
