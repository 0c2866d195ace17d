// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/animate.h"
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/deform/deformer.h"

#ifdef NDG_WITH_TORCH
#define NDG_NETWORK_METHODS(ROW) ROW(register_network_deformer)
#else
#define NDG_NETWORK_METHODS(ROW)
#endif

// The table of methods, in the order of result tables and pictures: each row is a function that its own file defines.
#define NDG_METHODS(ROW)               \
    ROW(register_fem)                  \
    NDG_NETWORK_METHODS(ROW)           \
    ROW(register_gradient_skinning)    \
    ROW(register_lbs)                  \
    ROW(register_projective_skinning)  \
    ROW(register_corotated_elasticity) \
    ROW(register_linear_correctives)   \
    ROW(register_rigid_parts)          \
    ROW(register_runtime)              \
    ROW(register_stored_gradients)

namespace ndg {
#define NDG_DECLARE(name) void name(MethodTable& table);
NDG_METHODS(NDG_DECLARE)
}  // namespace ndg

int main(int argc, char** argv)
{
    using namespace ndg;
    MethodTable methods;
#define NDG_ADD(name) name(methods);
    NDG_METHODS(NDG_ADD)

    Tool tool("animate", "Poses bodies with their flesh, by one of several methods.",
              "animate --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 --method ndg "
              "--model model.h5 --output ndg.h5");
    SampleInputs inputs;
    AnimationOutputs outputs;
    std::string flag = "gradient-skinning", name;
    inputs.add_files(tool);
    inputs.add_samples(tool);
    inputs.add_posing(tool);
    tool.output("output", outputs.deformations, "deformed samples");
    tool.output("anatomy", outputs.anatomy, "embedded anatomy of every sample", false);
    tool.listing("list-methods", fmt::format("{}", fmt::join(methods.flags(), "\n")), "the methods, one a line");
    tool.parameter("method", flag, methods.help(), methods.flags());
    tool.parameter("name", name, "of the method in tables, instead of its own");
    methods.add_options(tool);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        inputs.read();
        const DeformationMethod& method = methods.find(flag);
        const std::unique_ptr<Deformer> deformer = method.make(BodyPoser(inputs.body_template, inputs.samples.posing));
        if (name.empty()) name = deformer->name();
        if (name.empty()) name = method.table_name;
        animate_samples(inputs, *deformer, name, outputs, tool.provenance());
        fmt::print("{} samples of split {} deformed by {}\n", inputs.samples.size(), inputs.split, name);
    });
}
