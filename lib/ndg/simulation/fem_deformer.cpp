// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/fem_deformer.h"

#include "ndg/core/log.h"
#include "ndg/simulation/simulator.h"

namespace ndg {

namespace {

class FemDeformer : public Deformer {
public:
    FemDeformer(const BodyPoser& poser, const SimulationOptions& options)
        : simulator_(poser, options), contact_(options.contact.contact)
    {
    }

    Points deform(const PosedBody& posed) override
    {
        if (&posed.body() != body_) simulator_.set_body(posed.body());
        body_ = &posed.body();
        SimulationResult result = simulator_.simulate(posed.pose());
        if (!result.newton.converged()) {
            log_warning("{}: Newton's method {}, relative residual {:.2e}", posed.body().name,
                        describe(result.newton.stop), result.newton.residual_relative);
        }
        if (contact_ && result.intersecting_triangles > 0) {
            log_warning("{}: {} skin triangles intersect in spite of contact", posed.body().name,
                        result.intersecting_triangles);
        }
        return std::move(result.vertices);
    }

private:
    Simulator simulator_;
    bool contact_;
    const Body* body_ = nullptr;
};

/// Bodies come posed: how is not among the method's own options.
struct SolveOptions : SimulationOptions {};
void describe(OptionList& list, SolveOptions& options)
{
    describe_solve(list, options);
}

}  // namespace

void register_fem(MethodTable& table)
{
    const auto options = std::make_shared<SolveOptions>();
    table.add({"fem", "FEM", "finite-element simulation of static equilibrium",
               [options](Tool& tool) { tool.options(*options); },
               [options](const BodyPoser& poser) { return std::make_unique<FemDeformer>(poser, *options); }});
}

}  // namespace ndg
