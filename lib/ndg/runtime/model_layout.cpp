// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/model_layout.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

namespace ndg {
namespace {

std::vector<std::size_t> matrix_shape(const H5Reader& file, const std::string& name)
{
    const std::vector<std::size_t> shape = file.shape(name);
    require_input(shape.size() == 2, "{}: {} is no matrix", file.path(), name);
    return shape;
}

/// `region`: its number, or -1 where there is one network.
PartLayout read_part(const H5Reader& file, int region)
{
    PartLayout part;
    const std::string prefix = region < 0 ? "" : std::to_string(region) + "_";
    if (region >= 0) part.region = fmt::format("/network/region_{}", region);
    for (int i = 0; file.has(fmt::format("/network/layer_{}{}/weight", prefix, i)); ++i) {
        LayerLayout layer;
        layer.group = fmt::format("/network/layer_{}{}", prefix, i);
        const std::vector<std::size_t> shape = matrix_shape(file, layer.group + "/weight");
        layer.num_rows = static_cast<int>(shape[0]);
        layer.num_columns = static_cast<int>(shape[1]);
        layer.has_norm = file.has(layer.group + "/norm_weight");
        require_input(part.layers.empty() || layer.num_columns == part.num_outputs,
                      "{}: {}/weight has {} columns, not {}", file.path(), layer.group, layer.num_columns,
                      part.num_outputs);
        part.num_outputs = layer.num_rows;
        part.layers.push_back(layer);
    }
    require_input(!part.layers.empty(), "{}: has no /network/layer_{}0/weight", file.path(), prefix);
    const std::string basis = (region < 0 ? "/network" : part.region) + "/output_basis";
    if (!file.has(basis)) return part;
    const std::vector<std::size_t> shape = matrix_shape(file, basis);
    require_input(static_cast<int>(shape[0]) == part.num_outputs, "{}: {} has {} rows, not {}", file.path(), basis,
                  shape[0], part.num_outputs);
    part.basis = basis;
    part.num_outputs = static_cast<int>(shape[1]);
    return part;
}

}  // namespace

std::vector<PartLayout> read_model_layout(const H5Reader& file)
{
    std::vector<PartLayout> parts;
    const bool regional = file.has("/network/layer_0_0/weight");
    for (int region = 0; region == 0 || (regional && file.has(fmt::format("/network/layer_{}_0/weight", region)));
         ++region)
        parts.push_back(read_part(file, regional ? region : -1));
    return parts;
}

}  // namespace ndg
