// SPDX-License-Identifier: Apache-2.0
// Bodies posed by a network, frame by frame: what animate does for files, without libtorch and for the moment. (NDG
// sections 3 and 4.)
#pragma once

#include "ndg/runtime/carried_points.h"
#include "ndg/runtime/input_space.h"
#include "ndg/runtime/prism_forces.h"
#include "ndg/runtime/runtime_network.h"
#include "ndg/solver/point_solver.h"

#include <memory>
#include <vector>

namespace ndg {

/// Wall-clock seconds of the stages of the last frame.
struct FrameSeconds {
    double pose = 0;       ///< motions of the joints, the network's input
    double network = 0;    ///< with the bone wrap, which one core makes while the other begins with the last layer
    double bone_wrap = 0;  ///< of that core
    double prisms = 0;     ///< exponentials, rotations, right-hand side
    double solve = 0;
    double carried = 0;  ///< head, hands, toes, bones, muscles
    double total() const { return pose + network + prisms + solve + carried; }
};

/// One body in one pose at a time. Not to be used from several threads at once; works on all OpenMP threads.
class Runtime {
public:
    /// Keeps references to both. Throws InputError where the model was made for another template.
    Runtime(const Template& body_template, const RuntimeModel& model);

    /// All that a rest shape costs (factor of the Poisson matrix, rig of the bones); some tenths of a second.
    /// Keeps a reference to `body`. Throws InputError where it does not fit the template.
    void set_body(const Body& body);
    /// One frame. Throws InputError without a body or for another number of joints.
    void set_pose(const Pose& pose);

    /// Of the last frame, m: N_v x 3 bone wrap, muscle wrap and skin of the volume; N_s x 3; N_a x 3.
    const PointsF& volume() const { return volume_points_; }
    const PointsF& skin() const { return skin_; }
    const PointsF& anatomy() const { return anatomy_; }

    const FrameSeconds& seconds() const { return seconds_; }
    const Template& body_template() const { return template_; }
    /// Of measurements and comparisons.
    RuntimeNetwork& network() { return network_; }
    PrismForces& forces() { return forces_; }
    const PointSolver& solver() const { return solver_; }
    const CarriedAnatomy& carried_anatomy() const { return carried_anatomy_; }

private:
    void pose_bone_wrap();

    const Template& template_;
    const RuntimeModel& model_;
    InputSpace input_space_;
    std::unique_ptr<const RiggedBodies> bones_;  ///< null: the bone wrap by linear blend skinning
    SkinningWeights wrap_weights_;
    RuntimeNetwork network_;
    PrismForces forces_;
    PointSolver solver_;
    SkinnedPoints skin_beyond_volume_;
    CarriedAnatomy carried_anatomy_;

    const Body* body_ = nullptr;
    std::shared_ptr<const BodyRig> rig_;
    Eigen::VectorXd shape_code_;
    bool analyzed_ = false;

    std::vector<Eigen::Isometry3d> world_from_rest_;
    PointColumns volume_;  ///< volume, then bone interior
    PointsF volume_points_, skin_, anatomy_;
    FrameSeconds seconds_;
};

}  // namespace ndg
