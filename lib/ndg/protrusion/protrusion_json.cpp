// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/protrusion_json.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {

std::vector<std::string> most_frequent(const std::map<std::string, int>& parts, std::size_t count)
{
    std::vector<std::pair<int, std::string>> sorted;
    for (const auto& [part, frames] : parts) sorted.emplace_back(-frames, part);
    std::sort(sorted.begin(), sorted.end());
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < std::min(count, sorted.size()); ++i)
        texts.push_back(fmt::format("{} ({})", sorted[i].second, -sorted[i].first));
    return texts;
}

std::string protrusion_json(const ProtrusionTable& table, const std::vector<ProtrusionRow>& external)
{
    nlohmann::ordered_json json;
    json["table3"] = nlohmann::ordered_json::object();
    const auto add = [&](const ProtrusionRow& row) {
        json["table3"][row.method] = {{"intersecting_frames", row.intersecting_frames},
                                      {"protruding_frames", row.protruding_frames},
                                      {"protrusion_mm", row.protrusion_mm},
                                      {"max_protrusion_mm", row.max_protrusion_mm},
                                      {"frames", row.frames},
                                      {"deepest", row.deepest},
                                      {"intersecting_parts", most_frequent(row.intersecting_parts)},
                                      {"protruding_parts", most_frequent(row.protruding_parts)}};
    };
    for (const ProtrusionRow& row : table.rows) add(row);
    for (const ProtrusionRow& row : external) add(row);
    json["counts"] = {{"table3_pairs", table.pairs},
                      {"table3_colliding_pairs", table.colliding_pairs},
                      {"table3_bodies", table.bodies},
                      {"table3_bodies_intersecting_at_rest", table.bodies_intersecting_at_rest},
                      {"table3_bodies_protruding_at_rest", table.bodies_protruding_at_rest}};
    return json.dump(2) + "\n";
}

}  // namespace ndg
