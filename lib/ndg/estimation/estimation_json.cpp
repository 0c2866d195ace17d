// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/json_file.h"
#include "ndg/estimation/estimation_checkpoint.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>

namespace ndg {

namespace {

using nlohmann::json;

json iteration_json(const EstimationIteration& i)
{
    return {{"stage", i.stage},
            {"iteration", i.iteration},
            {"cost", i.cost},
            {"error", i.error},
            {"radius", i.radius},
            {"simulations", i.simulations},
            {"seconds", i.seconds},
            {"parameters", std::vector<double>(i.parameters.data(), i.parameters.data() + i.parameters.size())}};
}

json errors_json(const std::vector<std::string>& names, const std::vector<double>& errors)
{
    json rows = json::array();
    for (std::size_t s = 0; s < names.size(); ++s) {
        rows.push_back({{"sequence", names[s]}, {"error", errors[s]}, {"variance_reduction", 1 - errors[s]}});
    }
    return rows;
}

std::vector<EstimationIteration> parse_checkpoint(const std::string& path, const std::string& key)
{
    const JsonValue file(path);
    file.check_keys({"key", "iterations"});
    require_input(file.at("key").text() == key,
                  "{}: was left by an estimation of other inputs or options; --force discards it", path);
    std::vector<EstimationIteration> iterations;
    for (const JsonValue& row : file.at("iterations").elements()) {
        EstimationIteration i;
        i.stage = row.at("stage").integer(0, 1);
        i.iteration = row.at("iteration").integer(0);
        i.cost = row.at("cost").number(0);
        i.error = row.at("error").number(0);
        i.radius = row.at("radius").number(0);
        i.simulations = row.at("simulations").integer(0);
        i.seconds = row.at("seconds").number(0);
        const std::vector<double> parameters = row.at("parameters").numbers();
        i.parameters =
            Eigen::Map<const Eigen::VectorXd>(parameters.data(), static_cast<Eigen::Index>(parameters.size()));
        iterations.push_back(std::move(i));
    }
    return iterations;
}

}  // namespace

void write_checkpoint(const std::string& path, const std::string& key,
                      const std::vector<EstimationIteration>& iterations)
{
    json rows = json::array();
    for (const EstimationIteration& iteration : iterations) rows.push_back(iteration_json(iteration));
    write_file(path, json{{"key", key}, {"iterations", rows}}.dump(1) + "\n");
}

std::vector<EstimationIteration> read_checkpoint(const std::string& path, const std::string& key, bool force)
{
    if (!std::filesystem::exists(path)) return {};
    try {
        return parse_checkpoint(path, key);
    } catch (const InputError&) {
        if (!force) throw;
        return {};
    }
}

std::string estimate_json(const TissueEstimate& estimate, const EstimationOptions& options,
                          const std::vector<std::string>& test_names, const std::vector<double>& test_errors)
{
    json curve = json::array();
    for (const EstimationIteration& iteration : estimate.iterations) curve.push_back(iteration_json(iteration));
    json result = {{"configuration", to_name(options.configuration)},
                   {"young_normal_pascal", estimate.young_normal_pascal},
                   {"young_tangent_pascal", estimate.young_tangent_pascal},
                   {"uniform_young_normal_pascal", estimate.uniform_normal_pascal},
                   {"uniform_young_tangent_pascal", estimate.uniform_tangent_pascal},
                   {"skinned_error", 1.0},
                   {"uniform_error", estimate.uniform_error},
                   {"error", estimate.error},
                   {"variance_reduction_training", 1 - estimate.error},
                   {"training", errors_json(estimate.sequence_names, estimate.sequence_errors)},
                   {"convergence", curve}};
    if (!test_names.empty()) result["test"] = errors_json(test_names, test_errors);
    return result.dump(1) + "\n";
}

std::string stiffness_field_json(const TissueEstimate& estimate)
{
    return json{{"young_normal_pascal", estimate.young_normal_pascal},
                {"young_tangent_pascal", estimate.young_tangent_pascal}}
               .dump(1) +
           "\n";
}

}  // namespace ndg
