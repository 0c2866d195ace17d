// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/corotated_elasticity.h"

#include "ndg/core/error.h"
#include "ndg/elastic/layered_body.h"

namespace ndg {

CorotatedElasticity::CorotatedElasticity(const Template& body_template)
    : volume_weights_(body_template.volume_weights()),
      body_(body_template.num_volume_vertices(), body_template.num_wrap_vertices()),
      term_([&] {
          auto term =
              std::make_unique<CorotatedTerm>(body_template.prisms, prism_materials(body_template, MaterialOptions()),
                                              body_template.num_volume_vertices());
          CorotatedTerm* kept = term.get();
          body_.add(std::move(term));
          return kept;
      }()),
      objective_(body_),
      stiffness_(objective_.hessian_pattern())
{
    cholesky_.analyze(stiffness_);
}

Points CorotatedElasticity::deform(const PosedBody& posed)
{
    if (&posed.body() != rest_) {
        rest_ = nullptr;
        body_.set_rest(posed.body().volume_vertices);
        rest_ = &posed.body();
    }
    term_->set_rotations(blend_rotations(volume_weights_, posed.world_from_rest()));
    // The energy is quadratic: from any state, one step of Newton's method is its minimum.
    Points vertices = posed.skinned_volume();
    Eigen::VectorXd forces, absolute;
    objective_.gradient(vertices, forces, absolute);
    objective_.hessian(vertices, HessianKind::exact, stiffness_);
    if (!cholesky_.factorize(stiffness_)) {
        throw SolverError(
            fmt::format("{}: the system of co-rotated elasticity is not positive definite", posed.body().name));
    }
    const Eigen::VectorXd step = cholesky_.solve(forces);
    Eigen::Map<Eigen::VectorXd>(vertices.data() + vertices.size() - step.size(), step.size()) -= step;
    return vertices;
}

void register_corotated_elasticity(MethodTable& table)
{
    table.add({"corotated",
               "CoRot LinFEM",
               "linear elasticity in the bones' blended rotations, one linear solve",
               {},
               [](const BodyPoser& poser) { return std::make_unique<CorotatedElasticity>(poser.body_template()); }});
}

}  // namespace ndg
