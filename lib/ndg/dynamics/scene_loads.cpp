// SPDX-License-Identifier: Apache-2.0
#include "ndg/dynamics/scene_loads.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>

namespace ndg {

namespace {

Eigen::Vector3d center_of(const SceneLoad& load, const DrivenBody& body)
{
    if (load.center) return *load.center;
    const std::vector<std::string>& names = body.skeleton().joint_names;
    const auto found = std::find(names.begin(), names.end(), load.joint);
    require_input(found != names.end(), "load \"{}\": there is no joint \"{}\"", load.name, load.joint);
    return body.joint_positions().row(found - names.begin()).transpose();
}

}  // namespace

LoadSchedule::LoadSchedule(const SceneLoads& loads, const DrivenBody& body)
    : own_weights_(loads.gravity ? body.masses() : body.falling_masses())
{
    Eigen::VectorXd areas = Eigen::VectorXd::Zero(body.num_vertices());
    const Eigen::VectorXd of_triangles = triangle_areas(body.rest(), body.skin_triangles());
    for (Eigen::Index t = 0; t < of_triangles.size(); ++t) {
        for (int a = 0; a < 3; ++a) areas[body.skin_triangles()(t, a)] += of_triangles[t] / 3;
    }
    areas.head(body.num_held()).setZero();
    for (const SceneLoad& load : loads.loads) {
        const Eigen::Vector3d center = center_of(load, body);
        Eigen::VectorXd shares = areas;
        for (Eigen::Index v = 0; v < shares.size(); ++v) {
            if ((body.rest().row(v).transpose() - center).norm() > load.radius_m) shares[v] = 0;
        }
        const double total = shares.sum();
        require_input(total > 0, "load \"{}\": no skin that can move lies within {} m of ({:.3f}, {:.3f}, {:.3f})",
                      load.name, load.radius_m, center[0], center[1], center[2]);
        hung_.push_back({load.from_s, load.mass_kg / total * shares});
    }
}

void LoadSchedule::at(double time, Eigen::VectorXd& added_masses, Points& forces) const
{
    added_masses.setZero(own_weights_.size());
    for (const Hung& load : hung_) {
        if (time >= load.from_s) added_masses += load.masses;
    }
    forces.setZero(own_weights_.size(), 3);
    forces.col(1) = -gravity_acceleration * (own_weights_ + added_masses);
}

}  // namespace ndg
