// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool.h"
#include "ndg/people/exaggeration.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("exaggerate-body",
              "Makes a stylised body of a drawn person: what it differs in from the template body, exaggerated.",
              "exaggerate-body --template template.h5 --skins skins.h5 --body 3 --factor 1.8 --output stylised.h5");
    std::string template_path, skins_path, output;
    int body_idx = 0;
    double factor = 1.8;
    tool.input("template", template_path, "template file");
    tool.input("skins", skins_path, "people, of sample-bodies or fit-body");
    tool.output("output", output, "skins file to write, with one person");
    tool.parameter("body", body_idx, "which of the people", 0, 1 << 30);
    tool.parameter("factor", factor, "times the differences; 1: the person itself", 0.0, 4.0);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const SkinSet skin = exaggerated_person(body_template, read_skins(skins_path, body_template), body_idx, factor);
        write_skins(output, skin, tool.provenance());
        fmt::print("{}: stature {:.2f} m\n", skin.bodies[0].name, skin.bodies[0].skin_vertices.col(1).maxCoeff());
    });
}
