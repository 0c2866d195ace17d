// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/info/describe_file.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "ndg-info",
        "Explains a file: what it is, what it holds, unit and axes, where it came from, licences. Knows every file "
        "of this project, meshes and scans, motions, and networks in all forms. A template is checked as well: "
        "elements, surfaces, anatomy, weights, volumes and masses. Of the template body, and of bodies or skins "
        "when --template is given, bones, joints and flesh are measured beside what is published of people. Exit "
        "code 2 for a broken file, 3 where a gate does not hold or an input has changed.",
        "ndg-info bodies.h5 --template template.h5");
    FileQuestion file;
    tool.positional_input(file.path, "any file");
    tool.input("template", file.template_path, "template of the bodies or skins, to measure them", false);
    tool.parameter("check", file.check,
                   "read everything, with all checksums, and compare the files it was made of, where they are found; "
                   "exit code 2 if anything is broken");
    return tool.run(argc, argv, [&] {
        const FileReport report = describe_file(file);
        fmt::print("{}", report.text());
        if (!report.failures().empty()) throw QualityError(fmt::format("{}", fmt::join(report.failures(), "; ")));
    });
}
