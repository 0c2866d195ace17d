// SPDX-License-Identifier: Apache-2.0
// A body in a pose: what the pose gives it directly, without any solve.
#pragma once

#include "ndg/body/posing.h"
#include "ndg/body/template.h"
#include "ndg/dataset/sample_index.h"

#include <memory>
#include <vector>

namespace ndg {

class PosedBody;
class RiggedBodies;

/// Poses bodies of one template, whose skinning weights it holds.
class BodyPoser {
public:
    /// Keeps a reference to `body_template`, which must outlive it. Throws InputError for rigid bones of a template
    /// that has none.
    explicit BodyPoser(const Template& body_template, const PosingOptions& options = {});

    const Template& body_template() const { return *template_; }
    const PosingOptions& options() const { return options_; }

    /// Throws Error when the pose or the body has another number of joints than the skeleton. `pair`: which sample of
    /// the body and pose files it is, where it comes from them.
    PosedBody pose(const Body& body, const Pose& pose, const SamplePair& pair = {-1, -1}) const;

private:
    friend class PosedBody;

    const Template* template_;
    PosingOptions options_;
    std::shared_ptr<const RiggedBodies> rigged_;  ///< of rigid bones; copies of a poser share it
    SkinningWeights bone_wrap_weights_;
    SkinningWeights volume_weights_;
    SkinningWeights prism_weights_;
};

/// Joint motions, bone wrap and prism rotations are computed once and handed on to whatever deforms or shows the body;
/// parts that not everybody needs are computed when asked for, the bone wrap when first asked for (by one thread).
/// Keeps references to its poser and body, which must outlive it.
class PosedBody {
public:
    const Template& body_template() const { return poser_->body_template(); }
    const Body& body() const { return *body_; }
    const Pose& pose() const { return pose_; }
    /// Indices into the body and pose files; -1 where it does not come from files.
    const SamplePair& pair() const { return pair_; }

    /// Rigid motion of each joint's surroundings, J.
    const std::vector<Eigen::Isometry3d>& world_from_rest() const { return world_from_rest_; }
    /// The bone wrap, N_w x 3: the Dirichlet values of every solve (NDG 3.2, 4.2). By linear blend skinning or
    /// following rigid bones, as PosingOptions say.
    const Points& bone_wrap() const;
    /// R_p of every prism (NDG equation 11), N_p.
    const std::vector<Eigen::Matrix3d>& prism_rotations() const { return prism_rotations_; }

    /// The vertices inside the bone wrap, N_i x 3, moved like it.
    Points bone_interior() const;
    /// By linear blend skinning: all volume vertices but the bone wrap, N_v x 3; the whole skin, N_s x 3.
    Points skinned_volume() const;
    Points skinned_skin() const;

    /// Whole skin for display, N_s x 3: the volumetric region from the deformed volume vertices (N_v x 3, the last N_w
    /// rows are the skin), head, hands and toes by linear blend skinning.
    Points display_skin(const Eigen::Ref<const Points>& deformed_volume) const;
    /// Anatomy carried by the deformed volume and the bone interior, N_a x 3; rigid bones by their motions, with what
    /// is attached to them. `anatomy_rest`: anatomy_at_rest of the body.
    Points anatomy(const Eigen::Ref<const Points>& anatomy_rest, const Eigen::Ref<const Points>& deformed_volume) const;

private:
    friend class BodyPoser;
    PosedBody(const BodyPoser& poser, const Body& body, const Pose& pose, const SamplePair& pair);

    const BodyPoser* poser_;
    const Body* body_;
    Pose pose_;
    SamplePair pair_;
    std::vector<Eigen::Isometry3d> world_from_rest_;
    mutable std::vector<Eigen::Isometry3d> bone_segments_;  ///< motions of rigid bones, made with the bone wrap
    mutable Points bone_wrap_;                              ///< no rows: not made yet
    std::vector<Eigen::Matrix3d> prism_rotations_;
};

}  // namespace ndg
