// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/tables.h"

#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"
#include "ndg/io/h5.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace ndg {
namespace {

using PairKey = std::pair<int, int>;

PairKey key_of(const SamplePair& pair)
{
    return {pair.body_idx, pair.pose_idx};
}

/// Sample index of each pair of a file.
std::map<PairKey, int> index_samples(const NamedDeformations& file)
{
    std::map<PairKey, int> samples;
    for (int i = 0; i < file.set.size(); ++i) {
        const SamplePair& pair = file.set.pairs[std::size_t(i)];
        const bool inserted = samples.emplace(key_of(pair), i).second;
        require_input(inserted, "{} holds body {} in pose {} twice", file.path, pair.body_idx, pair.pose_idx);
    }
    return samples;
}

/// Sample index of each wanted pair, in their order.
std::vector<int> match_samples(const NamedDeformations& file, const std::vector<SamplePair>& pairs,
                               const std::string& split, int num_volume_vertices)
{
    require_input(file.set.num_volume_vertices == num_volume_vertices, "{} has {} volume vertices, the template {}",
                  file.path, file.set.num_volume_vertices, num_volume_vertices);
    const std::map<PairKey, int> samples = index_samples(file);
    std::vector<int> matched;
    for (const SamplePair& pair : pairs) {
        const auto found = samples.find(key_of(pair));
        require_input(found != samples.end(), "{} ({}) has no sample of body {} in pose {}, which split {} asks for",
                      file.path, file.set.method, pair.body_idx, pair.pose_idx, split);
        const std::string& stored_split = file.set.pair_splits[std::size_t(found->second)];
        require_input(stored_split == split, "{} holds body {} in pose {} as a sample of split {}, not of {}",
                      file.path, pair.body_idx, pair.pose_idx, stored_split, split);
        matched.push_back(found->second);
    }
    return matched;
}

}  // namespace

ComparedPairs compared_pairs(const std::vector<SamplePair>& pairs, const std::string& split,
                             const NamedDeformations& reference)
{
    const std::map<PairKey, int> samples = index_samples(reference);
    std::set<PairKey> failures;
    for (const FailedSample& failure : reference.set.failures) failures.insert(key_of(failure.pair));
    const auto converged = reference.set.statistics.find("converged");
    ComparedPairs compared;
    for (const SamplePair& pair : pairs) {
        const auto found = samples.find(key_of(pair));
        if (found == samples.end() && failures.count(key_of(pair)) != 0) {
            ++compared.failed;
            continue;
        }
        require_input(found != samples.end(), "{} ({}) has no sample of {}, which split {} asks for", reference.path,
                      reference.set.method, describe(pair), split);
        if (converged != reference.set.statistics.end() && converged->second[found->second] == 0) {
            ++compared.unconverged;
        } else {
            compared.pairs.push_back(pair);
        }
    }
    require_input(!compared.pairs.empty(), "{}: of the {} samples of split {} {} did not converge and {} failed",
                  reference.path, pairs.size(), split, compared.unconverged, compared.failed);
    return compared;
}

