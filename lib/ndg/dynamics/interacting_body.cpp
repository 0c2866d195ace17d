// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/interacting_body.h"

#include "ndg/core/error.h"
#include "ndg/dynamics/shifted_term.h"
#include "ndg/geometry/closest_point.h"

#include <algorithm>

namespace ndg {

/// Contact, and what depends on time alone.
class InteractingBody::Hook : public StepHook {
public:
    explicit Hook(InteractingBody& body) : body_(body) {}
    void begin_step(const DynamicState& state, double end_time, double time_step, Points& start) override
    {
        body_.interaction_->set_time(end_time);
        body_.interaction_->set_obstacles(end_time, start);
        body_.scene_->begin_step(state, end_time, time_step, start);
    }
    bool choose_elements(const Points& positions) override { return body_.scene_->choose_elements(positions); }
    StepFilter filter() override { return body_.scene_->filter(); }
    bool goes_on(const Points& positions, const NewtonResult& round) override
    {
        return body_.scene_->goes_on(positions, round);
    }

private:
    InteractingBody& body_;
};

InteractingBody::~InteractingBody() = default;

std::unique_ptr<DrivenBody> InteractingBody::among(std::unique_ptr<DrivenBody> body, const Scene& scene,
                                                   const ContactSceneOptions& options, std::unique_ptr<StepHook>& hook)
{
    if (!options.contact && !scene.contact && scene.obstacles.empty() && scene.garments.empty()) return body;
    auto result = std::make_unique<InteractingBody>(std::move(body), scene.obstacles, scene.garments, options);
    hook = result->hook();
    return result;
}

std::unique_ptr<StepHook> InteractingBody::hook()
{
    return std::make_unique<Hook>(*this);
}

InteractingBody::InteractingBody(std::unique_ptr<DrivenBody> body, std::vector<Obstacle> obstacles,
                                 const std::vector<GarmentPlan>& garments, const ContactSceneOptions& options)
    : body_(std::move(body))
{
    skeleton_ = body_->skeleton();
    joint_positions_ = body_->joint_positions();
    const auto joint_of = [&](const std::string& name, const std::string& what) {
        const std::vector<std::string>& names = skeleton_.joint_names;
        const auto found = std::find(names.begin(), names.end(), name);
        require_input(found != names.end(), "there is no joint \"{}\" for {}", name, what);
        return static_cast<int>(found - names.begin());
    };
    const auto joint = [&](const std::string& name) -> Eigen::Vector3d {
        return joint_positions_.row(joint_of(name, "a garment")).transpose();
    };
    for (const Obstacle& obstacle : obstacles) {
        followed_joints_.push_back(obstacle.follows.empty() ? -1 : joint_of(obstacle.follows, obstacle.name));
    }
    std::vector<Garment> made;
    for (const GarmentPlan& plan : garments) {
        made.push_back(make_garment(plan, body_->rest(), body_->skin_triangles(), joint, options.contact_distance));
    }
    if (!made.empty()) {
        const TriangleTree skin(body_->rest(), body_->skin_triangles());
        for (const Garment& garment : made) {
            for (Eigen::Index v = 0; v < garment.worn.vertices.rows(); ++v) {
                const Eigen::Vector3d place = garment.worn.vertices.row(v);
                const ClosestPoint closest = skin.closest(place);
                Carrier carrier;
                carrier.vertices = body_->skin_triangles().row(closest.triangle_idx).transpose();
                carrier.weights = closest.barycentric;
                carrier.offset = frame_of(body_->rest(), carrier.vertices).transpose() * (place - closest.point);
                carriers_.push_back(carrier);
            }
        }
    }
    interaction_ = std::make_unique<Interaction>(
        std::move(obstacles), std::move(made),
        ContactBody{"body", body_->num_vertices(), body_->num_held(), body_->skin_triangles()});
    const int count = interaction_->num_vertices();
    carried_begin_ = count - static_cast<int>(carriers_.size());
    elastic_ = std::make_unique<ElasticBody>(count, interaction_->num_given());
    for (const auto& term : body_->elastic().terms()) {
        elastic_->add(std::make_unique<ShiftedTerm>(*term, interaction_->body_begin(), count));
    }
    interaction_->add_terms(*elastic_);
    scene_ = std::make_unique<ContactScene>(*elastic_, interaction_->surfaces(), options);
    rest_ = interaction_->rest(body_->rest());
    elastic_->set_rest(rest_);
    interaction_->set_time(0);
    masses_ = interaction_->masses(body_->masses());
    skin_ = body_->skin_triangles().array() + interaction_->body_begin();
}

Eigen::Matrix3d InteractingBody::frame_of(const Points& body_positions, const Eigen::Vector3i& triangle) const
{
    const Eigen::Vector3d a = body_positions.row(triangle[0]), b = body_positions.row(triangle[1]),
                          c = body_positions.row(triangle[2]);
    Eigen::Matrix3d frame;
    frame.col(0) = (b - a).normalized();
    frame.col(2) = (b - a).cross(c - a).normalized();
    frame.col(1) = frame.col(2).cross(frame.col(0));
    return frame;
}

DrivenPose InteractingBody::pose(const Pose& pose) const
{
    const DrivenPose own = body_->pose(pose);
    DrivenPose result;
    const auto count = static_cast<std::size_t>(num_vertices());
    result.world_from_unposed.assign(count, AffineMap::Identity());
    std::copy(own.world_from_unposed.begin(), own.world_from_unposed.end(),
              result.world_from_unposed.begin() + interaction_->body_begin());
    for (std::size_t i = 0; i < carriers_.size(); ++i) {
        AffineMap map = AffineMap::Zero();
        for (int a = 0; a < 3; ++a) {
            map += carriers_[i].weights[a] * own.world_from_unposed[static_cast<std::size_t>(carriers_[i].vertices[a])];
        }
        result.world_from_unposed[static_cast<std::size_t>(carried_begin_) + i] = map;
    }
    result.held = rest_.topRows(num_held());
    result.held.bottomRows(body_->num_held()) = own.held;
    const std::vector<Eigen::Isometry3d> motions = forward_kinematics(skeleton_, joint_positions_, pose);
    for (const int joint : followed_joints_) {
        result.world_from_followed.push_back(joint < 0 ? Eigen::Isometry3d::Identity()
                                                       : motions[static_cast<std::size_t>(joint)]);
    }
    return result;
}

void InteractingBody::set_pose(const DrivenPose& pose)
{
    const auto begin = pose.world_from_unposed.begin() + interaction_->body_begin();
    DrivenPose own;
    own.world_from_unposed.assign(begin, begin + body_->num_vertices());
    own.held = pose.held.bottomRows(body_->num_held());
    body_->set_pose(own);
    interaction_->set_followed(pose.world_from_followed);
    // Its elements are those of the step before.
    scene_->set_silent(true);
}

Points InteractingBody::equilibrium(const Pose& pose)
{
    const Points own = body_->equilibrium(pose);
    Points positions = interaction_->start(own, Points::Zero(own.rows(), 3)).positions;
    for (std::size_t i = 0; i < carriers_.size(); ++i) {
        Eigen::Vector3d place = frame_of(own, carriers_[i].vertices) * carriers_[i].offset;
        for (int a = 0; a < 3; ++a) {
            place += carriers_[i].weights[a] * own.row(carriers_[i].vertices[a]).transpose();
        }
        positions.row(carried_begin_ + static_cast<Eigen::Index>(i)) = place.transpose();
    }
    return positions;
}

void InteractingBody::start(DynamicState& state)
{
    interaction_->throw_solids(state);
    check_apart(scene_->surfaces(), state.positions, num_held());
}

Eigen::VectorXd InteractingBody::falling_masses() const
{
    return interaction_->masses(Eigen::VectorXd::Zero(body_->num_vertices()));
}

std::vector<DynamicSurface> InteractingBody::other_surfaces() const
{
    std::vector<DynamicSurface> others;
    for (const ContactSurface& surface : interaction_->surfaces()) {
        if (surface.kind == SurfaceKind::skin) continue;
        others.push_back({surface.name, surface.kind == SurfaceKind::cloth, surface.triangles});
    }
    return others;
}

}  // namespace ndg
