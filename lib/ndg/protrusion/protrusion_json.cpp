// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/protrusion_json.h"

#include <nlohmann/json.hpp>

namespace ndg {

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
                                      {"deepest", row.deepest}};
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
