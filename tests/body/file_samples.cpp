// SPDX-License-Identifier: Apache-2.0
#include "file_samples.h"

#include "ndg/core/random.h"
#include "support/support.h"

namespace ndg::test {

BodySet example_bodies(const Template& tube)
{
    BodySet set;
    set.parameter_names = {"stature_m", "mass_kg"};
    set.parameters.resize(3, 2);
    set.parameters << 1.6, 55.5, 1.7, 70.25, 1.8, 90.0;
    for (int i = 0; i < 3; ++i) {
        Body body = tube.rest;
        body.name = "body_" + std::to_string(i);
        const Eigen::RowVector3d scale(1.0 + 0.1 * i, 1.0 + 0.05 * i, 1.0 + 0.02 * i * i);
        for (Points* points :
             {&body.skin_vertices, &body.volume_vertices, &body.interior_vertices, &body.joint_positions}) {
            points->array().rowwise() *= scale.array();
        }
        set.bodies.push_back(body);
    }
    return set;
}

SkinSet skins_of(const BodySet& bodies)
{
    return {{bodies.bodies.begin(), bodies.bodies.end()},
            bodies.parameter_names,
            bodies.parameters,
            bodies.template_sha256};
}

PoseSet example_poses()
{
    PoseSet set;
    set.poses = {Pose::rest(num_standard_joints), tube_pose(0.5), tube_pose(-2.0)};
    Random random(31, "poses");
    for (Eigen::Matrix3d& rotation : set.poses[2].parent_from_joint) {
        rotation = Eigen::AngleAxisd(random.uniform(-3.0, 3.0),
                                     Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized())
                       .toRotationMatrix();
    }
    set.poses[1].root_translation = {0.125, -0.1, 3.3};
    set.clip_idx = {0, 1, 1};
    set.frame_idx = {0, 12, 90};
    set.clip_names = {"walk", "run"};
    set.clip_frame_rates = {120.0, 59.94};
    set.covering_radius = {3.5, 2.25, 0.0};
    return set;
}

ShapeSpace example_shape_space(const BodySet& bodies)
{
    std::vector<const Points*> shapes;
    for (const Body& body : bodies.bodies) shapes.push_back(&body.volume_vertices);
    return fit_shape_space(shapes, 300, 1.0);
}

void write_example_shape_space(const std::string& path, const BodySet& bodies)
{
    const ShapeSpace space = example_shape_space(bodies);
    RowMatrix codes(static_cast<Eigen::Index>(bodies.bodies.size()), space.dimension());
    for (Eigen::Index i = 0; i < codes.rows(); ++i) {
        codes.row(i) = space.encode(bodies.bodies[i].volume_vertices).transpose();
    }
    write_shape_space(path, space, codes, std::vector<double>(bodies.bodies.size(), 0.0), example_provenance());
}

}  // namespace ndg::test
