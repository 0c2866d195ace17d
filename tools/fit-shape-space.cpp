// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/sample_set.h"
#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"

#include <fmt/format.h>

#include <algorithm>

using namespace ndg;

namespace {

/// Distances of decoded from true vertices over some bodies, m.
struct Reconstruction {
    double sum = 0.0, largest = 0.0;
    int num_bodies = 0;

    double mean() const { return num_bodies > 0 ? sum / num_bodies : 0.0; }
};

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
    tool.input("splits", splits_path, "splits; only bodies of the train split are fitted");
    tool.output("output", output_path, "shape space to write");
    tool.parameter("max-components", max_components, "largest number of components kept", 1, 100000);
    tool.parameter("variance", variance, "share of the training variance after which no more are kept", 1e-6, 1.0);

    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        const auto num_bodies = static_cast<int>(bodies.bodies.size());
        const std::vector<int> train = read_splits(splits_path, num_bodies).bodies.at("train");

        std::vector<const Points*> shapes;
        for (const int body_idx : train) {
            shapes.push_back(&bodies.bodies[static_cast<std::size_t>(body_idx)].volume_vertices);
        }
        log_info("Fitting a shape space to {} of {} bodies", train.size(), num_bodies);
        const ShapeSpace space = fit_shape_space(shapes, max_components, variance);

        RowMatrix codes(num_bodies, space.dimension());
        std::vector<double> errors;
        Reconstruction fitted, held_out;
        for (int i = 0; i < num_bodies; ++i) {
            const Points& vertices = bodies.bodies[static_cast<std::size_t>(i)].volume_vertices;
            const Eigen::VectorXd code = space.encode(vertices);
            const Eigen::VectorXd distances = (space.decode(code) - vertices).rowwise().norm();
            codes.row(i) = code.transpose();
            errors.push_back(distances.mean());
            const bool is_train = std::find(train.begin(), train.end(), i) != train.end();
            Reconstruction& reconstruction = is_train ? fitted : held_out;
            reconstruction.sum += distances.mean();
            for (const double distance : distances) {
                reconstruction.largest = std::max(reconstruction.largest, distance);
            }
            ++reconstruction.num_bodies;
        }
        write_shape_space(output_path, space, codes, errors, tool.provenance());
        fmt::print("{}: {} components of {} training bodies explain {:.4f} % of the variance\n", output_path,
                   space.dimension(), train.size(), 100.0 * space.explained_variance);
        fmt::print(
            "reconstruction error: train mean {:.3f} mm, max {:.3f} mm; {} held-out bodies mean {:.3f} mm, "
            "max {:.3f} mm\n",
            1e3 * fitted.mean(), 1e3 * fitted.largest, held_out.num_bodies, 1e3 * held_out.mean(),
            1e3 * held_out.largest);
    });
}
