// SPDX-License-Identifier: Apache-2.0
// Finished samples beside the output, one file each, so that a run killed at any moment loses only what it was at.
// Format "ndg-fem-part", version 1: /sample/vertices (N_v x 3 float32), /sample/pair (body, pose), attributes key and
// the sample's statistics.
#pragma once

#include "ndg/body/sample_set.h"
#include "ndg/core/provenance.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ndg {

struct SamplePart {
    SamplePair pair;
    std::vector<float> vertices;               ///< N_v * 3, row-major
    std::map<std::string, double> statistics;  ///< the names of simulation_statistics
};

/// Names of a sample's figures: energy_joule, residual_newton, residual_relative, iterations, converged, load_steps,
/// inverted_prisms, seconds.
const std::vector<std::string>& simulation_statistics();

class PartFolder {
public:
    /// `key` identifies configuration and inputs: parts of another key are not reused. Makes <output>.parts.
    PartFolder(const std::string& output, std::string key, int num_volume_vertices);

    /// Written under a temporary name and renamed.
    void write(int sample_idx, const SamplePart& part, const Provenance& provenance) const;
    /// Nothing where there is no part, or it is truncated, of another key or of another pair.
    std::optional<SamplePart> read(int sample_idx, const SamplePair& pair) const;
    /// Removes the folder and all parts.
    void remove() const;

    const std::string& path() const { return path_; }

private:
    std::string part_path(int sample_idx) const;

    std::string path_, key_;
    int num_volume_vertices_;
};

}  // namespace ndg
