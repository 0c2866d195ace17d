// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/make_splits.h"

#include <fmt/format.h>

using namespace ndg;

int main(int argc, char** argv)
{
    std::string template_path, bodies_path, poses_path, unseen_path, output_path;
    SplitOptions options;
    options.num_pairs = {240, 30, 30};

    Tool tool("make-splits", "Splits bodies and poses into train, validation and test, and pairs them within each.",
              "make-splits --template template.h5 --bodies bodies.h5 --poses sampled.h5 --output splits.h5");
    tool.input("template", template_path, "template of the bodies");
    tool.input("bodies", bodies_path, "bodies");
    tool.input("poses", poses_path, "poses");
    tool.input(
        "unseen-of", unseen_path,
        "splits of a dataset that these bodies are no part of: all bodies in all of its test poses, nothing else",
        false);
    tool.output("output", output_path, "splits and pairs to write");
    tool.options(options);

    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const PoseSet poses = read_poses(poses_path);
        options.seed = tool.seed();
        const int num_bodies = static_cast<int>(bodies.bodies.size());
        const Splits splits =
            unseen_path.empty() ? make_splits(num_bodies, poses, options)
                                : unseen_bodies_splits(read_splits(unseen_path, -1, poses.size()), "test", num_bodies);
        write_splits(output_path, splits, tool.provenance());
        std::size_t num_used = 0;
        for (const std::string& name : split_names) {
            fmt::print("{}: {} bodies, {} poses, {} pairs\n", name, splits.bodies.at(name).size(),
                       splits.poses.at(name).size(), splits.pairs.at(name).size());
            num_used += splits.poses.at(name).size();
        }
        if (!unseen_path.empty()) return;
        fmt::print("{}: {} of {} poses unused, within {} s of another split or spliced from it\n", output_path,
                   static_cast<std::size_t>(poses.size()) - num_used, poses.size(), options.guard_seconds);
    });
}
