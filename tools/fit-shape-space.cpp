// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/splits.h"
#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <set>

using namespace ndg;

namespace {

using Shapes = std::vector<const Points*>;

double mean(const std::vector<double>& values)
{
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// One line a number of components: share of the variance, errors of training and held-out bodies.
void print_curve(const ShapeSpace& space, const Shapes& train, const Shapes& held_out)
{
    const Eigen::VectorXd shares = explained_variances(space);
    std::set<int> dimensions = {space.dimension()};
    for (const int dimension : {1, 2, 5, 10, 20, 50, 100, 200, 300})
        if (dimension < space.dimension()) dimensions.insert(dimension);
    fmt::print("{:>10} {:>12} {:>14} {:>9} {:>17} {:>9}\n", "components", "variance %", "train mean mm", "max mm",
               "held-out mean mm", "max mm");
    for (const int dimension : dimensions) {
        const ReconstructionErrors fitted = reconstruction_errors(space, train, dimension);
        fmt::print("{:>10} {:>12.4f} {:>14.3f} {:>9.2f}", dimension, 100.0 * shares[dimension - 1],
                   1e3 * mean(fitted.means), 1e3 * fitted.largest);
        if (!held_out.empty()) {
            const ReconstructionErrors others = reconstruction_errors(space, held_out, dimension);
            fmt::print(" {:>17.3f} {:>9.2f}", 1e3 * mean(others.means), 1e3 * others.largest);
        }
        fmt::print("\n");
    }
}

}  // namespace

int main(int argc, char** argv)
{
    std::string template_path, bodies_path, splits_path, output_path;
    int max_components = 300;
    double variance = 0.9999;

    Tool tool("fit-shape-space", "Fits the PCA of rest shapes to the training bodies.",
              "fit-shape-space --template template.h5 --bodies bodies.h5 --splits splits.h5 --output shape_space.h5");
    tool.input("template", template_path, "template of the bodies");
    tool.input("bodies", bodies_path, "layered bodies");
    tool.input("splits", splits_path, "splits: only bodies of the train split are fitted; without, all are", false);
    tool.output("output", output_path, "shape space to write");
    tool.parameter("max-components", max_components, "largest number of components kept", 1, 100000);
    tool.parameter("variance", variance, "share of the training variance after which no more are kept", 1e-6, 1.0);

    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const auto num_bodies = static_cast<int>(bodies.bodies.size());
        std::vector<char> is_train(bodies.bodies.size(), splits_path.empty());
        if (!splits_path.empty()) {
            const std::vector<int> chosen = read_splits(splits_path, num_bodies).bodies.at("train");
            for (const int body_idx : chosen) is_train[static_cast<std::size_t>(body_idx)] = 1;
        }

        Shapes train, held_out, all;
        for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
            all.push_back(&bodies.bodies[i].volume_vertices);
            (is_train[i] ? train : held_out).push_back(all.back());
        }
        log_info("Fitting a shape space to {} of {} bodies", train.size(), num_bodies);
        const ShapeSpace space = fit_shape_space(train, max_components, variance);
        RowMatrix codes(num_bodies, space.dimension());
        for (int i = 0; i < num_bodies; ++i) codes.row(i) = space.encode(*all[static_cast<std::size_t>(i)]).transpose();
        write_shape_space(output_path, space, codes, reconstruction_errors(space, all, space.dimension()).means,
                          tool.provenance());
        fmt::print("{}: {} components of {} training bodies explain {:.4f} % of the variance; {} bodies held out\n",
                   output_path, space.dimension(), train.size(), 100.0 * space.explained_variance, held_out.size());
        print_curve(space, train, held_out);
    });
}
