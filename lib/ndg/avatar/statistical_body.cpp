// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/statistical_body.h"

#include "ndg/avatar/pose_directions.h"
#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// How far rows of the joint regressor may be from summing to one; they are made of single precision by some.
constexpr double regressor_tolerance = 1e-4;

std::string size_defect(const std::string& item, Eigen::Index rows, Eigen::Index cols, Eigen::Index wanted_rows,
                        Eigen::Index wanted_cols)
{
    if (rows == wanted_rows && cols == wanted_cols) return "";
    return fmt::format("{} is {} x {} instead of {} x {}", item, rows, cols, wanted_rows, wanted_cols);
}

std::string joined(const std::string& item, const std::string& defect)
{
    return defect.empty() ? "" : item + defect;
}

std::string skin_defect(const StatisticalBody& body)
{
    const Eigen::Index n = body.num_vertices();
    if (n < 4) return fmt::format("/skin/vertices has {} rows", n);
    if (!body.vertices.array().isFinite().all()) return "/skin/vertices has values that are not finite";
    if (body.triangles.rows() == 0) return "/skin/triangles has no row";
    const int low = body.triangles.minCoeff(), high = body.triangles.maxCoeff();
    if (low < 0 || high >= n) return fmt::format("/skin/triangles refers to vertices {} to {} of {}", low, high, n);
    for (Eigen::Index t = 0; t < body.triangles.rows(); ++t) {
        const auto corners = body.triangles.row(t);
        if (corners[0] == corners[1] || corners[1] == corners[2] || corners[2] == corners[0])
            return fmt::format("/skin/triangles[{}] has the same vertex twice", t);
    }
    if (!body.soft_triangles.empty() && Eigen::Index(body.soft_triangles.size()) != body.triangles.rows())
        return fmt::format("/skin/soft_triangles has {} entries for {} triangles", body.soft_triangles.size(),
                           body.triangles.rows());
    for (std::size_t t = 0; t < body.soft_triangles.size(); ++t) {
        if (body.soft_triangles[t] != 0 && body.soft_triangles[t] != 1)
            return fmt::format("/skin/soft_triangles[{}] is {}, neither 0 nor 1", t, body.soft_triangles[t]);
    }
    return "";
}

std::string skinning_defect(const StatisticalBody& body)
{
    const Eigen::Index n = body.num_vertices(), k = body.num_joints();
    std::string defect = joined("/skeleton/parents", parents_defect(body.skeleton.parents));
    if (!defect.empty()) return defect;
    if (Eigen::Index(body.skeleton.parents.size()) != k)
        return fmt::format("/skeleton/parents has {} entries for {} joints", body.skeleton.parents.size(), k);
    defect = size_defect("/skin/weights", body.weights.rows(), body.weights.cols(), n, k);
    if (!defect.empty()) return defect;
    defect = joined("/skin/weights", weights_defect(RowMatrix(body.weights)));
    if (!defect.empty()) return defect;
    defect = size_defect("/joints/regressor", body.joint_regressor.rows(), body.joint_regressor.cols(), k, n);
    if (!defect.empty()) return defect;
    for (Eigen::Index j = 0; j < k; ++j) {
        const double sum = body.joint_regressor.row(j).sum();
        if (!(std::abs(sum - 1.0) <= regressor_tolerance))
            return fmt::format("/joints/regressor[{}] sums to {} instead of 1", j, sum);
    }
    return "";
}

