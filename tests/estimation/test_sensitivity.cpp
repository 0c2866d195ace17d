// SPDX-License-Identifier: Apache-2.0
// Derivatives by stiffness against finite differences.
#include "../dynamics/soft_shapes.h"

#include "ndg/core/error.h"
#include "ndg/estimation/material_sensitivity.h"
#include "ndg/estimation/tissue_variance.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

using namespace ndg;

namespace {

/// d energy / dF by central differences.
Eigen::Matrix3d stress(const Eigen::Matrix3d& f, const OrthotropicModuli& moduli, const Eigen::Vector3d& normal)
{
    constexpr double step = 1e-5;
    const OrthotropicMaterial material = orthotropic_material(moduli, normal);
    Eigen::Matrix3d result;
    for (int i = 0; i < 9; ++i) {
        Eigen::Matrix3d more = f, less = f;
        more.data()[i] += step;
        less.data()[i] -= step;
        result.data()[i] = (orthotropic_energy(more, material) - orthotropic_energy(less, material)) / (2 * step);
    }
    return result;
}

/// A tube that is bent to and fro, three times a second, and pushed upwards meanwhile.
VarianceProblem tube_problem(const Template& tube)
{
    VarianceProblem problem;
    problem.tissue = test::soft_tube(tube, 8e3, 15e3);
    problem.poser = test::tube_poser(tube);
    problem.dynamics.newton = {1e-11, 1e-11, 200};
    for (int v = 2 * tube.num_wrap_vertices(); v < 3 * tube.num_wrap_vertices(); ++v) {
        problem.volume_vertices.push_back(v);
    }
    problem.normals = problem.tissue.normals.bottomRows(tube.num_wrap_vertices());
    return problem;
}

TargetMotion swing(int num_steps)
{
    TargetMotion motion;
    motion.name = "swing";
    for (int n = 0; n <= num_steps; ++n) {
        Pose pose = test::tube_pose(0.5 * std::sin(2 * M_PI * 3 * n / 120.0));
        pose.root_translation = Eigen::Vector3d(0, 0.03 * std::sin(2 * M_PI * 5 * n / 120.0), 0);
        motion.poses.push_back(pose);
        if (n % 2 == 0 && n != 8) motion.frame_steps.push_back(n);  // one frame is missing
    }
    return motion;
}

/// Three points along the tube.
StiffnessField tube_field(const Template& tube, TissueMaterial material)
{
    StiffnessField field;
    field.material = material;
    const Points& rest = tube.rest.volume_vertices;
    field.weights.resize(rest.rows(), 3);
    const double low = rest.col(1).minCoeff(), high = rest.col(1).maxCoeff();
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
        const double at = (rest(v, 1) - low) / (high - low);
        field.weights.row(v) << (1 - at) * (1 - at), 2 * at * (1 - at), at * at;
    }
    return field;
}

}  // namespace

TEST_CASE("Stress changes with the moduli as finite differences say")
{
    Eigen::Matrix3d f;
    f << 1.1, 0.2, -0.1, 0.05, 0.93, 0.12, -0.15, 0.08, 1.06;
    const Eigen::Vector3d normal(0.3, -0.8, 0.5);
    for (const auto& [along, across] : {std::pair(8e3, 15e3), {15e3, 8e3}, {1e3, 9e4}, {12e3, 12e3}}) {
        const OrthotropicModuli moduli{along, across, 0.2, 4};
        const OrthotropicMaterial material = orthotropic_material(moduli, normal);
        for (const Modulus by : {Modulus::normal, Modulus::tangent, Modulus::both}) {
            if ((by == Modulus::both) != (along == across)) continue;
            const double step = 1e-3 * std::min(along, across);
            OrthotropicModuli more = moduli, less = moduli;
            if (by != Modulus::tangent) {
                more.young_normal_pascal += step;
                less.young_normal_pascal -= step;
            }
            if (by != Modulus::normal) {
                more.young_tangent_pascal += step;
                less.young_tangent_pascal -= step;
            }
            const Eigen::Matrix3d expected = (stress(f, more, normal) - stress(f, less, normal)) / (2 * step);
            const Eigen::Matrix3d found = stress_derivative(f, material, material_derivative(moduli, by));
            REQUIRE(expected.norm() > 1e-3);
            CHECK((found - expected).norm() < 1e-5 * expected.norm());
        }
    }
    REQUIRE_THROWS_AS(material_derivative({1e3, 2e3, 0.2, 4}, Modulus::both), Error);
    REQUIRE_THROWS_AS(material_derivative({-1e3, 2e3, 0.2, 4}, Modulus::normal), Error);
}

