// SPDX-License-Identifier: Apache-2.0
// A simulated sample, and its payload in a part: attributes stop_reason and the sample's statistics; /sample/vertices
// (1 x N_v x 3 float32).
#pragma once

#include "ndg/dataset/part_store.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

inline const PartKind sample_parts = {"ndg-fem-part", 3, "samples"};

struct SamplePart {
    std::vector<float> vertices;               ///< N_v * 3, row-major
    std::map<std::string, double> statistics;  ///< the names of simulation_statistics
    std::string stop_reason;                   ///< describe(NewtonStop)
};

inline const std::string intersecting_triangles_name = "intersecting_skin_triangles";
/// `joint`: one of flesh_joint_names().
std::string volume_change_name(const std::string& joint);
/// Names of a sample's figures: energy_joule, residual_newton, residual_relative, iterations, converged, load_steps,
/// inverted_prisms, corner_inverted_prisms, seconds, those above.
const std::vector<std::string>& simulation_statistics();

void write_sample(H5Writer& file, const SamplePart& part);
/// Throws InputError for anything but a whole sample of so many vertices.
SamplePart read_sample(const H5Reader& file, int num_volume_vertices);

}  // namespace ndg
