// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/blas_kernels.h"
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/layers/layer_batch.h"
#include "ndg/measures/measure_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

using namespace ndg;

namespace {

void print_statistics(const LayerBatch& batch)
{
    const auto column = [&](const std::string& name) {
        const auto& names = batch.bodies.parameter_names;
        return batch.bodies.parameters.col(std::find(names.begin(), names.end(), name) - names.begin()).eval();
    };
    const auto range = [&](const std::string& name) {
        const Eigen::VectorXd values = column(name);
        return fmt::format("{:.2f} to {:.2f}", values.minCoeff(), values.maxCoeff());
    };
    fmt::print("bodies: {}, invalid rest prisms: 0, smallest scaled Jacobian {:.3f}\n", batch.bodies.bodies.size(),
               column("min_scaled_jacobian").minCoeff());
    fmt::print("BMI {}, fat share {}, fat layer {} l, muscle layer {} l\n", range("bmi"), range("fat_share"),
               range("fat_layer_litre"), range("muscle_layer_litre"));
    fmt::print("skin displacement: mean {:.3f} mm, of the worst body {:.3f} mm, largest {:.2f} mm\n",
               1e3 * column("mean_skin_displacement_m").mean(), 1e3 * column("mean_skin_displacement_m").maxCoeff(),
               1e3 * column("max_skin_displacement_m").maxCoeff());
    fmt::print(
        "core-seconds a body: mean {:.2f}, largest {:.2f}\n",
        std::accumulate(batch.seconds.begin(), batch.seconds.end(), 0.0) / static_cast<double>(batch.seconds.size()),
        *std::max_element(batch.seconds.begin(), batch.seconds.end()));
    if (batch.num_resumed > 0) fmt::print("{} skins were finished by an earlier run\n", batch.num_resumed);
}

/// Names the bodies that miss a gate of the measures and, unless `keep`, takes them out. Returns how many were taken.
std::size_t judge(LayerBatch& batch, const Template& body_template, bool keep)
{
    const std::vector<MeasuredBody> measured = measure_people(body_template, batch.bodies);
    fmt::print("{}", failure_report(measured));
    if (keep) return 0;
    LayerBatch kept = batch;
    kept.bodies.bodies.clear();
    kept.seconds.clear();
    for (std::size_t b = 0; b < measured.size(); ++b) {
        if (!measured[b].failures().empty()) continue;
        kept.bodies.parameters.row(kept.bodies.bodies.size()) = batch.bodies.parameters.row(b);
        kept.bodies.bodies.push_back(std::move(batch.bodies.bodies[b]));
        kept.seconds.push_back(batch.seconds[b]);
    }
    kept.bodies.parameters.conservativeResize(kept.bodies.bodies.size(), Eigen::NoChange);
    batch = std::move(kept);
    return measured.size() - batch.bodies.bodies.size();
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "build-layers",
        "Builds the layers of every skin: bone wrap, muscle wrap, bone interior, all prisms valid; fat and muscle "
        "from the skin's girths. Bodies whose bones, joints or flesh lie outside of published ranges (the gates that "
        "ndg-info BODIES --template TEMPLATE lists) are named and left out, as skins without layers are.",
        "build-layers --template template.h5 --skins skins.h5 --output bodies.h5");
    std::string template_path, skins_path, output;
    LayerFitOptions options;
    PeopleOptions people_options;
    bool keep_outside = false;
    double min_passed = 1.0;
    tool.input("template", template_path, "template file");
    tool.input("skins", skins_path, "skins in the template's tessellation");
    tool.output("output", output, "bodies file to write");
    tool.options(people_options);
    tool.options(options);
    tool.parameter("keep-outside", keep_outside, "write bodies outside of published ranges too; they are still named");
    tool.parameter("min-passed", min_passed, "exit code 3 when a smaller share of the skins becomes bodies", 0.0, 1.0);
    return tool.run(argc, argv, [&] {
        restart_with_better_blas(argv);
        catch_interrupts();
        const Template body_template = read_template(template_path);
        const SkinSet skins = read_skins(skins_path, body_template);
        const std::vector<Person> people = people_of_skins(skins, skins_path, people_options);
        const Provenance provenance = tool.provenance();
        const LayerBuilder builder(body_template, options);
        const PartStore store(output, body_parts, layers_key(options, body_template.file_sha256), tool.force());
        LayerBatch batch = build_layer_batch(builder, skins, people, store, interrupt_requested);
        batch.bodies.template_sha256 = body_template.file_sha256;
        const std::size_t count = skins.bodies.size(), layered = batch.bodies.bodies.size();
        const std::size_t outside = judge(batch, body_template, keep_outside), built = layered - outside;
        if (built == 0) {
            store.remove();
            throw QualityError(layered == 0
                                   ? fmt::format("none of the {} skins could be given layers", count)
                                   : fmt::format("all of the {} bodies are outside of published ranges", layered));
        }
        write_bodies(output, batch.bodies, provenance);
        store.remove();
        print_statistics(batch);
        fmt::print("{} of {} bodies ({:.1f} %) passed\n", built, count,
                   100.0 * static_cast<double>(built) / static_cast<double>(count));
        if (static_cast<double>(built) < min_passed * static_cast<double>(count))
            throw QualityError(
                fmt::format("of {} skins {} could not be given layers and {} are outside of published "
                            "ranges",
                            count, count - layered, outside));
    });
}
