// SPDX-License-Identifier: Apache-2.0
// A body that a motion drives: what of it is elastic, what its poses hold, and how flesh is carried along.
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/dynamics/soft_body.h"
#include "ndg/dynamics/step_hook.h"

#include <functional>
#include <memory>

namespace ndg {

/// What a pose says of a body before any dynamics.
struct DrivenPose {
    std::vector<AffineMap> world_from_unposed;  ///< of every vertex: how skinning moves what is about it
    Points held;                                ///< num_held x 3, m
    /// Of every obstacle that a body is among: the motion from rest of the joint that it follows, or the identity.
    std::vector<Eigen::Isometry3d> world_from_followed{};
};

/// A surface beside the body's skin: an obstacle, a garment.
struct DynamicSurface {
    std::string name;
    bool garment = false;  ///< otherwise an obstacle
    Triangles triangles;   ///< among all vertices
};

/// Vertices stand as in an ElasticBody: the held ones first.
class DrivenBody {
public:
    virtual ~DrivenBody() = default;

    virtual DrivenPose pose(const Pose& pose) const = 0;
    /// The energy is that of this pose from now on.
    virtual void set_pose(const DrivenPose&) {}
    /// N_v x 3: at rest in the pose, from which a motion starts. Throws Error where there is none.
    virtual Points equilibrium(const Pose& pose) = 0;

    /// Has the last word on the state that a motion starts in. Throws InputError where it cannot start so.
    virtual void start(DynamicState&) {}
    /// kg of every vertex that has weight even where flesh has none of its own.
    virtual Eigen::VectorXd falling_masses() const { return Eigen::VectorXd::Zero(num_vertices()); }
    virtual std::vector<DynamicSurface> other_surfaces() const { return {}; }

    ElasticBody& elastic() { return *elastic_; }
    const Points& rest() const { return rest_; }               ///< N_v x 3
    const Eigen::VectorXd& masses() const { return masses_; }  ///< kg
    const Triangles& skin_triangles() const { return skin_; }  ///< among all vertices
    int num_vertices() const { return static_cast<int>(rest_.rows()); }
    int num_held() const { return elastic_->num_fixed_vertices(); }
    /// Rest positions of the skeleton's joints, J x 3, and their names.
    const Points& joint_positions() const { return joint_positions_; }
    const Skeleton& skeleton() const { return skeleton_; }

protected:
    std::unique_ptr<ElasticBody> elastic_;
    Points rest_, joint_positions_;
    Eigen::VectorXd masses_;
    Triangles skin_;
    Skeleton skeleton_;
};

/// What poses a soft body.
struct SoftBodyPoser {
    Skeleton skeleton;
    Points joint_positions;
    std::function<std::vector<AffineMap>(const Pose&)> world_from_unposed;
};

/// Soft tissue held to the skinned shape: its own rest shape, moved by the maps. Throws InputError as
/// SoftBody::check() does.
class SoftTissueBody : public DrivenBody {
public:
    SoftTissueBody(const SoftBody& tissue, SoftBodyPoser poser, const TissueOptions& options, double density);

    DrivenPose pose(const Pose& pose) const override;
    void set_pose(const DrivenPose& pose) override;
    Points equilibrium(const Pose& pose) override;

private:
    SoftBodyPoser poser_;
    UnposedMaps* maps_;
};

}  // namespace ndg
