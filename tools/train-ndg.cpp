// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/shape_space.h"
#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/log.h"
#include "ndg/core/progress.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/neural/train.h"
#include "ndg/scene/line_chart.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

using namespace ndg;

namespace {

/// Losses over the epochs.
Image losses_picture(const TrainingCurve& curve, const std::string& method)
{
    const std::vector<double> epochs(curve.epoch.begin(), curve.epoch.end());
    const auto best = static_cast<std::size_t>(curve.best_epoch - 1);
    return line_chart(
        {{"training", epochs, curve.train_loss, {31, 119, 180}},
         {"validation", epochs, curve.validation_loss, {214, 39, 40}}},
        {method,
         fmt::format("epoch; the best, {}, has validation loss {:.3e}", curve.best_epoch, curve.validation_loss[best]),
         "mean squared error"});
}

}  // namespace

int main(int argc, char** argv)
{
    SampleInputs inputs;
    std::string shape_path, output_path, picture_path;
    std::vector<std::string> samples_paths;
    NetworkOptions network;
    TrainingOptions training;
    Device device = Device::cpu;
    double cache_gigabytes = 4.0;
    int max_samples = 0;

    Tool tool("train-ndg", "Trains the network that predicts deformation gradients from pose and body shape.",
              "train-ndg --template template.h5 --bodies bodies.h5 --poses poses.h5 --shape-space shapes.h5 "
              "--samples fem.h5 --output model.h5");
    inputs.add_files(tool);
    tool.input("shape-space", shape_path, "shape space of the training bodies");
    tool.input("samples", samples_paths, "simulated samples, one file or several shards");
    // The checkpoint beside the output is what is resumed; a finished model is never overwritten without --force.
    tool.output("output", output_path, "model to write");
    tool.output("picture", picture_path, "PNG picture of the losses", false);
    tool.options(network);
    tool.options(training);
    tool.parameter("cache-gigabytes", cache_gigabytes, "memory for keeping targets and what they are made with", 0.0,
                   1e6);
    tool.parameter("max-samples", max_samples,
                   "training samples used, the first of the split (each body and pose in even turns); 0: all", 0,
                   1000000000);
    tool.parameter("device", device, "where the network is trained");

    return tool.run(argc, argv, [&] {
        catch_interrupts();
        training.seed = tool.seed();
        training.checkpoint_path = checkpoint_path_for(output_path);
        network.check();
        check_options(training);
        require_available(device);
        if (tool.force()) remove_checkpoint(training.checkpoint_path);

        inputs.read();
        const Template& body_template = inputs.body_template;
        const ShapeSpace shape_space = read_shape_space(shape_path);
        std::vector<DeformationSet> samples;
        for (const std::string& path : samples_paths)
            samples.push_back(open_deformations(path, body_template.num_volume_vertices()));

        network.posing = samples.front().posing;
        NeuralModel model(network, shape_space, body_template, tool.seed(), device);
        const auto make_set = [&](const std::string& split, double share_of_cache, int used) {
            return TrainingSet(model, body_template, inputs.bodies, inputs.poses, samples, split,
                               share_of_cache * cache_gigabytes, used);
        };
        const TrainingSet training_set = make_set("train", 0.85, max_samples);
        const TrainingSet validation_set = make_set("validation", 0.15, 0);
        log_info("{} training and {} validation samples ({} unconverged ones left out), {} prisms", training_set.size(),
                 validation_set.size(), training_set.num_unconverged() + validation_set.num_unconverged(),
                 body_template.num_prisms());
        log_info("threads: {}; products in {}{}, weights and sums in float32", num_threads(),
                 to_name(resolve_precision(training.precision, device)),
                 training.precision == Precision::automatic ? " (precision auto)" : "");

        TrainingCallbacks callbacks;
        std::unique_ptr<Progress> progress;
        std::size_t shown = 0;
        callbacks.epoch_done = [&](const TrainingCurve& curve, double learning_rate) {
            if (!progress) progress = std::make_unique<Progress>("training", static_cast<std::size_t>(training.epochs));
            progress->advance(curve.epoch.size() - shown);
            shown = curve.epoch.size();
            log_debug("epoch {}: training loss {:.4e}, validation loss {:.4e}, best epoch {}, learning rate {:.2e}",
                      curve.epoch.back(), curve.train_loss.back(), curve.validation_loss.back(), curve.best_epoch,
                      learning_rate);
        };
        const TrainingResult result = train(model, training_set, validation_set, training, callbacks);
        progress.reset();
        if (!picture_path.empty()) write_png(picture_path, losses_picture(model.curve(), method_name(model.options())));
        model.save(output_path, tool.provenance());
        remove_checkpoint(training.checkpoint_path);

        const TrainingCurve& curve = model.curve();
        const auto best = static_cast<std::size_t>(curve.best_epoch - 1);
        fmt::print(
            "{}: {} samples, {} left out as unconverged; {} epochs{}, best {}: training loss {:.4e}, validation "
            "loss {:.4e} (untrained {:.4e} and {:.4e}), {} weights\n",
            output_path, training_set.size() + validation_set.size(),
            training_set.num_unconverged() + validation_set.num_unconverged(), result.epochs_run,
            result.stopped_early ? ", stopped early" : "", curve.best_epoch, curve.train_loss[best],
            curve.validation_loss[best], curve.initial_train_loss, curve.initial_validation_loss,
            model.num_parameters());
    });
}
