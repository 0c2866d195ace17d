// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/make_template.h"
#include "ndg/body_source/makehuman.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "make-template",
        "Builds the layered template from MakeHuman's body: skin, muscle wrap, bone wrap, prisms, tetrahedra inside "
        "the bone wrap, skinning weights and bone shafts.",
        "make-template --makehuman DATA/makehuman --output template.h5");
    std::string makehuman, output;
    TemplateOptions options;
    tool.input("makehuman", makehuman, "folder with MakeHuman's 3dobjs, targets and rigs");
    tool.output("output", output, "template file to write");
    tool.parameter("target-edge-length", options.target_edge_length, "edge length of the volumetric skin, m", 0.004,
                   0.08);
    tool.parameter("keep-ratio", options.keep_ratio, "share of triangles kept on head, hands and toes", 0.01, 1.0);
    tool.parameter("fat-share", options.fat_share, "fat layer's share of the soft tissue of the template body", 0.1,
                   0.8);
    tool.parameter("min-scaled-jacobian", options.min_scaled_jacobian, "prisms flatter than this are improved", 0.001,
                   0.5);
    return tool.run(argc, argv, [&] {
        const MakeHuman source(makehuman);
        const Template made = make_template(source.evaluate({}), source.weights(), options);
        const PrismCheck check = check_prisms(made.rest.volume_vertices, made.prisms);
        require(check.num_invalid == 0, "template: {} invalid prisms, worst {} with Jacobian {:.3g} m^3",
                check.num_invalid, check.worst_prism_idx, check.min_jacobian);
        write_template(output, made, tool.provenance(makehuman_licence));
        const double outside = made.embedding.distances.empty() ? 0.0
                                                                : *std::max_element(made.embedding.distances.begin(),
                                                                                    made.embedding.distances.end());
        fmt::print("template: {} prisms, {} volume vertices, {} tetrahedra, {} skin vertices, {} anatomy vertices\n",
                   made.num_prisms(), made.num_volume_vertices(), made.tetrahedra.rows(),
                   made.rest.skin_vertices.rows(), made.anatomy_vertices.rows());
        fmt::print("invalid rest prisms: 0, smallest scaled Jacobian {:.3f}, embedding within {:.2f} mm\n",
                   check.min_scaled_jacobian, 1e3 * outside);
    });
}
