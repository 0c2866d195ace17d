// SPDX-License-Identifier: Apache-2.0
// Gravity, and weights that hang on the skin.
#pragma once

#include "ndg/dynamics/driven_body.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// m/s^2, along -y.
constexpr double gravity_acceleration = 9.81;

/// A mass hung on the skin about a point of the rest shape: shared by the free skin vertices within the radius, by
/// their areas at rest. It weighs and it has inertia.
struct SceneLoad {
    std::string name;
    std::optional<Eigen::Vector3d> center;  ///< at rest, m
    std::string joint;                      ///< or the rest position of this joint
    double radius_m = 0, mass_kg = 0;
    double from_s = 0;  ///< time from which it hangs there
};
struct SceneLoads {
    bool gravity = false;  ///< of the flesh itself; the skinned shape of scanned people has it already (Romero et al.)
    std::vector<SceneLoad> loads;
};

/// The loads of one body through time.
class LoadSchedule {
public:
    /// Throws InputError naming a load: a joint that is not there, no free skin vertex within the radius.
    LoadSchedule(const SceneLoads& loads, const DrivenBody& body);

    /// What holds at `time`, s: added masses, N_v, kg, and forces, N_v x 3, N.
    void at(double time, Eigen::VectorXd& added_masses, Points& forces) const;

private:
    struct Hung {
        double from_s;
        Eigen::VectorXd masses;
    };
    Eigen::VectorXd own_weights_;  ///< kg, those of the body under gravity, otherwise zero
    std::vector<Hung> hung_;
};

}  // namespace ndg
