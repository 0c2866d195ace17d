// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/layers.h"
#include "ndg/core/hash.h"
#include "ndg/core/tool.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("build-layers",
              "Builds the layers of every skin: bone wrap, muscle wrap, bone interior, all prisms valid.",
              "build-layers --template template.h5 --skins skins.h5 --output bodies.h5");
    std::string template_path, skins_path, output;
    double min_scaled_jacobian = 0.08;
    tool.input("template", template_path, "template file");
    tool.input("skins", skins_path, "skins in the template's tessellation");
    tool.output("output", output, "bodies file to write");
    tool.parameter("min-scaled-jacobian", min_scaled_jacobian, "prisms flatter than this are improved", 0.001, 0.5);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        BodySet bodies =
            build_layers(body_template, read_skins(skins_path, body_template), skins_path, min_scaled_jacobian);
        bodies.template_sha256 = sha256_path(template_path);
        write_bodies(output, bodies, tool.provenance());
        const auto range = [&](int column) {
            return fmt::format("{:.2f} to {:.2f}", bodies.parameters.col(column).minCoeff(),
                               bodies.parameters.col(column).maxCoeff());
        };
        fmt::print("bodies: {}, invalid rest prisms: 0, smallest scaled Jacobian {:.3f}\n", bodies.bodies.size(),
                   bodies.parameters.rightCols(1).minCoeff());
        fmt::print("BMI {}, fat layer {} l, muscle layer {} l\n", range(4), range(7), range(8));
    });
}
