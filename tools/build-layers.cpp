// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/layers/layer_batch.h"

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

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "build-layers",
        "Builds the layers of every skin: bone wrap, muscle wrap, bone interior, all prisms valid; fat and muscle "
        "from the skin's girths.",
        "build-layers --template template.h5 --skins skins.h5 --output bodies.h5");
    std::string template_path, skins_path, output;
    LayerFitOptions options;
    PeopleOptions people_options;
    tool.input("template", template_path, "template file");
    tool.input("skins", skins_path, "skins in the template's tessellation");
    tool.output("output", output, "bodies file to write");
    tool.options(people_options);
    tool.options(options);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        const Template body_template = read_template(template_path);
        const SkinSet skins = read_skins(skins_path, body_template);
        const std::vector<Person> people = people_of_skins(skins, skins_path, people_options);
        const Provenance provenance = tool.provenance();
        const LayerBuilder builder(body_template, options);
        const PartStore store(output, body_parts, layers_key(options, body_template.file_sha256), tool.force());
        LayerBatch batch = build_layer_batch(builder, skins, people, store, interrupt_requested);
        batch.bodies.template_sha256 = body_template.file_sha256;
        const std::size_t count = skins.bodies.size(), built = batch.bodies.bodies.size();
        if (built == 0) {
            store.remove();
            throw QualityError(fmt::format("none of the {} skins could be given layers", count));
        }
        write_bodies(output, batch.bodies, provenance);
        store.remove();
        print_statistics(batch);
        fmt::print("{} of {} bodies ({:.1f} %) passed\n", built, count,
                   100.0 * static_cast<double>(built) / static_cast<double>(count));
        if (built < count)
            throw QualityError(fmt::format("{} of {} skins could not be given layers", count - built, count));
    });
}
