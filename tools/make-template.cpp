// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/source.h"
#include "ndg/body/person.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/people/body_sampling.h"
#include "ndg/procedural/body.h"
#include "ndg/template_build/make_template.h"
#include "ndg/template_build/template_check.h"

#include <fmt/format.h>

using namespace ndg;

namespace {

/// The examples are other people than sample-bodies draws with the same seed.
constexpr std::uint64_t example_seed_offset = 1000;

TemplateSource anatomy_template_source(const std::string& makehuman, const std::string& bodyparts3d, Sex sex)
{
    require_input(!makehuman.empty() && !bodyparts3d.empty(), "--source anatomy needs --makehuman and --bodyparts3d");
    const MakeHuman body(makehuman);
    return anatomy_source(body, bodyparts3d, mean_adult(body, sex == Sex::male)).source;
}

TemplateSource procedural_template_source(Sex sex)
{
    ProceduralParameters person;
    person.sex = male_share(sex);
    person.stature_m = sex == Sex::male ? 1.753 : 1.614;
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
    std::string makehuman, bodyparts3d, output;
    SourceKind kind = SourceKind::procedural;
    Sex sex = Sex::male;
    TemplateOptions options;
    int examples = 48;
    tool.input("makehuman", makehuman, "folder with MakeHuman's 3dobjs, targets and rigs (source anatomy)", false);
    tool.input("bodyparts3d", bodyparts3d, "folder with BodyParts3D's bones, muscles, other, tendons (source anatomy)",
               false);
    tool.output("output", output, "template file to write");
    tool.parameter("source", kind, "where skin and anatomy come from");
    tool.parameter("sex", sex, "of the template body");
    tool.options(options);
    tool.parameter("examples", examples, "people of the source kept in the template, for fits of scans", 0, 1000);
    return tool.run(argc, argv, [&] {
        const TemplateSource source = kind == SourceKind::anatomy ? anatomy_template_source(makehuman, bodyparts3d, sex)
                                                                  : procedural_template_source(sex);
        Template made = make_template(source, options);
        if (examples > 0) {
            made.examples = sample_skins(made, makehuman, examples, tool.seed() + example_seed_offset, {}).bodies;
        }
        write_template(output, made, tool.provenance(source.licence));
        const TemplateCheck check = check_template(read_template(output));
        fmt::print("{}", template_report(check));
        if (!check.passes()) throw QualityError(output + ": the template misses a gate of its check");
    });
}
