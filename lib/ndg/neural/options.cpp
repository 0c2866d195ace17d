// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/options.h"

#include "ndg/core/error.h"

#include <torch/cuda.h>

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

void require_range(double value, double low, double high, const char* name)
{
    require_input(std::isfinite(value) && value >= low && value <= high, "{} must lie in [{}, {}], not {}", name, low,
                  high, value);
}

}  // namespace

Device parse_device(const std::string& name)
{
    require_input(name == "cpu" || name == "cuda", "device must be cpu or cuda, not \"{}\"", name);
    if (name == "cpu") return Device::cpu;
    require_input(torch::cuda::is_available(),
                  "device cuda is not available: no CUDA device, or libtorch was built without CUDA");
    return Device::cuda;
}

void NetworkOptions::check() const
{
    require_input(widths.size() <= 16, "widths must name at most 16 hidden layers, not {}", widths.size());
    for (const int width : widths) require_range(width, 1, 1 << 20, "each entry of widths");
    const auto& names = parametrisation_names;
    require_input(std::find(names.begin(), names.end(), parametrisation) != names.end(),
                  "parametrisation must be exponential, direct, lu or qr, not \"{}\"", parametrisation);
    require_range(output_basis, 0, 1 << 16, "output_basis");
    require_input(output_basis == 0 || parametrisation == "exponential" || parametrisation == "direct",
                  "output_basis {} needs the parametrisation exponential or direct, not {}", output_basis,
                  parametrisation);
}

void TrainingOptions::check() const
{
    require_range(epochs, 1, 1e6, "epochs");
    require_range(batch_size, 1, 1e6, "batch_size");
    require_range(learning_rate, 1e-12, 10, "learning_rate");
    require_range(weight_decay, 0, 1e3, "weight_decay");
    require_input(std::find(schedule_names.begin(), schedule_names.end(), schedule) != schedule_names.end(),
                  "schedule must be constant, cosine or plateau, not \"{}\"", schedule);
    require_range(dropout, 0, 0.95, "dropout");
    require_range(input_noise, 0, 10, "input_noise");
    require_range(patience, 0, 1e6, "patience");
    require_range(checkpoint_seconds, 0, 1e9, "checkpoint_seconds");
}

}  // namespace ndg
