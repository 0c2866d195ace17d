// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/source.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/procedural/body.h"
#include "ndg/template_build/make_template.h"
#include "ndg/template_build/template_check.h"

#include <fmt/format.h>

using namespace ndg;

namespace {

TemplateSource anatomy_template_source(const std::string& makehuman, const std::string& bodyparts3d,
                                       const std::string& sex)
{
    require_input(!makehuman.empty() && !bodyparts3d.empty(), "--source anatomy needs --makehuman and --bodyparts3d");
    const MakeHuman body(makehuman);
    MakeHumanParameters person;
    person.sex = sex == "male" ? 1.0 : 0.0;
    return anatomy_source(body, bodyparts3d, person).source;
}

TemplateSource procedural_template_source(const std::string& sex)
{
    ProceduralParameters person;
    person.sex = sex == "male" ? 1.0 : 0.0;
    person.stature_m = sex == "male" ? 1.753 : 1.614;
    person.mass_kg = 23.5 * person.stature_m * person.stature_m;
    return ProceduralBody().source(person);
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "make-template",
        "Builds the layered template: skin, muscle wrap, bone wrap, prisms between them, tetrahedra inside, bones "
        "and muscles embedded. Either from MakeHuman's body with BodyParts3D's anatomy, or from the built-in "
        "procedural body, which needs no file.",
        "make-template --source procedural --prisms 6000 --output template.h5");
    std::string source_name = "procedural", sex = "male", makehuman, bodyparts3d, output;
    TemplateOptions options;
    tool.input("makehuman", makehuman, "folder with MakeHuman's 3dobjs, targets and rigs (source anatomy)", false);
    tool.input("bodyparts3d", bodyparts3d, "folder with BodyParts3D's bones, muscles, other, tendons (source anatomy)",
               false);
    tool.output("output", output, "template file to write");
    tool.parameter("source", source_name, "where skin and anatomy come from", {"anatomy", "procedural"});
    tool.parameter("sex", sex, "of the template body", {"male", "female"});
    tool.parameter("prisms", options.prisms, "wanted number of prisms, reached within a few percent", 1000, 500000);
    tool.parameter("keep-ratio", options.keep_ratio, "share of triangles kept on head, hands and toes", 0.01, 1.0);
    tool.parameter("bone-cover", options.cover.bone, "least depth of bones under the skin, m", 0.0, 0.02);
    tool.parameter("muscle-cover", options.cover.muscle, "least depth of muscles under the skin, m", 0.0, 0.02);
    tool.parameter("min-scaled-jacobian", options.wraps.min_scaled_jacobian, "no prism flatter than this is wanted",
                   0.001, 0.5);
    return tool.run(argc, argv, [&] {
        const TemplateSource source = source_name == "anatomy" ? anatomy_template_source(makehuman, bodyparts3d, sex)
                                                               : procedural_template_source(sex);
        const Template made = make_template(source, options);
        write_template(output, made, tool.provenance(source.licence));
        const TemplateCheck check = check_template(read_template(output));
        fmt::print("{}", template_report(check));
        if (!check.passes()) throw QualityError(output + ": the template misses a gate of its check");
    });
}
