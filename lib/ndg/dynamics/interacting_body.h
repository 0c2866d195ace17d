// SPDX-License-Identifier: Apache-2.0
// A driven body among obstacles and in garments, which is a driven body again: of all their vertices.
#pragma once

#include "ndg/dynamics/contact_scene.h"
#include "ndg/dynamics/driven_body.h"
#include "ndg/dynamics/interaction.h"
#include "ndg/dynamics/scene_file.h"

#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// Vertices are those of Interaction; the skin is the body's. Obstacles move with the time of the steps, and with poses
/// where they follow a joint: hook() sees to them and to contact, and must take part in every step. Garments are made
/// around the body at rest and put on by carrying them along with the skin to the first pose.
class InteractingBody : public DrivenBody {
public:
    /// Throws InputError as make_garment() does.
    InteractingBody(std::unique_ptr<DrivenBody> body, std::vector<Obstacle> obstacles,
                    const std::vector<GarmentPlan>& garments, const ContactSceneOptions& options);
    ~InteractingBody() override;

    /// Refers to this body.
    std::unique_ptr<StepHook> hook();
    const Interaction& interaction() const { return *interaction_; }
    const ContactScene& scene() const { return *scene_; }

    /// Obstacles are where they are at the beginning.
    DrivenPose pose(const Pose& pose) const override;
    void set_pose(const DrivenPose& pose) override;
    Points equilibrium(const Pose& pose) override;
    /// Throws the things that are thrown; throws InputError where anything starts inside anything else.
    void start(DynamicState& state) override;
    Eigen::VectorXd falling_masses() const override;
    std::vector<DynamicSurface> other_surfaces() const override;

    /// The body as given where there is nothing to meet and no contact is asked for, otherwise an InteractingBody.
    /// `hook` is left as it is, or made.
    static std::unique_ptr<DrivenBody> among(std::unique_ptr<DrivenBody> body, const Scene& scene,
                                             const ContactSceneOptions& options, std::unique_ptr<StepHook>& hook);

private:
    class Hook;
    /// What of the skin carries a vertex of a garment.
    struct Carrier {
        Eigen::Vector3i vertices;  ///< of the body
        Eigen::Vector3d weights;
        Eigen::Vector3d offset;  ///< from there, in the triangle's frame at rest
    };
    Eigen::Matrix3d frame_of(const Points& body_positions, const Eigen::Vector3i& triangle) const;

    std::unique_ptr<DrivenBody> body_;
    std::unique_ptr<Interaction> interaction_;
    std::unique_ptr<ContactScene> scene_;
    std::vector<int> followed_joints_;  ///< of every obstacle, -1: none
    std::vector<Carrier> carriers_;     ///< of all garments' vertices
    int carried_begin_ = 0;
};

}  // namespace ndg
