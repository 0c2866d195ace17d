// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/avatar.h"

#include "ndg/core/error.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/io/h5.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

constexpr const char* format_name = "ndg-avatar";
constexpr int format_version = 1;
constexpr double unit_tolerance = 1e-5;
/// Bounds and thickness are float64; this is rounding.
constexpr double thickness_tolerance = 1e-9;

void write_directions(H5Writer& writer, const std::string& name, const RowMatrixF& directions,
                      const std::string& vertices)
{
    writer.write(name, {std::size_t(directions.rows()), std::size_t(directions.cols())}, directions.data(),
                 "entries of R - I of each joint x coordinates of each " + vertices + " vertex, m");
}

Points read_unit_vectors(const H5Reader& reader, const std::string& name, Eigen::Index rows)
{
    Points vectors = reader.read_matrix(name, rows, 3);
    for (Eigen::Index i = 0; i < vectors.rows(); ++i)
        require_input(std::abs(vectors.row(i).norm() - 1.0) <= unit_tolerance, "{}: {}[{}] has the length {}",
                      reader.path(), name, i, vectors.row(i).norm());
    return vectors;
}

JointWeights read_joint_weights(const H5Reader& reader, const std::string& name, Eigen::Index rows, Eigen::Index cols)
{
    const RowMatrix dense = reader.read_matrix(name, rows, cols);
    const std::string defect = weights_defect(dense);
    require_input(defect.empty(), "{}: {}{}", reader.path(), name, defect);
    return sparse_weights(dense);
}

void read_skeleton(const H5Reader& reader, Avatar& avatar)
{
    Skeleton& skeleton = avatar.skeleton;
    skeleton.joint_names = reader.read_strings("/skeleton/joint_names");
    const auto k = int(skeleton.joint_names.size());
    skeleton.parents = reader.read_ints("/skeleton/parents", k, -1, k - 1);
    const std::string defect = parents_defect(skeleton.parents);
    require_input(defect.empty(), "{}: /skeleton/parents{}", reader.path(), defect);
    avatar.joint_positions = reader.read_matrix("/skeleton/joint_positions", k, 3);
    if (!reader.has("/pose/joint_names")) return;
    for (const std::string& name : reader.read_strings("/pose/joint_names")) {
        const auto found = std::find(skeleton.joint_names.begin(), skeleton.joint_names.end(), name);
        require_input(found != skeleton.joint_names.end(),
                      "{}: /pose/joint_names has \"{}\", which is no joint of /skeleton/joint_names", reader.path(),
                      name);
        avatar.pose_joints.push_back(int(found - skeleton.joint_names.begin()));
    }
}

void read_volume(const H5Reader& reader, Avatar& avatar)
{
    avatar.rest = reader.read_matrix("/volume/vertices", -1, 3);
    const int m = avatar.num_vertices();
    avatar.tetrahedra = reader.read_int_matrix("/volume/tetrahedra", -1, 4, 0, m - 1);
    const Eigen::VectorXd volumes = tetrahedron_volumes(avatar.rest, avatar.tetrahedra);
    for (Eigen::Index t = 0; t < volumes.size(); ++t)
        require_input(volumes[t] > 0.0, "{}: /volume/tetrahedra[{}] has volume {} m^3", reader.path(), t, volumes[t]);
    avatar.num_held = reader.read_ints("/volume/num_held", 1, 1, m).front();
    avatar.normals = read_unit_vectors(reader, "/volume/normals", m);
    avatar.weights = read_joint_weights(reader, "/volume/weights", m, avatar.num_joints());
}

void read_layer(const H5Reader& reader, Avatar& avatar)
{
    const auto n = int(avatar.skin_vertices.rows());
    const int m = avatar.num_vertices();
    avatar.skin_of_inner = reader.read_ints("/layer/skin_vertices", -1, 0, n - 1);
    const auto w = Eigen::Index(avatar.skin_of_inner.size());
    require_input(w > 0 && avatar.num_held >= w && 2 * w <= m,
                  "{}: a layer below {} skin vertices does not fit a volume of {} vertices of which {} are held",
                  reader.path(), w, m, avatar.num_held);
    const std::vector<int> outer = reader.read_ints("/layer/outer_vertices", w, int(w), int(2 * w) - 1);
    avatar.volume_vertex_of_skin.assign(n, -1);
    std::vector<bool> used(m, false);
    for (Eigen::Index v = 0; v < w; ++v) {
        const int skin = avatar.skin_of_inner[v];
        require_input(avatar.volume_vertex_of_skin[skin] < 0 && !used[outer[v]],
                      "{}: /layer/skin_vertices[{}] or its outer vertex is there twice", reader.path(), v);
        require_input((avatar.rest.row(outer[v]) - avatar.skin_vertices.row(skin)).norm() <= thickness_tolerance,
                      "{}: /layer/outer_vertices[{}], volume vertex {}, does not lie on skin vertex {}", reader.path(),
                      v, outer[v], skin);
        used[outer[v]] = true;
        avatar.volume_vertex_of_skin[skin] = outer[v];
    }
    avatar.skin_triangles = reader.read_int_matrix("/layer/triangles", -1, 3, int(w), int(2 * w) - 1);
    avatar.inward = read_unit_vectors(reader, "/layer/inward", w);
    avatar.thickness = reader.read_doubles("/layer/thickness", w);
    avatar.min_thickness = reader.read_doubles("/layer/min_thickness", w);
    avatar.max_thickness = reader.read_doubles("/layer/max_thickness", w);
    for (Eigen::Index v = 0; v < w; ++v) {
        const double h = avatar.thickness[v];
        require_input(avatar.min_thickness[v] > 0 && h >= avatar.min_thickness[v] - thickness_tolerance &&
                          h <= avatar.max_thickness[v] + thickness_tolerance,
                      "{}: /layer/thickness[{}] is {} m, outside its bounds {} and {} m", reader.path(), v, h,
                      avatar.min_thickness[v], avatar.max_thickness[v]);
        const Eigen::RowVector3d inner = avatar.skin_vertices.row(avatar.skin_of_inner[v]) + h * avatar.inward.row(v);
        require_input((avatar.rest.row(v) - inner).norm() <= unit_tolerance,
                      "{}: /volume/vertices[{}] does not lie {} m inside of skin vertex {}", reader.path(), v, h,
                      avatar.skin_of_inner[v]);
    }
}

