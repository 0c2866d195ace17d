// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/reconstruct.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("reconstruct", "Turns deformation gradients into vertices, and into embedded anatomy if wanted.",
              "reconstruct --template template.h5 --bodies bodies.h5 --poses poses.h5 --gradients gradients.h5 "
              "--output ndg.h5");
    std::string template_path, bodies_path, poses_path, gradients_path, output, anatomy;
    tool.input("template", template_path, "template");
    tool.input("bodies", bodies_path, "bodies");
    tool.input("poses", poses_path, "poses");
    tool.input("gradients", gradients_path, "deformation gradients of samples");
    tool.output("output", output, "deformed samples");
    tool.output("anatomy", anatomy, "embedded anatomy of every sample", false);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const PoseSet poses = read_poses(poses_path);
        const GradientReader gradients(gradients_path, body_template.num_prisms());
        const DeformationSet set =
            reconstruct_samples(body_template, bodies, poses, gradients, anatomy, tool.provenance());
        write_deformations(output, set, tool.provenance());
        fmt::print("{} samples of {} reconstructed\n", set.size(), set.method);
    });
}
