// SPDX-License-Identifier: Apache-2.0
#include "ndg/simulation/sample_part.h"

#include "ndg/body/joint_flesh.h"
#include "ndg/core/error.h"

namespace ndg {

namespace {

const std::string vertices_name = "/sample/vertices";

}  // namespace

const std::vector<std::string>& simulation_statistics()
{
    static const std::vector<std::string> names = [] {
        std::vector<std::string> result = {
            "energy_joule", "residual_newton", "residual_relative",      "iterations", "converged",
            "load_steps",   "inverted_prisms", "corner_inverted_prisms", "seconds",    intersecting_triangles_name};
        for (const std::string& joint : flesh_joint_names()) result.push_back(volume_change_name(joint));
        return result;
    }();
    return names;
}

std::string volume_change_name(const std::string& joint)
{
    return joint + "_volume_change";
}

void write_sample(H5Writer& file, const SamplePart& part)
{
    file.attribute("stop_reason", part.stop_reason);
    for (const auto& [name, value] : part.statistics) file.attribute(name, value);
    file.write(vertices_name, {1, part.vertices.size() / 3, 3}, part.vertices.data(), "deformed volume vertices");
}

SamplePart read_sample(const H5Reader& file, int num_volume_vertices)
{
    const std::vector<std::size_t> expected = {1, static_cast<std::size_t>(num_volume_vertices), 3};
    require_input(file.shape(vertices_name) == expected, "{}: {} has not {} vertices", file.path(), vertices_name,
                  num_volume_vertices);
    SamplePart part;
    part.vertices = file.read_slice(vertices_name, 0);
    part.stop_reason = file.attribute("stop_reason");
    for (const std::string& name : simulation_statistics()) part.statistics[name] = file.attribute_double(name);
    return part;
}

}  // namespace ndg