std::string directions_defect(const StatisticalBody& body)
{
    const Eigen::Index columns = 3 * body.num_vertices();
    std::string defect;
    if (body.num_shapes() > 0)
        defect = size_defect("/shape/directions", body.num_shapes(), body.shape_directions.cols(), body.num_shapes(),
                             columns);
    const Eigen::Index features = 9 * Eigen::Index(body.pose_joints.size());
    if (defect.empty() && (features > 0 || body.pose_directions.rows() > 0))
        defect = size_defect("/pose/directions", body.pose_directions.rows(), body.pose_directions.cols(), features,
                             columns);
    if (!defect.empty()) return defect;
    for (const int joint : body.pose_joints) {
        if (joint < 0 || joint >= body.num_joints())
            return fmt::format("/pose/joint_names refers to joint {} of {}", joint, body.num_joints());
    }
    if (!body.shape_directions.array().isFinite().all()) return "/shape/directions has values that are not finite";
    if (!body.pose_directions.array().isFinite().all()) return "/pose/directions has values that are not finite";
    if (body.people.empty()) return "";
    return size_defect("/people/shapes", body.people_shapes.rows(), body.people_shapes.cols(),
                       Eigen::Index(body.people.size()), body.num_shapes());
}

constexpr const char* format_name = "ndg-statistical-body";
constexpr int format_version = 1;

void write_directions(H5Writer& writer, const std::string& name, const RowMatrixF& directions,
                      const std::string& description)
{
    writer.write(name, {std::size_t(directions.rows()), std::size_t(directions.cols())}, directions.data(),
                 description);
}

}  // namespace

Points StatisticalBody::rest_vertices(const Eigen::Ref<const Eigen::VectorXd>& shape) const
{
    require_input(shape.size() <= num_shapes(), "{} shape parameters were given, the statistical body has {}",
                  shape.size(), num_shapes());
    Points rest = vertices;
    Eigen::Map<Eigen::RowVectorXd> flat(rest.data(), rest.size());
    for (Eigen::Index b = 0; b < shape.size(); ++b) flat += shape[b] * shape_directions.row(b).cast<double>();
    return rest;
}

Points StatisticalBody::joint_positions(const Eigen::Ref<const Points>& rest_vertices) const
{
    return joint_regressor * rest_vertices;
}

int StatisticalBody::person(const std::string& person_name) const
{
    const auto found = std::find(people.begin(), people.end(), person_name);
    require_input(found != people.end(), "the statistical body knows no person \"{}\", {}", person_name,
                  people.empty() ? "nor any other" : fmt::format("but {} to {}", people.front(), people.back()));
    return int(found - people.begin());
}

PosedSkin skin_body(const StatisticalBody& body, const Eigen::Ref<const Eigen::VectorXd>& shape, const Pose& pose)
{
    Points rest = body.rest_vertices(shape);
    const Points joints = body.joint_positions(rest);
    const auto world_from_rest = forward_kinematics(body.skeleton, joints, pose);
    if (!body.pose_joints.empty()) rest += pose_offsets(pose_features(pose, body.pose_joints), body.pose_directions);
    PosedSkin posed;
    posed.vertices.resize(rest.rows(), 3);
    for (int v = 0; v < body.num_vertices(); ++v) {
        const Eigen::Vector3d skinned =
            blended_motion(body.weights, world_from_rest, v) * rest.row(v).transpose().homogeneous();
        posed.vertices.row(v) = skinned.transpose();
    }
    posed.joints.resize(joints.rows(), 3);
    for (Eigen::Index j = 0; j < joints.rows(); ++j) {
        const Eigen::Vector3d joint = world_from_rest[j] * Eigen::Vector3d(joints.row(j));
        posed.joints.row(j) = joint.transpose();
    }
    return posed;
}

std::string statistical_body_defect(const StatisticalBody& body)
{
    std::string defect = skin_defect(body);
    if (defect.empty()) defect = skinning_defect(body);
    if (defect.empty()) defect = directions_defect(body);
    return defect;
}

