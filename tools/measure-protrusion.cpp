// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/protrusion/external_frames.h"
#include "ndg/protrusion/protrusion_json.h"

#include <algorithm>
#include <filesystem>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "measure-protrusion",
        "Measures in how many frames bones and muscles cross the skin or stick out of it, and by how much (Table 3).",
        "measure-protrusion --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
        "--deformations ndg.h5 --deformations lbs.h5 --external exports/SKEL --output protrusion.json");
    SampleInputs inputs;
    std::vector<std::string> deformation_paths, folders;
    std::string output;
    int max_pairs = 500;  // NDG 5.3
    inputs.add_files(tool);
    inputs.add_samples(tool);
    tool.input("deformations", deformation_paths, "deformations of one method; may be given several times");
    tool.input("external", folders,
               "folder of meshes of another model, which is called like the folder (docs/formats.md); may be given "
               "several times",
               false);
    tool.output("output", output, "JSON to write: table3 and counts");
    tool.parameter("pairs", max_pairs, "so many of the split's pairs, spread evenly; 0: all", 0, 1000000);
    return tool.run(argc, argv, [&] {
        inputs.read();
        const std::vector<SamplePair>& all = inputs.samples.pairs;
        const int count = max_pairs == 0 ? int(all.size()) : std::min(max_pairs, int(all.size()));
        std::vector<SamplePair> pairs;
        for (int i = 0; i < count; ++i) pairs.push_back(all[std::int64_t(i) * int(all.size()) / count]);
        std::vector<ProtrusionInput> files;
        for (const std::string& path : deformation_paths)
            files.push_back({path, open_deformations(path, inputs.body_template.num_volume_vertices())});
        const ProtrusionTable table =
            body_protrusion(inputs.body_template, inputs.bodies, inputs.poses.poses, pairs, files);
        std::vector<ProtrusionRow> external;
        for (const std::string& folder : folders)
            external.push_back(external_protrusion(
                std::filesystem::path(folder + "/").lexically_normal().parent_path().filename().string(), folder));
        write_file(output, protrusion_json(table, external));

        fmt::print("{} pairs of {} bodies, {} left out because limbs pass through each other or the trunk\n",
                   table.pairs, table.bodies, table.colliding_pairs);
        fmt::print("at rest: anatomy crosses the skin of {} bodies and sticks out of that of {}\n",
                   table.bodies_intersecting_at_rest, table.bodies_protruding_at_rest);
        if (table.bodies_intersecting_at_rest > 0)
            fmt::print("  most bodies: {}\n", fmt::join(most_frequent(table.parts_intersecting_at_rest), ", "));
        const auto print = [](const ProtrusionRow& row) {
            fmt::print("{:<40} {:5.1f} % of {} frames intersect, {:5.1f} % protrude, {:.2f} mm, at most {:.1f} mm {}\n",
                       row.method, row.intersecting_frames, row.frames, row.protruding_frames, row.protrusion_mm,
                       row.max_protrusion_mm, row.deepest);
            if (!row.intersecting_parts.empty())
                fmt::print("  cross in most frames: {}\n", fmt::join(most_frequent(row.intersecting_parts), ", "));
            if (!row.protruding_parts.empty())
                fmt::print("  stick out in most frames: {}\n", fmt::join(most_frequent(row.protruding_parts), ", "));
        };
        for (const ProtrusionRow& row : table.rows) print(row);
        for (const ProtrusionRow& row : external) print(row);
    });
}
