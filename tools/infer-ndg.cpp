// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/progress.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/gradient_file.h"
#include "ndg/dataset/splits.h"
#include "ndg/neural/model.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

using namespace ndg;

int main(int argc, char** argv)
{
    std::string model_path, template_path, bodies_path, poses_path, splits_path, output_path;
    std::string split = "test", device_name = "cpu", method = "NDG";
    int body_idx = -1, batch_size = 16;

    Tool tool(
        "infer-ndg", "Predicts deformation gradients with a trained network.",
        "infer-ndg --model model.h5 --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
        "--split test --output gradients.h5");
    tool.input("model", model_path, "trained model");
    tool.input("template", template_path, "template");
    tool.input("bodies", bodies_path, "layered bodies");
    tool.input("poses", poses_path, "poses");
    tool.input("splits", splits_path, "pairs to predict; without it: every pose of --body", false);
    tool.output("output", output_path, "deformation gradients to write");
    tool.parameter("split", split, "whose pairs are predicted; with --body, the name given to all", split_names);
    tool.parameter("body", body_idx, "body in all poses, instead of --splits", -1, 100000000);
    tool.parameter("method", method, "name of the predictions in tables");
    tool.parameter("batch-size", batch_size, "samples that go through the network together", 1, 4096);
    tool.parameter("device", device_name, "where the network runs", {"cpu", "cuda"});

    return tool.run(argc, argv, [&] {
        catch_interrupts();
        const Device device = parse_device(device_name);
        const Template body_template = read_template(template_path);
        const std::string template_sha256 = sha256_path(template_path);
        const NeuralModel model = NeuralModel::load(model_path, body_template, template_sha256, device);
        const BodySet bodies = read_bodies(bodies_path, body_template);
        require_input(bodies.template_sha256 == template_sha256,
                      "{}: the bodies were made with another template than {}", bodies_path, template_path);
        const PoseSet poses = read_poses(poses_path);
        const int num_bodies = static_cast<int>(bodies.bodies.size());

        require_input(splits_path.empty() != (body_idx < 0), "give either --splits or --body, not both or none");
        std::vector<SamplePair> pairs;
        std::vector<std::string> pair_splits;
        if (body_idx < 0) {
            const Splits splits = read_splits(splits_path, num_bodies, poses.size());
            pairs = splits.pairs.at(split);
            pair_splits.assign(pairs.size(), split);
        } else {
            require_input(body_idx < num_bodies, "{}: has {} bodies, --body is {}", bodies_path, num_bodies, body_idx);
            for (int i = 0; i < poses.size(); ++i) pairs.push_back({body_idx, i});
            pair_splits.assign(pairs.size(), split);
        }
        require_input(!pairs.empty(), "{}: the split {} has no pairs", splits_path, split);

        GradientWriter writer(output_path, {method, pairs, pair_splits}, body_template.num_prisms(), tool.provenance());
        const BodyPoser poser(body_template);
        std::map<int, Eigen::VectorXd> codes;
        Progress progress("predicting", pairs.size());
        for (std::size_t begin = 0; begin < pairs.size(); begin += static_cast<std::size_t>(batch_size)) {
            if (interrupt_requested()) throw Interrupted("prediction stopped; nothing was written");
            const std::size_t end = std::min(begin + static_cast<std::size_t>(batch_size), pairs.size());
            std::vector<PoseInput> inputs;
            for (std::size_t i = begin; i < end; ++i) {
                const auto [found, is_new] = codes.try_emplace(pairs[i].body_idx);
                if (is_new)
                    found->second =
                        model.input_space().encode(bodies.bodies[static_cast<std::size_t>(pairs[i].body_idx)]);
                inputs.push_back({found->second, poses.poses[static_cast<std::size_t>(pairs[i].pose_idx)]});
            }
            const RowMatrixF predictions = model.predict(inputs);
            for (std::size_t i = begin; i < end; ++i) {
                const PosedBody posed = poser.pose(bodies.bodies[pairs[i].body_idx], poses.poses[pairs[i].pose_idx]);
                writer.write(int(i), model.output_space().gradients(posed, predictions.row(i - begin).data()));
            }
            progress.advance(end - begin);
        }
        writer.commit();
        fmt::print("{}: {} samples of {} prisms\n", output_path, pairs.size(), body_template.num_prisms());
    });
}