void read_control_points(const H5Reader& reader, Avatar& avatar)
{
    const auto n = int(avatar.skin_vertices.rows());
    avatar.control_vertices = reader.read_ints("/control/vertices", -1, 0, n - 1);
    const auto c = Eigen::Index(avatar.control_vertices.size());
    avatar.mirror_vertices = reader.read_ints("/control/mirror_vertices", c, -1, n - 1);
    avatar.control_weights = reader.read_matrix("/control/weights", avatar.num_vertices(), c);
    const std::string defect = weights_defect(avatar.control_weights);
    require_input(defect.empty(), "{}: /control/weights{}", reader.path(), defect);
}

}  // namespace

void write_avatar(const std::string& path, const Avatar& avatar, const Provenance& provenance)
{
    H5Writer writer(path, format_name, format_version, provenance);
    writer.attribute("name", avatar.name);
    writer.write("/skeleton/joint_names", avatar.skeleton.joint_names, "names of the joints");
    writer.write("/skeleton/parents", avatar.skeleton.parents, "parent of each joint, -1 for the root");
    writer.write("/skeleton/joint_positions", avatar.joint_positions, "rest positions of the joints, m",
                 Storage::float64);
    writer.write("/volume/vertices", avatar.rest,
                 "rest positions: inner surface, outer vertices of the rims, other outer vertices, inside; m",
                 Storage::float64);
    writer.write("/volume/num_held", std::vector<int>{avatar.num_held}, "how many of them, the first, are held");
    writer.write("/volume/tetrahedra", avatar.tetrahedra, "indices into /volume/vertices");
    writer.write("/volume/normals", avatar.normals, "the skin's outward normal carried inside, unit", Storage::float64);
    writer.write("/volume/weights", RowMatrix(avatar.weights), "skinning weights, rows sum to one", Storage::float64);
    writer.write("/skin/vertices", avatar.skin_vertices, "rest positions of the whole skin, m", Storage::float64);
    writer.write("/skin/triangles", avatar.whole_skin_triangles, "indices into /skin/vertices, outward");
    writer.write("/skin/weights", RowMatrix(avatar.skin_weights), "skinning weights, rows sum to one",
                 Storage::float64);
    if (!avatar.pose_joints.empty()) {
        std::vector<std::string> names;
        for (const int joint : avatar.pose_joints) names.push_back(avatar.skeleton.joint_names[joint]);
        writer.write("/pose/joint_names", names, "joints whose rotations drive the pose directions");
        write_directions(writer, "/pose/volume_directions", avatar.pose_directions, "volume");
        write_directions(writer, "/pose/skin_directions", avatar.skin_pose_directions, "skin");
    }
    std::vector<int> outer;
    for (const int skin : avatar.skin_of_inner) outer.push_back(avatar.volume_vertex_of_skin[skin]);
    writer.write("/layer/skin_vertices", avatar.skin_of_inner, "skin vertex above each vertex of the inner surface");
    writer.write("/layer/outer_vertices", outer, "volume vertex on that skin vertex");
    writer.write("/layer/triangles", avatar.skin_triangles, "the skin above, indices into /volume/vertices, outward");
    writer.write("/layer/inward", avatar.inward, "unit direction from skin to inner surface", Storage::float64);
    writer.write("/layer/thickness", avatar.thickness, "distance of inner surface and skin, m");
    writer.write("/layer/min_thickness", avatar.min_thickness, "least thickness, m");
    writer.write("/layer/max_thickness", avatar.max_thickness, "greatest thickness, m");
    writer.write("/control/vertices", avatar.control_vertices, "skin vertex of each control point");
    writer.write("/control/mirror_vertices", avatar.mirror_vertices,
                 "skin vertex opposite, which has the same value; -1: none");
    writer.write("/control/weights", avatar.control_weights,
                 "values at the volume vertices from those at the control points, rows sum to one", Storage::float64);
    writer.commit();
}

Avatar read_avatar(const std::string& path)
{
    const H5Reader reader(path, format_name, format_version);
    Avatar avatar;
    avatar.name = reader.attribute("name");
    avatar.licences = reader.attribute("licences");
    read_skeleton(reader, avatar);
    read_volume(reader, avatar);
    avatar.skin_vertices = reader.read_matrix("/skin/vertices", -1, 3);
    const auto n = int(avatar.skin_vertices.rows());
    avatar.whole_skin_triangles = reader.read_int_matrix("/skin/triangles", -1, 3, 0, n - 1);
    avatar.skin_weights = read_joint_weights(reader, "/skin/weights", n, avatar.num_joints());
    if (!avatar.pose_joints.empty()) {
        const Eigen::Index features = 9 * Eigen::Index(avatar.pose_joints.size());
        avatar.pose_directions =
            reader.read_matrix("/pose/volume_directions", features, 3 * avatar.rest.rows()).cast<float>();
        avatar.skin_pose_directions = reader.read_matrix("/pose/skin_directions", features, 3 * n).cast<float>();
    }
    read_layer(reader, avatar);
    read_control_points(reader, avatar);
    return avatar;
}

}  // namespace ndg
