// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/simulator.h"

#include "ndg/core/error.h"
#include "ndg/deform/gradient_skinning.h"
#include "ndg/geometry/triangle_crossings.h"

namespace ndg {

namespace {

/// Load steps before the last need only lead on to the next one.
constexpr double step_relative_tolerance = 1e-3;

}  // namespace

void describe(OptionList& list, SimulationOptions& options)
{
    describe(list, options.posing);
    describe_solve(list, options);
}

void describe_solve(OptionList& list, SimulationOptions& options)
{
    describe(list, options.material);
    describe(list, options.contact);
    describe(list, options.newton);
    list.add("load-steps", options.load_steps, "steps from rest where the direct solve fails; 0: none", 0, 1000);
}

Pose scale_pose(const Pose& pose, double share)
{
    Pose scaled = pose;
    for (Eigen::Matrix3d& rotation : scaled.parent_from_joint) {
        const Eigen::AngleAxisd angle_axis(rotation);
        rotation = Eigen::AngleAxisd(share * angle_axis.angle(), angle_axis.axis()).toRotationMatrix();
    }
    scaled.root_translation *= share;
    return scaled;
}

Simulator::Simulator(const Template& body_template, const SimulationOptions& options)
    : Simulator(BodyPoser(body_template, options.posing), options)
{
}

Simulator::Simulator(const BodyPoser& poser, const SimulationOptions& options)
    : poser_(poser),
      options_((check_options(options), options)),
      prisms_(poser.body_template().prisms),
      joint_flesh_(poser.body_template()),
      elastic_(layered_body(poser.body_template(), options.material)),
      objective_(elastic_),
      poisson_(RestOperators(prisms_, poser.body_template().rest.volume_vertices),
               poser.body_template().num_wrap_vertices()),
      newton_(objective_),
      relaxation_(objective_)
{
    // The objective above is that without contact.
    if (options_.contact.contact) {
        contact_ = std::make_unique<ContactSolver>(poser.body_template(), elastic_, options_.contact);
    }
}

void Simulator::set_body(const Body& body)
{
    body_ = nullptr;
    elastic_.set_rest(body.volume_vertices);
    poisson_.set_rest(RestOperators(prisms_, body.volume_vertices));
    gradient_operator_ = gradient_operator(body.volume_vertices, prisms_);
    body_ = &body;
}

NewtonResult Simulator::minimise(Points& vertices, const NewtonOptions& options)
{
    return newton_.minimise(vertices, options, [&](Points& positions, const Eigen::VectorXd& gradient) {
        return relaxation_.relax(positions, gradient);
    });
}

NewtonResult Simulator::solve_in_steps(const Pose& pose, Points& vertices)
{
    vertices = body_->volume_vertices;
    NewtonResult result;
    NewtonOptions loose = options_.newton;
    loose.relative_tolerance = std::max(loose.relative_tolerance, step_relative_tolerance);
    std::vector<Eigen::Matrix3d> previous_rotations =
        poser_.pose(*body_, Pose::rest(int(pose.parent_from_joint.size()))).prism_rotations();
    int iterations = 0, factorizations = 0;
    for (int step = 1; step <= options_.load_steps; ++step) {
        const Pose scaled = step == options_.load_steps ? pose : scale_pose(pose, double(step) / options_.load_steps);
        const PosedBody posed = poser_.pose(*body_, scaled);
        // The last step's deformation, turned with the bones, is the start of the next.
        const Gradients residuals =
            residuals_from_gradients(deformation_gradients(gradient_operator_, vertices), previous_rotations);
        previous_rotations = posed.prism_rotations();
        vertices = poisson_.reconstruct(gradients_from_residuals(residuals, previous_rotations), posed.bone_wrap());
        result = minimise(vertices, step == options_.load_steps ? options_.newton : loose);
        iterations += result.iterations;
        factorizations += result.factorizations;
    }
    result.iterations = iterations;
    result.factorizations = factorizations;
    return result;
}

Points Simulator::start(const Pose& pose) const
{
    require(body_ != nullptr, "no body is set to simulate");
    return gradient_skinning(poser_.pose(*body_, pose), poisson_);
}

void Simulator::measure(SimulationResult& result) const
{
    const Template& shared = poser_.body_template();
    result.inverted_prisms = count_inverted_prisms(result.vertices, prisms_);
    const auto skin = result.vertices.bottomRows(shared.num_wrap_vertices());
    const auto pairs = crossing_triangles(skin, shared.wrap_triangles);
    result.intersecting_triangles = static_cast<int>(triangles_of_pairs(pairs).size());
    result.volume_changes = joint_flesh_.volume_changes(body_->volume_vertices, result.vertices);
}

SimulationResult Simulator::simulate(const Pose& pose)
{
    SimulationResult result;
    result.vertices = start(pose);
    result.newton = minimise(result.vertices, options_.newton);
    if (!result.newton.converged() && options_.load_steps > 0) {
        Points stepped;
        NewtonResult second = solve_in_steps(pose, stepped);
        second.iterations += result.newton.iterations;
        second.factorizations += result.newton.factorizations;
        result.load_steps = options_.load_steps;
        if (second.converged() || second.residual_relative < result.newton.residual_relative) {
            result.vertices = std::move(stepped);
            result.newton = std::move(second);
        } else {
            result.newton.iterations = second.iterations;
            result.newton.factorizations = second.factorizations;
        }
    }
    if (contact_ && result.newton.stop != NewtonStop::not_finite) {
        contact_->solve(result.vertices, options_.newton, result.newton);
    }
    measure(result);
    return result;
}

}  // namespace ndg
