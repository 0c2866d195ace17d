// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/deform/baselines.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("animate-baseline", "Deforms a split's samples by a method without physics or network.",
              "animate-baseline --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
              "--method lbs --output lbs.h5");
    std::string template_path, bodies_path, poses_path, splits_path, output;
    std::string split = "test", method = "gradient-skinning";
    tool.input("template", template_path, "template");
    tool.input("bodies", bodies_path, "bodies");
    tool.input("poses", poses_path, "poses");
    tool.input("splits", splits_path, "splits and pairs");
    tool.output("output", output, "deformed samples");
    tool.parameter("split", split, "split to animate", split_names);
    tool.parameter("method", method, "baseline", {"gradient-skinning", "lbs"});
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const PoseSet poses = read_poses(poses_path);
        const Splits splits = read_splits(splits_path, static_cast<int>(bodies.bodies.size()), poses.size());
        const std::vector<SamplePair>& pairs = splits.pairs.at(split);
        require_input(!pairs.empty(), "{}: split {} has no pairs", splits_path, split);
        const DeformationSet set = animate_baseline(body_template, bodies, poses, pairs, split, parse_baseline(method));
        write_deformations(output, set, tool.provenance());
        fmt::print("{} samples of split {} deformed by {}\n", set.size(), split, set.method);
    });
}
