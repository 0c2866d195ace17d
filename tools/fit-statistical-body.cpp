// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/fit_statistical_body.h"
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/splits.h"

#include <fmt/format.h>

#include <numeric>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("fit-statistical-body",
              "Makes a statistical body (skins linear in shape and pose) of a template, its bodies and correctives.",
              "fit-statistical-body --template template.h5 --bodies bodies.h5 --splits splits.h5 "
              "--shape-space shape_space.h5 --correctives correctives.h5 --output statistical_body.h5");
    std::string template_path, bodies_path, splits_path, space_path, correctives_path, output_path;
    StatisticalBodyOptions options;
    tool.input("template", template_path, "template of the bodies");
    tool.input("bodies", bodies_path, "layered bodies");
    tool.input("splits", splits_path, "splits: only bodies of the train split are fitted; without, all are", false);
    tool.input("shape-space", space_path, "shape space of these bodies (fit-shape-space)");
    tool.input("correctives", correctives_path,
               "blend shapes linear in the pose (fit-correctives); without, skins have none", false);
    tool.output("output", output_path, "statistical body to write");
    tool.options(options);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const ShapeSpace space = read_shape_space(space_path);
        std::vector<int> fitted(bodies.bodies.size());
        std::iota(fitted.begin(), fitted.end(), 0);
        if (!splits_path.empty()) {
            const Splits splits = read_splits(splits_path, int(bodies.bodies.size()));
            const auto train = splits.bodies.find("train");
            require_input(train != splits.bodies.end() && !train->second.empty(), "{}: no body of the split \"train\"",
                          splits_path);
            fitted = train->second;
        }
        LinearCorrectives correctives;
        if (!correctives_path.empty()) correctives = read_correctives(correctives_path, body_template);
        BodyErrors errors;
        const StatisticalBody body = fit_statistical_body(
            body_template, bodies, fitted, space, correctives_path.empty() ? nullptr : &correctives, options, errors);
        write_statistical_body(output_path, body, tool.provenance());
        fmt::print("{}: {} vertices, {} joints, {} shape directions, pose directions of {} joints\n", output_path,
                   body.num_vertices(), body.num_joints(), body.num_shapes(), body.pose_joints.size());
        const auto print = [](const char* what, double mean, double largest) {
            fmt::print("{:>34}: mean {:.2f} mm, largest {:.2f} mm\n", what, 1e3 * mean, 1e3 * largest);
        };
        print("skins by shape", errors.mean_skin, errors.largest_skin);
        print("joints regressed from skins", errors.mean_joint, errors.largest_joint);
        print("joints of bodies not regressed", errors.mean_held_out, errors.largest_held_out);
    });
}
