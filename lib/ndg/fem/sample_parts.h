// SPDX-License-Identifier: Apache-2.0
// Finished samples beside the output, one file each, so that a run killed at any moment loses only what it was at.
// Format "ndg-fem-part", version 2: attributes key, stop_reason, failure (empty: none) and the sample's statistics;
// /sample/pair (body, pose); /sample/vertices (1 x N_v x 3 float32) unless the sample failed.
#pragma once

#include "ndg/dataset/splits.h"
#include "ndg/core/provenance.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ndg {

struct SamplePart {
    SamplePair pair;
    std::vector<float> vertices;               ///< N_v * 3, row-major; none where the sample failed
    std::map<std::string, double> statistics;  ///< the names of simulation_statistics; none where the sample failed
    std::string stop_reason;                   ///< describe(NewtonStop)
    std::string failure;                       ///< why there is no deformation; empty: there is one
};

/// Names of a sample's figures: energy_joule, residual_newton, residual_relative, iterations, converged, load_steps,
/// inverted_prisms, seconds.
const std::vector<std::string>& simulation_statistics();

/// What the names of the files in a folder of parts tell, without opening any.
struct PartsStatus {
    int done = 0, failed = 0;  ///< samples with a deformation; without one
    bool running = false;      ///< a process is at it now
    std::string process;       ///< "process 123 on host", of the last run
    double rate_hertz = 0;     ///< samples a second since that run's start; 0: none yet
};
/// Of <output>.parts; nothing where there is no such folder.
std::optional<PartsStatus> parts_status(const std::string& output);

/// The folder of one process: locked as long as the object lives, so that two do not do the same work.
class PartFolder {
public:
    /// `key` identifies configuration and inputs. Makes <output>.parts, and removes what a killed run left
    /// half-written. Throws InputError when the folder cannot be made or written, another process is at it, or it holds
    /// parts of another key, unless `discard` removes them.
    PartFolder(const std::string& output, std::string key, int num_volume_vertices, bool discard);
    ~PartFolder();
    PartFolder(const PartFolder&) = delete;
    PartFolder& operator=(const PartFolder&) = delete;

    /// Written under a temporary name and renamed. Throws Error (disk full, say).
    void write(int sample_idx, const SamplePart& part, const Provenance& provenance) const;
    /// Nothing where there is no part, or it is truncated, of another key or of another pair.
    std::optional<SamplePart> read(int sample_idx, const SamplePair& pair) const;
    /// Removes the folder and all parts.
    void remove() const;

    const std::string& path() const { return path_; }

private:
    std::optional<SamplePart> read_file(const std::string& path, const SamplePair& pair) const;

    std::string path_, key_;
    int num_volume_vertices_;
    int lock_ = -1;
};

}  // namespace ndg
