// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/output_space.h"

#include "ndg/core/error.h"
#include "ndg/neural/prism_residuals.h"
#include "ndg/neural/vertex_offsets.h"

#include <fmt/ranges.h>
#include <torch/types.h>

#include <algorithm>

namespace ndg {
namespace {

struct Entry {
    const char* name;
    std::unique_ptr<OutputSpace> (*make)(const Template& body_template, const NetworkOptions& options);
};

const Entry table[] = {
    {"residuals", make_prism_residuals},
    {"vertex-offsets", make_vertex_offsets},
};

}  // namespace

at::Tensor OutputSpace::activate(const at::Tensor& outputs) const
{
    return outputs;
}

std::string OutputSpace::script() const
{
    return "    return y\n";
}

GradientsF OutputSpace::gradients(const PosedBody&, const float*) const
{
    throw InputError("the model predicts no deformation gradients but vertices: animate poses bodies with it");
}

void OutputSpace::approximate_inverse(const float* prediction, float* outputs) const
{
    std::copy_n(prediction, width(), outputs);
}

std::vector<float> neutral_prediction(const OutputSpace& space)
{
    const torch::NoGradGuard no_grad;
    const torch::Tensor neutral = space.activate(torch::zeros({1, space.width()})).contiguous();
    return {neutral.data_ptr<float>(), neutral.data_ptr<float>() + neutral.numel()};
}

std::unique_ptr<OutputSpace> make_output_space(const Template& body_template, const NetworkOptions& options)
{
    for (const Entry& entry : table)
        if (options.output_space == entry.name) return entry.make(body_template, options);
    throw InputError(fmt::format("there is no output space \"{}\", only {}", options.output_space,
                                 fmt::join(output_space_names(), ", ")));
}

std::vector<std::string> output_space_names()
{
    std::vector<std::string> names;
    for (const Entry& entry : table) names.emplace_back(entry.name);
    return names;
}

}  // namespace ndg