void write_statistical_body(const std::string& path, const StatisticalBody& body, const Provenance& provenance)
{
    const std::string defect = statistical_body_defect(body);
    require(defect.empty(), "{}: the statistical body is not written: {}", path, defect);
    H5Writer writer(path, format_name, format_version, provenance);
    writer.attribute("name", body.name);
    writer.write("/skeleton/joint_names", body.skeleton.joint_names, "names of the joints");
    writer.write("/skeleton/parents", body.skeleton.parents, "parent of each joint, -1 for the root");
    writer.write("/skin/vertices", body.vertices, "the template, at shape 0 and at rest, m", Storage::float64);
    writer.write("/skin/triangles", body.triangles, "indices into /skin/vertices, outward");
    writer.write("/skin/weights", RowMatrix(body.weights), "skinning weights, rows sum to one", Storage::float64);
    if (!body.soft_triangles.empty())
        writer.write("/skin/soft_triangles", body.soft_triangles,
                     "1: there is soft tissue below the triangle, 0: head, hands, feet");
    writer.write("/joints/regressor", RowMatrix(body.joint_regressor),
                 "joint positions from skin vertices, rows sum to one", Storage::float64);
    if (body.num_shapes() > 0)
        write_directions(writer, "/shape/directions", body.shape_directions,
                         "x y z of each skin vertex for one of each shape parameter, m");
    if (!body.pose_joints.empty()) {
        std::vector<std::string> names;
        for (const int joint : body.pose_joints) names.push_back(body.skeleton.joint_names[joint]);
        writer.write("/pose/joint_names", names, "joints whose rotations drive the pose directions");
        write_directions(writer, "/pose/directions", body.pose_directions,
                         "entries of R - I of each joint x coordinates of each skin vertex, m");
    }
    if (!body.people.empty()) {
        writer.write("/people/names", body.people, "people whose shapes are known");
        writer.write("/people/shapes", body.people_shapes, "shape parameters of each", Storage::float64);
    }
    writer.commit();
}

StatisticalBody read_statistical_body(const std::string& path)
{
    const H5Reader reader(path, format_name, format_version);
    StatisticalBody body;
    body.name = reader.attribute("name");
    body.skeleton.joint_names = reader.read_strings("/skeleton/joint_names");
    const auto k = Eigen::Index(body.skeleton.joint_names.size());
    body.skeleton.parents = reader.read_ints("/skeleton/parents", k, -1, int(k) - 1);
    body.vertices = reader.read_matrix("/skin/vertices", -1, 3);
    const Eigen::Index n = body.num_vertices();
    body.triangles = reader.read_int_matrix("/skin/triangles", -1, 3, 0, int(n) - 1);
    body.weights = sparse_weights(reader.read_matrix("/skin/weights", n, k));
    if (reader.has("/skin/soft_triangles"))
        body.soft_triangles = reader.read_ints("/skin/soft_triangles", body.triangles.rows(), 0, 1);
    body.joint_regressor = sparse_weights(reader.read_matrix("/joints/regressor", k, n));
    if (reader.has("/shape/directions"))
        body.shape_directions = reader.read_matrix("/shape/directions", -1, 3 * n).cast<float>();
    if (reader.has("/pose/directions")) {
        for (const std::string& name : reader.read_strings("/pose/joint_names")) {
            const auto found = std::find(body.skeleton.joint_names.begin(), body.skeleton.joint_names.end(), name);
            require_input(found != body.skeleton.joint_names.end(),
                          "{}: /pose/joint_names has \"{}\", which is no joint of /skeleton/joint_names", path, name);
            body.pose_joints.push_back(int(found - body.skeleton.joint_names.begin()));
        }
        body.pose_directions =
            reader.read_matrix("/pose/directions", 9 * Eigen::Index(body.pose_joints.size()), 3 * n).cast<float>();
    }
    if (reader.has("/people/names")) {
        body.people = reader.read_strings("/people/names");
        body.people_shapes = reader.read_matrix("/people/shapes", Eigen::Index(body.people.size()), body.num_shapes());
    }
    const std::string defect = statistical_body_defect(body);
    require_input(defect.empty(), "{}: {}", path, defect);
    return body;
}

}  // namespace ndg
