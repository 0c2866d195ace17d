// SPDX-License-Identifier: Apache-2.0
// Steps of training on made-up data: the network's products, the parametrisation, the loss, gradients and AdamW; not
// the making of targets, which runs beside. bench/training.py times the same network in Python.
#include "ndg/core/random.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/neural/parametrisation.h"
#include "ndg/neural/training_pass.h"
#include "report.h"

#include <torch/utils.h>

#include <chrono>
#include <ctime>
#include <optional>

using namespace ndg;

namespace {

torch::Tensor random_tensor(std::int64_t rows, std::int64_t columns, double scale)
{
    Random random(1, "bench", static_cast<std::uint64_t>(columns));
    torch::Tensor tensor = torch::empty({rows, columns});
    float* values = tensor.data_ptr<float>();
    for (std::int64_t i = 0; i < tensor.numel(); ++i) values[i] = static_cast<float>(scale * random.normal());
    return tensor;
}

double processor_seconds()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

}  // namespace

int main(int argc, char** argv)
{
    int num_prisms = 15000, num_inputs = 840, batch_size = 32, num_steps = 5;
    std::vector<int> widths = {4096, 4096, 600};
    Precision precision = Precision::automatic;
    ParametrisationKind parametrisation = ParametrisationKind::exponential;
    std::string output_path;
    Tool tool("bench-training", "Times steps of training.", "bench_training --prism-count 15000 --precision bfloat16");
    tool.parameter("prism-count", num_prisms, "prisms; outputs are nine times as many", 1, 1000000);
    tool.parameter("input-count", num_inputs, "inputs", 1, 1000000);
    tool.parameter("widths", widths, "hidden layers", 1, 1 << 20);
    tool.parameter("batch-size", batch_size, "samples a step", 1, 10000);
    tool.parameter("step-count", num_steps, "steps that are timed, after one that is not", 1, 1000000);
    tool.parameter("precision", precision, "of products");
    tool.parameter("parametrisation", parametrisation, "from nine numbers to a residual gradient");
    tool.output("output", output_path, "JSON file to write", false);
    return tool.run(argc, argv, [&] {
        torch::set_num_threads(num_threads());
        const Precision resolved = resolve_precision(precision, Device::cpu);
        TorchNetwork network = make_perceptron(widths, num_inputs, 9 * num_prisms, {}, tool.seed());
        TrainingPass pass(network, resolved);
        AdamW optimizer(network.parameters(), pass.copies(), 0.01);
        const torch::Tensor inputs = random_tensor(batch_size, num_inputs, 0.3);
        const torch::Tensor targets =
            random_tensor(batch_size, 9 * num_prisms, 0.1) + torch::eye(3).reshape({1, 9}).repeat({1, num_prisms});
        double first_loss = 0, last_loss = 0;
        const auto step = [&] {
            const torch::Tensor outputs = pass.forward(inputs, 0);
            const torch::Tensor residuals = find_parametrisation(parametrisation)
                                                .residuals(outputs.reshape({batch_size, -1, 9}))
                                                .reshape(outputs.sizes());
            const torch::Tensor loss = torch::mse_loss(residuals, targets);
            last_loss = loss.item<double>();
            loss.backward();
            optimizer.begin_step(1e-5);  // made-up targets: so small that the loss falls from the first step on
            pass.backward(outputs.grad(), optimizer);
        };
        step();
        first_loss = last_loss;
        const auto start = std::chrono::steady_clock::now();
        const double processor_start = processor_seconds();
        for (int i = 0; i < num_steps; ++i) step();
        const double processor = processor_seconds() - processor_start;
        const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        require(last_loss < first_loss, "the loss went from {} to {}", first_loss, last_loss);

        bench::Report report("training");
        report.add("prisms", num_prisms);
        report.add("threads", num_threads());
        report.add("bfloat16", resolved == Precision::bfloat16);
        report.add("seconds_a_step", wall / num_steps);
        report.add("core_seconds_a_step", processor / num_steps);
        report.add("samples_a_second", batch_size * num_steps / wall);
        report.print();
        if (!output_path.empty()) report.write(output_path);
    });
}
