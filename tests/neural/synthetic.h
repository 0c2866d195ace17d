// SPDX-License-Identifier: Apache-2.0
// Made-up deformations of the tube by a known smooth rule, so that training needs no simulation.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/shape_space.h"
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/neural/train.h"
#include "ndg/neural/training_set.h"
#include "support/support.h"

#include <cmath>
#include <vector>

namespace ndg::test {

struct Synthetic {
    Template tube = tube_template(5, 6);
    BodySet bodies;
    PoseSet poses;
    std::vector<DeformationSet> samples;
    ShapeSpace shape_space;

    NeuralModel model(const NetworkOptions& options, Device device = Device::cpu) const
    {
        return NeuralModel(options, shape_space, tube, 5, device);
    }
    TrainingSet set(const std::string& split, const NeuralModel& model, double cache_gigabytes = 1.0,
                    int max_samples = 0) const
    {
        return TrainingSet(model, tube, bodies, poses, samples, split, cache_gigabytes, max_samples);
    }
    PoseInput input(const NeuralModel& model, int body_idx, int pose_idx) const
    {
        return {model.input_space().encode(bodies.bodies[body_idx]), poses.poses[pose_idx]};
    }
};

inline Eigen::Matrix3d rotation_about(const Eigen::Vector3d& axis, double angle)
{
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// The elbow bent by `bend` about z and twisted by `twist` about y, the upper arm raised by `raise` about x.
inline Pose arm_pose(double bend, double twist, double raise)
{
    Pose pose = tube_pose(0);
    const Skeleton& skeleton = standard_skeleton();
    pose.parent_from_joint[skeleton.joint("left_forearm")] =
        rotation_about(Eigen::Vector3d::UnitZ(), bend) * rotation_about(Eigen::Vector3d::UnitY(), twist);
    pose.parent_from_joint[skeleton.joint("left_upper_arm")] = rotation_about(Eigen::Vector3d::UnitX(), raise);
    return pose;
}

/// The spine and both arms turned by up to 0.8 rad about any axes.
inline Pose two_arm_pose(Random& random)
{
    const Skeleton& skeleton = standard_skeleton();
    Pose pose = Pose::rest(skeleton.num_joints());
    for (const char* joint : {"spine_2", "left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm"})
        pose.parent_from_joint[skeleton.joint(joint)] =
            rotation_about({random.normal(), random.normal(), random.normal()}, random.uniform(0, 0.8));
    return pose;
}

/// Thickness and height scaled.
inline Body scaled_tube(const Template& tube, double thickness, double height)
{
    Body body = tube.rest;
    const Eigen::RowVector3d scale(thickness, height, thickness);
    for (Points* points : {&body.skin_vertices, &body.volume_vertices, &body.interior_vertices, &body.joint_positions})
        *points = (points->array().rowwise() * scale.array()).matrix();
    return body;
}

/// Linear blend skinning of the body, bulging near the elbow with the bend and the body's thickness.
inline Points bulged_tube(const Template& tube, const Body& body, const Pose& pose)
{
    const SkinningWeights weights = tube.volume_weights();
    const Skeleton& skeleton = tube.skeleton;
    const Eigen::Matrix3d& elbow = pose.parent_from_joint[skeleton.joint("left_forearm")];
    Points rest = body.volume_vertices;
    const int first_free = tube.num_wrap_vertices();
    for (Eigen::Index i = first_free; i < rest.rows(); ++i) {
        const double height = (rest(i, 1) - body.joint_positions(skeleton.joint("left_forearm"), 1)) / 0.25;
        const double bulge = 1.0 + 0.6 * elbow(1, 0) * std::exp(-height * height);
        rest(i, 0) *= bulge;
        rest(i, 2) /= bulge;
    }
    return linear_blend_skinning(rest, weights, forward_kinematics(skeleton, body.joint_positions, pose));
}

/// A tube that is its own mirror image and bends as two arms, without bodies, poses and samples.
inline Synthetic two_sided_tube()
{
    set_num_threads(1);  // steps this small only wait for each other on several
    Synthetic s;
    s.tube = symmetric_tube_template(9);
    s.tube.file_sha256 = s.bodies.template_sha256 = "tube";
    return s;
}

/// No samples yet, of the tube as it bends.
inline DeformationSet no_samples(const Template& tube)
{
    DeformationSet set;
    set.method = "FEM";
    set.num_volume_vertices = tube.num_volume_vertices();
    set.posing = bending;
    return set;
}

inline Synthetic make_synthetic(int num_training = 96, int num_validation = 24)
{
    set_num_threads(1);  // steps this small only wait for each other on several
    Synthetic s;
    s.tube.file_sha256 = "tube";
    Random random(7, "synthetic");
    std::vector<Body> bodies;
    for (int i = 0; i < 8; ++i)
        bodies.push_back(scaled_tube(s.tube, random.uniform(0.8, 1.3), random.uniform(0.9, 1.1)));
    s.bodies.bodies = bodies;
    s.bodies.template_sha256 = "tube";
    std::vector<const Points*> shapes;
    for (int i = 0; i < 6; ++i) shapes.push_back(&s.bodies.bodies[i].volume_vertices);
    s.shape_space = fit_shape_space(shapes, 2, 1.0);
    DeformationSet set = no_samples(s.tube);
    for (int i = 0; i < num_training + num_validation; ++i) {
        const bool held_out = i >= num_training;
        const int body_idx = held_out ? 6 + i % 2 : i % 6;
        s.poses.poses.push_back(
            arm_pose(random.uniform(0.0, 1.5), random.uniform(-0.5, 0.5), random.uniform(-0.8, 0.8)));
        set.add({body_idx, i}, held_out ? "validation" : "train",
                bulged_tube(s.tube, s.bodies.bodies[body_idx], s.poses.poses.back()));
        set.statistics["converged"].push_back(1.0);
    }
    s.samples = {set};
    return s;
}

inline NetworkOptions small_network()
{
    NetworkOptions options;
    options.widths = {64, 32};
    options.posing = bending;
    return options;
}

/// A model a few quick steps away from its start, so that nothing about it is trivial.
inline NeuralModel moved_model(const Synthetic& s, const NetworkOptions& options)
{
    NeuralModel model = s.model(options);
    TrainingOptions training;
    training.epochs = 3;
    training.learning_rate = 0.02;
    train(model, s.set("train", model), s.set("validation", model), training);
    return model;
}

}  // namespace ndg::test
