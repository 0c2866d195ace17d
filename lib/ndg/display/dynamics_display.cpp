// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/dynamics_display.h"

#include "ndg/core/error.h"
#include "ndg/page/surface_page.h"

#include <algorithm>
#include <iterator>

namespace ndg {

namespace {

const Eigen::Vector3f skin_colour(0.86f, 0.68f, 0.58f), obstacle_colour(0.55f, 0.6f, 0.65f),
    garment_colour(0.25f, 0.4f, 0.6f);

}  // namespace

DynamicsDisplay::DynamicsDisplay(const DynamicsReader& reader, const Avatar* avatar) : reader_(reader), avatar_(avatar)
{
    const DynamicsSet& set = reader.set();
    const auto is_soft = [&](int vertex) { return static_cast<char>(vertex >= set.num_held ? 1 : 0); };
    if (avatar != nullptr) {
        require_input(set.skin_triangles.rows() == avatar->skin_triangles.rows() && set.skin_triangles.rows() > 0,
                      "a skin of {} triangles in motion is not that of the avatar, which has {}",
                      set.skin_triangles.rows(), avatar->skin_triangles.rows());
        body_begin_ = set.skin_triangles(0, 0) - avatar->skin_triangles(0, 0);
        require_input(body_begin_ >= 0 && body_begin_ + avatar->num_vertices() <= set.num_vertices() &&
                          (set.skin_triangles.array() - body_begin_ == avatar->skin_triangles.array()).all() &&
                          set.rest.middleRows(body_begin_, avatar->num_vertices()) == avatar->rest,
                      "what moves is not this avatar, {}", avatar->name);
        triangles_ = avatar->whole_skin_triangles;
        rest_ = avatar->skin_vertices;
        for (const int vertex : avatar->volume_vertex_of_skin) {
            soft_.push_back(vertex < 0 ? char(0) : is_soft(body_begin_ + vertex));
        }
        return;
    }
    vertices_.assign(set.skin_triangles.data(), set.skin_triangles.data() + set.skin_triangles.size());
    std::sort(vertices_.begin(), vertices_.end());
    vertices_.erase(std::unique(vertices_.begin(), vertices_.end()), vertices_.end());
    triangles_ = set.skin_triangles.unaryExpr([&](int vertex) {
        return static_cast<int>(std::lower_bound(vertices_.begin(), vertices_.end(), vertex) - vertices_.begin());
    });
    rest_ = set.rest(vertices_, Eigen::all);
    std::transform(vertices_.begin(), vertices_.end(), std::back_inserter(soft_), is_soft);
}

Points DynamicsDisplay::skin(int frame, const Points& positions) const
{
    if (avatar_ == nullptr) return positions(vertices_, Eigen::all);
    return AvatarPoser(*avatar_).display_skin(set().poses[static_cast<std::size_t>(frame)],
                                              positions.middleRows(body_begin_, avatar_->num_vertices()));
}

Points DynamicsDisplay::skinned(int frame) const
{
    require(avatar_ != nullptr, "only an avatar tells where skinning alone has the skin");
    const AvatarPoser poser(*avatar_);
    const Pose& pose = set().poses[static_cast<std::size_t>(frame)];
    return poser.display_skin(pose, to_world(poser.world_from_unposed(pose), avatar_->rest));
}

Eigen::VectorXd DynamicsDisplay::displacements(int frame) const
{
    return (skin(frame, reader_.frame(frame)) - skinned(frame)).rowwise().norm();
}

MeshSequence DynamicsDisplay::sequence(int index, const std::string& credits, double range) const
{
    const auto [begin, end] = set().frames_of(index);
    MeshSequence sequence;
    ExportedMesh mesh;
    mesh.name = "skin";
    mesh.triangles = triangles_;
    mesh.colour = skin_colour;
    sequence.meshes.push_back(mesh);
    // Vertices of each of the others, which lie in a row.
    std::vector<std::pair<int, int>> rows;
    for (const DynamicSurface& other : set().others) {
        const int first = other.triangles.minCoeff();
        rows.emplace_back(first, other.triangles.maxCoeff() + 1 - first);
        mesh.name = other.name;
        mesh.triangles = other.triangles.array() - first;
        mesh.colour = other.garment ? garment_colour : obstacle_colour;
        sequence.meshes.push_back(mesh);
    }
    sequence.num_frames = end - begin;
    sequence.frame_rate = set().frame_rate_hertz;
    sequence.credits = credits;
    sequence.frame = [this, rows, range, first = begin](int frame_idx) {
        const int frame = first + frame_idx;
        const Points positions = reader_.frame(frame);
        std::vector<MeshFrame> frames(1 + rows.size());
        frames[0].vertices = skin(frame, positions);
        if (range > 0) {
            frames[0].colours = distance_colours((frames[0].vertices - skinned(frame)).rowwise().norm(), range);
        }
        for (std::size_t i = 0; i < rows.size(); ++i) {
            frames[i + 1].vertices = positions.middleRows(rows[i].first, rows[i].second);
        }
        return frames;
    };
    return sequence;
}

double write_dynamics_page(const std::string& path, const DynamicsDisplay& display, int sequence,
                           const std::string& credits)
{
    const DynamicsSet& set = display.set();
    const auto [begin, end] = set.frames_of(sequence);
    const int first_frame = begin;
    std::vector<int> vertices;  // of what stands around, one surface after the other
    Eigen::Index num_triangles = display.triangles().rows();
    for (const DynamicSurface& other : set.others) num_triangles += other.triangles.rows();
    const auto num_skin = static_cast<int>(display.rest().rows());
    SurfacePageMotion motion;
    motion.triangles.resize(num_triangles, 3);
    motion.triangles.topRows(display.triangles().rows()) = display.triangles();
    Eigen::Index row = display.triangles().rows();
    for (const DynamicSurface& other : set.others) {
        const int first = other.triangles.minCoeff(), last = other.triangles.maxCoeff();
        motion.triangles.middleRows(row, other.triangles.rows()) =
            other.triangles.array() - first + num_skin + static_cast<int>(vertices.size());
        row += other.triangles.rows();
        for (int v = first; v <= last; ++v) vertices.push_back(v);
    }
    const auto with_others = [vertices, num_skin](const Points& skin, const Points& positions) {
        Points points(num_skin + static_cast<Eigen::Index>(vertices.size()), 3);
        points << skin, positions(vertices, Eigen::all);
        return points;
    };
    motion.title = fmt::format("{}, with inertia", set.sequence_names[static_cast<std::size_t>(sequence)]);
    motion.num_frames = end - begin;
    motion.frame_rate = set.frame_rate_hertz;
    motion.num_body_points = num_skin;
    motion.num_body_triangles = static_cast<int>(display.triangles().rows());
    motion.credits = credits;
    if (display.has_skinned()) motion.methods.push_back("Skinned");
    motion.methods.push_back("Simulated");
    motion.rest = with_others(display.rest(), display.reader().frame(first_frame));
    motion.points = [&](int method_idx, int frame_idx) {
        const int frame = first_frame + frame_idx;
        const Points positions = display.reader().frame(frame);
        const bool skinned = display.has_skinned() && method_idx == 0;
        return with_others(skinned ? display.skinned(frame) : display.skin(frame, positions), positions);
    };
    return write_surface_page(path, motion);
}

VertexColours distance_colours(const Eigen::Ref<const Eigen::VectorXd>& distances, double range)
{
    const Eigen::RowVector3f none(0.97f, 0.97f, 0.97f), full(0.75f, 0.05f, 0.10f);
    VertexColours colours(distances.size(), 3);
    for (Eigen::Index v = 0; v < distances.size(); ++v) {
        const auto share = static_cast<float>(std::clamp(distances[v] / range, 0.0, 1.0));
        colours.row(v) = none + share * (full - none);
    }
    return colours;
}

}  // namespace ndg
