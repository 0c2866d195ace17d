// SPDX-License-Identifier: Apache-2.0
// What people should know who take a network: cards of the model and of the data it was trained on, in Markdown, and
// how its parts fit together, in JSON.
#pragma once

#include <string>
#include <vector>

namespace ndg {

struct ReleaseInputs {
    std::string name;                     ///< of the release
    std::string model_path;               ///< format "ndg-model"
    std::string tables_path;              ///< of evaluate-metrics; empty: not evaluated
    std::vector<std::string> data_paths;  ///< files of the data set, in the order of their making
};

/// What is needed to compute the network of its tensors (safetensors.h): options, joints, names of the tensors part by
/// part, what the template is recognised by, origin and licences.
std::string network_config(const std::string& model_path);
/// Inputs and outputs, figures, training data and licences, limits, and what ndg-info says of the model.
std::string model_card(const ReleaseInputs& inputs);
/// What ndg-info says of each file, licences, how the samples were made, limits.
std::string dataset_card(const ReleaseInputs& inputs);

}  // namespace ndg
