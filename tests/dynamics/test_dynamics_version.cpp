// SPDX-License-Identifier: Apache-2.0
// What motions are resumed by: a version that has to follow the method.
#include "soft_shapes.h"

#include "ndg/dynamics/layered_driven_body.h"
#include "ndg/dynamics/simulate_dynamics.h"

#include <catch2/catch.hpp>

#include <fmt/format.h>

#include <array>

using namespace ndg;

namespace {

/// Skin vertices of the tube, 7 rings of 8 vertices, after 24 steps in which it bends by 0.8 and a weight hangs on it,
/// as dynamics_method_version gives them, m.
struct StoredMotion {
    const char* what;
    std::array<double, 3> middle, last;
};

}  // namespace

TEST_CASE("Motions of the stored method version come out as they are stored")
{
    const std::vector<StoredMotion> stored = {
        {"fung", {-0.045155495396, 0.474963332618, 0.056239813181}, {-0.326778911595, 0.890781694888, -0.056893669239}},
        {"neo-hookean",
         {-0.045048101600, 0.474989771799, 0.056238649683},
         {-0.326615908435, 0.890920604237, -0.056958958765}},
        {"layered",
         {-0.056415169683, 0.477670653000, 0.062641603128},
         {-0.319786933390, 0.889564611266, -0.055636451499}},
    };
    const Template tube = test::tube_template();
    std::vector<Pose> poses;
    for (int n = 0; n <= 24; ++n) poses.push_back(test::tube_pose(0.8 * n / 24));
    DynamicsOptions options;
    options.newton = {1e-11, 0, 100};
    options.frames_per_block = 100;
    SceneLoads loads;
    loads.gravity = true;
    loads.loads.push_back({"weight", std::nullopt, "left_forearm", 0.2, 0.5, 0.05});
    for (const StoredMotion& motion : stored) {
        std::unique_ptr<DrivenBody> body;
        if (std::string(motion.what) == "layered") {
            SimulationOptions layered;
            layered.posing = test::bending;
            body = std::make_unique<LayeredDrivenBody>(tube, tube.rest, layered, options.density);
        } else {
            TissueOptions tissue;
            tissue.law = parse_name<TissueLaw>(motion.what);
            body = std::make_unique<SoftTissueBody>(test::soft_tube(tube, 8e3, 15e3), test::tube_poser(tube), tissue,
                                                    options.density);
        }
        MotionSimulation simulation(*body, poses, loads, options);
        const DynamicBlock block = simulation.run(0, std::nullopt);
        const auto skin = block.state.positions.bottomRows(tube.num_wrap_vertices());
        const Eigen::Index last = skin.rows() - 1;
        const auto text = [&](Eigen::Index v) {
            return fmt::format("{{{:.12f}, {:.12f}, {:.12f}}}", skin(v, 0), skin(v, 1), skin(v, 2));
        };
        INFO("Motions come out otherwise than dynamics_method_version "
             << dynamics_method_version << " stands for. If that is intended, raise the version, so that no run goes "
             << "on with another method, and store here:\n"
             << fmt::format("{{\"{}\", {}, {}}},", motion.what, text(last / 2), text(last)));
        const auto distance = [&](Eigen::Index v, const std::array<double, 3>& x) {
            return (skin.row(v) - Eigen::RowVector3d(x[0], x[1], x[2])).norm();
        };
        CHECK(distance(last / 2, motion.middle) < 1e-7);
        CHECK(distance(last, motion.last) < 1e-7);
    }
}
