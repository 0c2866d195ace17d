// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/model_traits.h"

#include "ndg/core/error.h"

#include <algorithm>

namespace ndg {
namespace {

bool read_flag(const H5Reader& file, const std::string& name)
{
    const std::string text = file.attribute(name);
    require_input(text == "true" || text == "false", "{}: attribute {} is \"{}\", not true or false", file.path(), name,
                  text);
    return text == "true";
}

}  // namespace

ModelTraits read_model_traits(const H5Reader& file)
{
    ModelTraits traits;
    // Files from before there was a choice do not say it: they predict residuals.
    if (file.has_attribute("output_space")) traits.output_space = file.attribute("output_space");
    traits.parametrisation =
        parse_name<ParametrisationKind>(file.attribute("parametrisation"), file.path() + ": parametrisation");
    traits.rotation = read_flag(file, "rotation");
    traits.shape = read_flag(file, "shape");
    traits.posing = read_posing(file);
    return traits;
}

ShapeSpace read_model_shape_space(const H5Reader& file, Eigen::Index num_coordinates)
{
    ShapeSpace space;
    space.components = file.read_matrix("/shape_space/components", num_coordinates);
    const std::vector<double> mean = file.read_doubles("/shape_space/mean", space.components.rows());
    const std::vector<double> deviations =
        file.read_doubles("/shape_space/standard_deviations", space.components.cols());
    space.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), space.components.rows());
    space.standard_deviations = Eigen::Map<const Eigen::VectorXd>(deviations.data(), space.components.cols());
    space.explained_variance = file.attribute_double("explained_variance");
    return space;
}

double shape_code_scale(const ShapeSpace& space)
{
    return space.dimension() > 0 ? std::max(space.standard_deviations.maxCoeff(), 1e-12) : 1.0;
}

}  // namespace ndg