std::vector<MethodMetrics> evaluate_methods(const Template& body_template, const BodySet& bodies,
                                            const std::vector<SamplePair>& pairs, const std::string& split,
                                            const NamedDeformations& reference,
                                            const std::vector<NamedDeformations>& predictions)
{
    require_input(!pairs.empty(), "Split {} has no samples to evaluate", split);
    for (const SamplePair& pair : pairs)
        require_input(pair.body_idx >= 0 && pair.body_idx < int(bodies.bodies.size()),
                      "Split {} names body {}, but there are {} bodies", split, pair.body_idx, bodies.bodies.size());

    std::vector<const NamedDeformations*> files = {&reference};
    for (const NamedDeformations& prediction : predictions) files.push_back(&prediction);
    std::set<std::string> methods;
    std::vector<std::vector<int>> matched;
    std::vector<MethodMetrics> rows;
    for (const NamedDeformations* file : files) {
        require_input(methods.insert(file->set.method).second, "{} holds method {}, which another file holds already",
                      file->path, file->set.method);
        require_input(file->set.posing.bone_wrap == reference.set.posing.bone_wrap,
                      "{}: its bodies are posed with bone-wrap {}, those of {} with {}", file->path,
                      to_name(file->set.posing.bone_wrap), reference.path, to_name(reference.set.posing.bone_wrap));
        matched.push_back(match_samples(*file, pairs, split, body_template.num_volume_vertices()));
        MethodMetrics row;
        row.method = file->set.method;
        row.pairs = pairs;
        row.samples.resize(pairs.size());
        rows.push_back(std::move(row));
    }

    // One body at a time, so that its gradient operator is built once and never two are held.
    std::map<int, std::vector<std::size_t>> samples_of_body;
    for (std::size_t i = 0; i < pairs.size(); ++i) samples_of_body[pairs[i].body_idx].push_back(i);
    for (const auto& [body_idx, sample_indices] : samples_of_body) {
        const BodyMetrics metrics(bodies.bodies[std::size_t(body_idx)].volume_vertices, body_template.prisms,
                                  body_template.num_wrap_vertices());
        parallel_for(int(sample_indices.size()), [&, &indices = sample_indices](int task) {
            const std::size_t i = indices[task];
            const Points target = reference.set.points(matched[0][i]);
            rows[0].samples[i] = metrics.evaluate(target, target);
            for (std::size_t m = 1; m < files.size(); ++m)
                rows[m].samples[i] = metrics.evaluate(target, files[m]->set.points(matched[m][i]));
        });
    }
    for (MethodMetrics& row : rows) row.mean = mean_metrics(row.samples);
    return rows;
}

TableCounts count_data(const Template& body_template, const BodySet& bodies, int num_poses,
                       const ComparedPairs& compared, const NamedDeformations& reference, const std::string& criterion)
{
    const auto converged = reference.set.statistics.find("converged");
    require_input(converged != reference.set.statistics.end() && !converged->second.empty(),
                  "{} has no statistic converged, so the share of converged samples is unknown", reference.path);
    TableCounts counts;
    counts.bodies = int(bodies.bodies.size());
    counts.poses = num_poses;
    counts.samples = reference.set.size();
    counts.prisms = body_template.num_prisms();
    counts.volume_vertices = body_template.num_volume_vertices();
    counts.free_vertices = body_template.num_volume_vertices() - body_template.num_wrap_vertices();
    for (const std::string& split : split_names)
        counts.split_samples.emplace_back(
            split, int(std::count(reference.set.pair_splits.begin(), reference.set.pair_splits.end(), split)));
    std::set<int> evaluated_bodies, evaluated_poses;
    for (const SamplePair& pair : compared.pairs) {
        evaluated_bodies.insert(pair.body_idx);
        evaluated_poses.insert(pair.pose_idx);
    }
    counts.evaluated_samples = int(compared.pairs.size());
    counts.unconverged_samples = compared.unconverged;
    counts.failed_samples = compared.failed;
    counts.evaluated_bodies = int(evaluated_bodies.size());
    counts.evaluated_poses = int(evaluated_poses.size());
    const auto num_converged =
        std::count_if(converged->second.begin(), converged->second.end(), [](double value) { return value != 0; });
    counts.fem_converged_share = double(num_converged) / double(converged->second.size());
    counts.fem_convergence_criterion = criterion;
    for (const Body& body : bodies.bodies)
        counts.invalid_rest_prisms += check_prisms(body.volume_vertices, body_template.prisms).num_invalid;
    return counts;
}

std::string convergence_criterion(const std::string& deformation_path)
{
    std::string config;
    for (const auto& [name, value] : list_h5(deformation_path).attributes) {
        if (name == "/convergence_criterion" || name == "convergence_criterion") return value;
        if (name == "/config" || name == "config") config = value;
    }
    if (config.empty()) return "not stated in the reference file";
    const nlohmann::json json = nlohmann::json::parse(config, nullptr, false);
    if (json.is_object() && json.contains("simulate-fem")) {
        const nlohmann::json& fem = json["simulate-fem"];
        if (fem.is_object() && fem.contains("relative_tolerance") && fem.contains("absolute_tolerance"))
            return fmt::format(
                "norm of the out-of-balance forces on the free vertices at most {} of the summed absolute element "
                "forces, or at most {} N",
                fem["relative_tolerance"].dump(), fem["absolute_tolerance"].dump());
    }
    return "as configured: " + config;
}

}  // namespace ndg
