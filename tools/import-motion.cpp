// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/retarget/import_motions.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    MotionFiles files;
    MotionImportOptions options;
    std::string template_path, output_path, report_path, licence;

    Tool tool("import-motion", "Brings motion capture onto the project's skeleton.",
              "import-motion --motion mocap/ --template template.h5 --joint-maps configs/joint-maps --joint-limits "
              "configs/joint-limits.json --output poses.h5 --report report.json");
    files.add(tool, true);
    tool.input("template", template_path, "template whose rest joints the poses start from");
    tool.output("output", output_path, "poses to write");
    tool.output("report", report_path, "all figures of every clip, JSON", false);
    tool.options(options);
    tool.parameter("licence", licence, "licence and credit line of the motions, kept in the output");

    return tool.run(argc, argv, [&] {
        files.complete();
        const ImportedMotions imported =
            import_motions(files, options, read_template(template_path).rest.joint_positions,
                           [](const std::string& line) { fmt::print("{}\n", line); });
        if (licence.find(imported.licences) == std::string::npos)
            licence += (licence.empty() ? "" : "; ") + imported.licences;
        write_poses(output_path, imported.poses, tool.provenance(licence));
        if (!report_path.empty()) write_file(report_path, report_json(imported.reports));
        if (!imported.reports.empty()) fmt::print("{}", report_table(imported.reports));
        const int num_motions =
            int(imported.reports.size()) + imported.num_own + imported.num_copies + imported.num_unmapped;
        fmt::print("{}: {} poses of {} motions; {} were copies of takes read before, {} had no joint map\n",
                   output_path, imported.poses.size(), num_motions, imported.num_copies, imported.num_unmapped);
        imported.check();
    });
}
