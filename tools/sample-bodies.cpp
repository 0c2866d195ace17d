// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool.h"
#include "ndg/people/body_sampling.h"
#include "ndg/procedural/body.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("sample-bodies",
              "Draws adults from the source the template was made from (MakeHuman or the built-in procedural body) and "
              "writes their skins in the template's tessellation.",
              "sample-bodies --template template.h5 --count 24 --output skins.h5");
    std::string template_path, makehuman, output;
    int count = 24;
    BodySamplingOptions options;
    tool.input("template", template_path, "template file");
    tool.input("makehuman", makehuman, "folder with MakeHuman's 3dobjs, targets and rigs (templates made from it)",
               false);
    tool.output("output", output, "skins file to write");
    tool.parameter("count", count, "number of bodies", 1, 100000);
    tool.options(options);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const SkinSet skins = sample_skins(body_template, makehuman, count, tool.seed(), options);
        const bool anatomy = find_name<SourceKind>(body_template.source_name) == SourceKind::anatomy;
        write_skins(output, skins, tool.provenance(anatomy ? makehuman_licence : procedural_licence));
        const Eigen::RowVectorXd low = skins.parameters.colwise().minCoeff();
        const Eigen::RowVectorXd high = skins.parameters.colwise().maxCoeff();
        fmt::print("skins: {} bodies, stature {:.2f} to {:.2f} m, mass {:.0f} to {:.0f} kg, BMI {:.1f} to {:.1f}\n",
                   count, low[2], high[2], low[3], high[3], low[4], high[4]);
        fmt::print("{}", sampling_table(skins, options));
    });
}
