// SPDX-License-Identifier: Apache-2.0
// A statistical body whose skin is the tube of tests/support: soft tissue all along, none in its caps.
#pragma once

#include "ndg/avatar/fit_statistical_body.h"
#include "ndg/avatar/make_avatar.h"
#include "ndg/core/random.h"
#include "ndg/deform/linear_correctives.h"
#include "ndg/geometry/rotation.h"
#include "support/support.h"

#include <string>
#include <vector>

namespace ndg::test {

/// Tubes of other widths and lengths, and their joints.
inline BodySet tube_bodies(const Template& tube, int count)
{
    BodySet set;
    for (int b = 0; b < count; ++b) {
        Random random(3, "tubes", std::uint64_t(b));
        const Eigen::Array3d scale(random.uniform(0.9, 1.2), random.uniform(0.9, 1.1), random.uniform(0.9, 1.2));
        Body body = tube.rest;
        body.name = "tube_" + std::to_string(b);
        for (Points* points : {&body.skin_vertices, &body.volume_vertices, &body.interior_vertices})
            *points = (points->array().rowwise() * scale.transpose()).matrix();
        body.joint_positions = (body.joint_positions.array().rowwise() * scale.transpose()).matrix();
        set.bodies.push_back(body);
    }
    return set;
}

inline std::vector<int> all_of(const BodySet& bodies)
{
    std::vector<int> indices;
    for (std::size_t b = 0; b < bodies.bodies.size(); ++b) indices.push_back(int(b));
    return indices;
}

inline ShapeSpace tube_space(const BodySet& bodies)
{
    std::vector<const Points*> shapes;
    for (const Body& body : bodies.bodies) shapes.push_back(&body.volume_vertices);
    return fit_shape_space(shapes, 3, 1.0);
}

/// Blend shapes without meaning, of millimetres.
inline LinearCorrectives tube_correctives(const Template& tube)
{
    LinearCorrectives correctives;
    correctives.joints = corrective_joints(tube);
    correctives.posing = bending;
    correctives.blend_shapes.resize(9 * Eigen::Index(correctives.joints.size()), 6 * tube.num_wrap_vertices());
    Random random(4, "blend shapes");
    for (Eigen::Index i = 0; i < correctives.blend_shapes.size(); ++i)
        correctives.blend_shapes.data()[i] = float(0.002 * random.normal());
    return correctives;
}

struct TubeBody {
    Template tube;
    BodySet bodies;
    LinearCorrectives correctives;
    StatisticalBodyOptions options;
    BodyErrors errors;
    StatisticalBody body;

    explicit TubeBody(int rings = 25, int segments = 12) : tube(tube_template(rings, segments))
    {
        bodies = tube_bodies(tube, 12);
        correctives = tube_correctives(tube);
        body = fit_statistical_body(tube, bodies, all_of(bodies), tube_space(bodies), &correctives, options, errors);
    }
};

/// Random rotations of all joints.
inline Pose random_pose(int num_joints, double spread, std::uint64_t index)
{
    Random random(9, "pose", index);
    Pose pose = Pose::rest(num_joints);
    for (Eigen::Matrix3d& rotation : pose.parent_from_joint)
        rotation = rotation_of(spread * Eigen::Vector3d(random.normal(), random.normal(), random.normal()));
    pose.root_translation << random.normal(), random.normal(), random.normal();
    return pose;
}

/// For the tube, whose radius is 8 cm.
inline AvatarOptions tube_options()
{
    AvatarOptions options;
    options.thickness = 0.03;
    options.control_points = 5;
    return options;
}

}  // namespace ndg::test
