// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/animate.h"
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/deform/gradient_skinning.h"
#include "ndg/deform/lbs_deformer.h"
#include "ndg/deform/stored_gradients.h"
#include "ndg/fem/fem_deformer.h"
#ifdef NDG_WITH_TORCH
#include "ndg/neural/network_deformer.h"
#endif

int main(int argc, char** argv)
{
    using namespace ndg;
    // The table of methods: its order is that of result tables and pictures.
    MethodTable methods;
    register_fem(methods);
#ifdef NDG_WITH_TORCH
    register_network_deformer(methods);
#endif
    register_gradient_skinning(methods);
    register_lbs(methods);
    register_stored_gradients(methods);

    Tool tool("animate", "Poses bodies with their flesh, by one of several methods.",
              "animate --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 --method ndg "
              "--model model.h5 --output ndg.h5");
    SampleInputs inputs;
    AnimationOutputs outputs;
    std::string flag = "gradient-skinning", name;
    inputs.add_files(tool);
    inputs.add_samples(tool);
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
        const std::unique_ptr<Deformer> deformer = method.make(inputs.body_template);
        if (name.empty()) name = deformer->name();
        if (name.empty()) name = method.table_name;
        animate_samples(inputs, *deformer, name, outputs, tool.provenance());
        fmt::print("{} samples of split {} deformed by {}\n", inputs.samples.size(), inputs.split, name);
    });
}
