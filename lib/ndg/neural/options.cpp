// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/options.h"

#include "ndg/core/error.h"
#include "ndg/neural/output_space.h"

#include <fmt/ranges.h>
#include <torch/cuda.h>

namespace ndg {

void require_available(Device device)
{
    require_input(device != Device::cuda || torch::cuda::is_available(),
                  "device cuda is not available: no CUDA device, or libtorch was built without CUDA");
}

Precision resolve_precision(Precision precision, Device device)
{
    if (device == Device::cuda) return precision == Precision::bfloat16 ? precision : Precision::float32;
#ifdef __x86_64__
    const bool fast = __builtin_cpu_supports("amx-bf16"), possible = __builtin_cpu_supports("avx512bw");
#else
    const bool fast = false, possible = false;
#endif
    require_input(precision != Precision::bfloat16 || possible,
                  "precision bfloat16 needs a processor with AVX-512, which this one is not; float32 runs here");
    if (precision != Precision::automatic) return precision;
    return fast ? Precision::bfloat16 : Precision::float32;
}

void NetworkOptions::check() const
{
    check_options(*this);
    require_input(widths.size() <= 16, "widths must name at most 16 hidden layers, not {}", widths.size());
}

void describe(OptionList& list, NetworkOptions& options)
{
    list.add("widths", options.widths, "hidden layers", 1, 1 << 20);
    list.add("output-space", options.output_space, "what is predicted", output_space_names());
    list.add("parametrisation", options.parametrisation, "from nine numbers to a residual gradient");
    list.add("rotation", options.rotation, "predict the residual R^T F; without (ablation): F itself");
    list.add("shape", options.shape, "let the network see the body's shape; without: ablation");
    list.add("region-reach", options.region_reach,
             "0: one network; n: one for each region of the body, which sees joints at most n steps away only", 0,
             num_standard_joints);
    list.add("output-basis", options.output_basis,
             "0: trained last layer; k: fixed basis of at most k principal components of the training outputs", 0,
             1 << 16);
    list.add("output-basis-variance", options.output_basis_variance,
             "share of the outputs' squares after which the basis takes no more components", 1e-6, 1);
    list.add("bone-wrap", options.posing.bone_wrap, "of the training samples").no_flag();
}

std::string method_name(const NetworkOptions& options)
{
    const bool vertices = options.output_space == "vertex-offsets";
    std::vector<std::string> changes;
    if (options.region_reach > 0) changes.emplace_back("regional");
    if (!vertices) {
        if (options.output_basis > 0) changes.emplace_back("fixed basis");
        if (options.parametrisation == ParametrisationKind::direct) changes.emplace_back("no matrix exp");
        if (options.parametrisation == ParametrisationKind::lu) changes.emplace_back("LU");
        if (options.parametrisation == ParametrisationKind::qr) changes.emplace_back("QR");
        if (!options.rotation) changes.emplace_back("no rotation");
    } else if (options.output_basis == 0) {
        changes.emplace_back("no PCA");
    }
    if (!options.shape) changes.emplace_back("no body shape");
    const char* name = vertices ? "VertexNet" : "NDG";
    return changes.empty() ? name : fmt::format("{} {}", name, fmt::join(changes, ", "));
}

void describe(OptionList& list, AugmentationOptions& options)
{
    list.add("mirror", options.mirror, "show every other training sample in the mirror");
    list.add("splice", options.splice, "share of training samples that take limbs of another pose of their body", 0, 1);
}

void describe(OptionList& list, TrainingOptions& options)
{
    list.add("epochs", options.epochs, "passes over the training samples", 1, 1000000);
    list.add("batch-size", options.batch_size, "samples a step", 1, 1000000);
    list.add("learning-rate", options.learning_rate, "of AdamW", 1e-12, 10);
    list.add("weight-decay", options.weight_decay, "of AdamW, on matrices", 0, 1000);
    list.add("schedule", options.schedule, "of the learning rate");
    list.add("precision", options.precision,
             "of factors in products (weights and sums are float32); auto: bfloat16 on processors with AMX, where "
             "it is faster");
    list.add("dropout", options.dropout, "probability, after each hidden layer", 0, 0.95);
    list.add("weight-average", options.weight_average,
             "decay a step of the average of the weights that becomes the model, 0: no average", 0, 0.9999999);
    list.add("input-noise", options.input_noise, "in standard deviations of each input", 0, 10);
    describe(list, options.augmentation);
    list.add("patience", options.patience, "epochs without improvement before stopping, 0: never", 0, 1000000);
    list.add("checkpoint-seconds", options.checkpoint_seconds, "between checkpoints at least, 0: every epoch", 0, 1e9)
        .run_only();
    list.add("checkpoint-path", options.checkpoint_path, "beside the output").no_flag().run_only();
    list.add("training-seed", options.seed, "of batches, noise and dropout").no_flag();
}

}  // namespace ndg
