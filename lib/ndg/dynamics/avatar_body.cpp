// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/avatar_body.h"

#include "ndg/core/error.h"
#include "ndg/core/json_file.h"

namespace ndg {

namespace {

constexpr double least_modulus = 1, largest_modulus = 1e9;

/// Values of all volume vertices.
Eigen::VectorXd field(const Avatar& avatar, const std::vector<double>& values)
{
    if (values.size() == 1) return Eigen::VectorXd::Constant(avatar.num_vertices(), values[0]);
    require(static_cast<Eigen::Index>(values.size()) == avatar.control_weights.cols(),
            "{} moduli for the {} control points of avatar {}", values.size(), avatar.control_weights.cols(),
            avatar.name);
    return avatar.control_weights * Eigen::Map<const Eigen::VectorXd>(values.data(), avatar.control_weights.cols());
}

}  // namespace

void read_stiffness(const std::string& path, const Avatar& avatar, TissueStiffness& stiffness)
{
    const JsonValue file(path);
    file.check_keys({"young_normal_pascal", "young_tangent_pascal"});
    const auto read = [&](const char* key, std::vector<double>& values) {
        if (!file.has(key)) return;
        const JsonValue value = file.at(key);
        values.clear();
        if (!value.is_list()) {
            values.push_back(value.number(least_modulus, largest_modulus));
            return;
        }
        for (const JsonValue& element : value.elements(static_cast<int>(avatar.control_weights.cols())))
            values.push_back(element.number(least_modulus, largest_modulus));
    };
    read("young_normal_pascal", stiffness.young_normal_pascal);
    read("young_tangent_pascal", stiffness.young_tangent_pascal);
}

SoftBody soft_body_of(const Avatar& avatar, const TissueStiffness& stiffness)
{
    SoftBody body;
    body.name = avatar.name;
    body.rest = avatar.rest;
    body.num_held = avatar.num_held;
    body.tetrahedra = avatar.tetrahedra;
    body.skin_triangles = avatar.skin_triangles;
    body.normals = avatar.normals;
    body.young_normal_pascal = field(avatar, stiffness.young_normal_pascal);
    body.young_tangent_pascal = field(avatar, stiffness.young_tangent_pascal);
    return body;
}

SoftBodyPoser poser_of(const Avatar& avatar)
{
    return {avatar.skeleton, avatar.joint_positions,
            [poser = AvatarPoser(avatar)](const Pose& pose) { return poser.world_from_unposed(pose); }};
}

}  // namespace ndg
