// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/anatomy.h"

#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/procedural/bones.h"
#include "ndg/procedural/muscles.h"
#include "ndg/procedural/skin.h"

#include <algorithm>
#include <memory>

namespace ndg {

namespace {

constexpr double mesh_allowance = 0.0011;  // m that the skin's mesh may lie inside its field
constexpr double bone_gap = 0.0006;        // m between muscle and bone
constexpr int cover_rounds = 5, smoothing_steps = 8;
constexpr double lean_girth = -0.55;

bool on_digit(const AnatomyMesh& part)
{
    return part.name.find("phalanx") != std::string::npos || part.name.find("metatarsal") != std::string::npos ||
           part.name.find("metacarpal") != std::string::npos;
}

/// Moves vertices inside the level set field = -depth; what lies too far out takes its neighbours along, so that the
/// part bends rather than dents.
void cover(AnatomyMesh& part, const Field& skin, double depth)
{
    const auto neighbours = vertex_neighbours(part.triangles, static_cast<int>(part.vertices.rows()));
    for (int round = 0; round <= cover_rounds; ++round) {
        Points push = Points::Zero(part.vertices.rows(), 3);
        bool any = false;
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v) {
            const Eigen::Vector3d x = part.vertices.row(v).transpose();
            if (skin.value(x) <= -depth) continue;
            any = true;
            push.row(v) = (skin.project(x, -depth - 1e-5, 20, 0.01) - x).transpose();
        }
        if (!any) return;
        if (round < cover_rounds) {
            const Points wanted = push;
            for (int step = 0; step < smoothing_steps; ++step) {
                Points mean = push;
                for (Eigen::Index v = 0; v < push.rows(); ++v) {
                    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
                    const auto& around = neighbours[v];
                    for (const int n : around) sum += push.row(n);
                    mean.row(v) = sum / static_cast<double>(around.size());
                    if (mean.row(v).squaredNorm() < wanted.row(v).squaredNorm()) mean.row(v) = wanted.row(v);
                }
                push = mean;
            }
        }
        part.vertices += push;
    }
}

/// A bone as an obstacle.
struct Obstacle {
    Eigen::AlignedBox3d box;
    std::unique_ptr<TriangleTree> tree;
};

void keep_out(AnatomyMesh& muscle, const std::vector<Obstacle>& bones)
{
    Eigen::AlignedBox3d box;
    for (Eigen::Index v = 0; v < muscle.vertices.rows(); ++v) box.extend(muscle.vertices.row(v).transpose());
    for (const Obstacle& bone : bones) {
        if (!bone.box.intersects(box)) continue;
        for (Eigen::Index v = 0; v < muscle.vertices.rows(); ++v) {
            const Eigen::Vector3d x = muscle.vertices.row(v).transpose();
            if (!bone.box.contains(x)) continue;
            ClosestPoint nearest;
            const double distance = bone.tree->signed_distance(x, &nearest);
            if (distance >= bone_gap) continue;
            const Eigen::Vector3d away = distance < 0.0 ? nearest.point - x : x - nearest.point;
            if (away.norm() > 1e-9) muscle.vertices.row(v) = (nearest.point + bone_gap * away.normalized()).transpose();
        }
    }
}

}  // namespace

std::vector<AnatomyMesh> procedural_anatomy(const BodyLayout& layout)
{
    const Field skin = skin_field(layout);
    const Field lean_skin = skin_field(layout.leaner(lean_girth));
    std::vector<AnatomyMesh> anatomy = procedural_bones(layout);
    const std::size_t num_bones = anatomy.size();
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < num_bones; ++i)
        cover(anatomy[i], skin, (on_digit(anatomy[i]) ? digit_bone_cover : bone_cover) + mesh_allowance);

    std::vector<Obstacle> obstacles(num_bones);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < num_bones; ++i) {
        for (Eigen::Index v = 0; v < anatomy[i].vertices.rows(); ++v)
            obstacles[i].box.extend(anatomy[i].vertices.row(v).transpose());
        obstacles[i].box.min().array() -= bone_gap;
        obstacles[i].box.max().array() += bone_gap;
        obstacles[i].tree = std::make_unique<TriangleTree>(anatomy[i].vertices, anatomy[i].triangles);
    }
    std::vector<AnatomyMesh> muscles = procedural_muscles(layout, lean_skin);
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < muscles.size(); ++i)
        for (int round = 0; round < 2; ++round) {
            keep_out(muscles[i], obstacles);
            cover(muscles[i], skin, muscle_cover + mesh_allowance);
        }
    std::move(muscles.begin(), muscles.end(), std::back_inserter(anatomy));
    return anatomy;
}

}  // namespace ndg
