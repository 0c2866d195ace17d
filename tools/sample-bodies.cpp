// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/body_sampling.h"
#include "ndg/core/tool.h"
#include "ndg/geometry/triangle_mesh.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("sample-bodies",
              "Draws adults from MakeHuman's parameters and writes their skins in the template's tessellation.",
              "sample-bodies --template template.h5 --makehuman DATA/makehuman --count 24 --output skins.h5");
    std::string template_path, makehuman, output;
    int count = 24;
    BodySamplingOptions options;
    tool.input("template", template_path, "template file");
    tool.input("makehuman", makehuman, "folder with MakeHuman's 3dobjs, targets and rigs");
    tool.output("output", output, "skins file to write");
    tool.parameter("count", count, "number of bodies", 1, 100000);
    tool.parameter("spread", options.spread, "standard deviation of the body sliders", 0.0, 0.5);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const MakeHuman source(makehuman);
        BodySet skins;
        skins.parameter_names = {"sex", "age_years", "stature_m", "mass_kg", "bmi"};
        skins.parameters.resize(count, 5);
        for (int b = 0; b < count; ++b) {
            const MakeHumanParameters p = sample_parameters(tool.seed(), b, options);
            skins.bodies.push_back(skin_on_template(body_template, source.evaluate(p), fmt::format("body_{:04d}", b)));
            const Points& skin = skins.bodies.back().skin_vertices;
            const double height = stature(skin),
                         mass = body_density * enclosed_volume(skin, body_template.skin_triangles);
            skins.parameters.row(b) << p.sex, makehuman_age_years(p.age), height, mass, mass / (height * height);
        }
        write_skins(output, skins, tool.provenance(makehuman_licence));
        fmt::print("skins: {} bodies, stature {:.2f} to {:.2f} m, mass {:.0f} to {:.0f} kg, BMI {:.1f} to {:.1f}\n",
                   count, skins.parameters.col(2).minCoeff(), skins.parameters.col(2).maxCoeff(),
                   skins.parameters.col(3).minCoeff(), skins.parameters.col(3).maxCoeff(),
                   skins.parameters.col(4).minCoeff(), skins.parameters.col(4).maxCoeff());
    });
}