TEST_CASE("Stiffness is a field between its points")
{
    const Template tube = test::tube_template(7, 8);
    const StiffnessField field = tube_field(tube, TissueMaterial::anisotropic);
    REQUIRE(field.num_parameters() == 6);
    Eigen::VectorXd parameters(6);
    parameters << std::log(1e3), std::log(2e3), std::log(3e3), std::log(4e3), std::log(5e3), std::log(6e3);
    SoftBody body = test::soft_tube(tube, 1, 1);
    field.set_stiffness(parameters, body);
    REQUIRE(body.young_normal_pascal.minCoeff() == Approx(1e3));
    REQUIRE(body.young_normal_pascal.maxCoeff() == Approx(3e3));
    REQUIRE(body.young_tangent_pascal.minCoeff() == Approx(4e3));
    REQUIRE(body.young_tangent_pascal.maxCoeff() == Approx(6e3));
    REQUIRE_THROWS_AS(field.young_normal(Eigen::VectorXd::Zero(5)), Error);
    const StiffnessField one = tube_field(tube, TissueMaterial::isotropic);
    one.set_stiffness(parameters.head(3), body);
    REQUIRE(body.young_normal_pascal == body.young_tangent_pascal);
}

TEST_CASE("Sensitivities of a whole motion are those that finite differences have")
{
    const Template tube = test::tube_template(7, 8);
    VarianceProblem problem = tube_problem(tube);
    const TargetMotion motion = swing(48);
    for (const TissueMaterial material : {TissueMaterial::anisotropic, TissueMaterial::isotropic}) {
        for (const DeformationSpace space : {DeformationSpace::unposed, DeformationSpace::world}) {
            problem.options.space = space;
            const StiffnessField field = tube_field(tube, material);
            Eigen::VectorXd parameters(field.num_parameters());
            // Across stiffer than along at one end, softer at the other; nowhere alike in an element.
            const double pascals[6] = {6e3, 6e3, 6e3, 9e3, 12e3, 14e3};
            for (Eigen::Index p = 0; p < parameters.size(); ++p) parameters[p] = std::log(pascals[p]);
            const TissueVariance found = tissue_variance(problem, motion, field, parameters, true);
            REQUIRE(found.num_unconverged_frames == 0);
            REQUIRE(found.num_indefinite_steps == 0);
            REQUIRE(std::sqrt(found.variance.total().maxCoeff()) > 1e-3);
            double worst = 0;
            for (Eigen::Index p = 0; p < parameters.size(); ++p) {
                constexpr double step = 1e-4;
                Eigen::VectorXd more = parameters, less = parameters;
                more[p] += step;
                less[p] -= step;
                const MotionVariance above = tissue_variance(problem, motion, field, more, false).variance;
                const MotionVariance below = tissue_variance(problem, motion, field, less, false).variance;
                const Eigen::VectorXd normal = (above.normal - below.normal) / (2 * step);
                const Eigen::VectorXd tangent = (above.tangent - below.tangent) / (2 * step);
                REQUIRE(normal.norm() > 1e-3 * found.variance.normal.norm());
                REQUIRE(tangent.norm() > 1e-3 * found.variance.tangent.norm());
                worst = std::max({worst, (found.normal_by_parameter.col(p) - normal).norm() / normal.norm(),
                                  (found.tangent_by_parameter.col(p) - tangent).norm() / tangent.norm()});
            }
            std::printf("largest relative difference of a column: %.1e (%s material, %s space)\n", worst,
                        to_name(material).c_str(), to_name(space).c_str());
            CHECK(worst < 1e-5);
        }
    }
}

TEST_CASE("Variance without a Jacobian is the same, and Neo-Hookean flesh is refused")
{
    const Template tube = test::tube_template(7, 8);
    VarianceProblem problem = tube_problem(tube);
    const TargetMotion motion = swing(12);
    const StiffnessField field = tube_field(tube, TissueMaterial::isotropic);
    const Eigen::VectorXd parameters = Eigen::VectorXd::Constant(3, std::log(8e3));
    const TissueVariance with = tissue_variance(problem, motion, field, parameters, true);
    const TissueVariance without = tissue_variance(problem, motion, field, parameters, false);
    REQUIRE(with.variance.normal == without.variance.normal);
    REQUIRE(with.variance.tangent == without.variance.tangent);
    REQUIRE(without.normal_by_parameter.rows() == 0);
    problem.options.law = TissueLaw::neo_hookean;
    REQUIRE_THROWS_AS(tissue_variance(problem, motion, field, parameters, true), InputError);
    REQUIRE_NOTHROW(tissue_variance(problem, motion, field, parameters, false));
}
