// SPDX-License-Identifier: Apache-2.0
// Bodies through time on disk: format "ndg-dynamics", version 2 (docs/formats.md).
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/provenance.h"
#include "ndg/dynamics/driven_body.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// What stands in such a file but the vertices. Frames of all sequences, one sequence after the other.
struct DynamicsSet {
    std::string model;  ///< "soft-tissue", "layered"
    std::string key;    ///< what frames depend on beside their sequence; of shards alike
    std::string convergence_criterion;
    double time_step_seconds = 0, frame_rate_hertz = 0;
    int num_held = 0;
    Points rest;               ///< N x 3, m
    Triangles skin_triangles;  ///< among the N vertices
    std::vector<DynamicSurface> others;
    std::vector<std::string> sequence_names;
    std::vector<int> frame_begin;                           ///< first frame of every sequence
    std::vector<double> times;                              ///< s, one a frame, from the start of its sequence
    std::vector<Pose> poses;                                ///< one a frame
    std::map<std::string, std::vector<double>> statistics;  ///< name -> one value a frame
    std::vector<std::string> failed_sequences, failure_reasons;

    int num_frames() const { return static_cast<int>(times.size()); }
    int num_vertices() const { return static_cast<int>(rest.rows()); }
    /// Frames of a sequence: the first, and the one after the last.
    std::pair<int, int> frames_of(int sequence) const;
};

/// Writes the lists at once and the vertices frame after frame; without commit() nothing is left behind.
class DynamicsWriter {
public:
    DynamicsWriter(const std::string& path, const DynamicsSet& set, const Provenance& provenance);
    ~DynamicsWriter();
    /// N * 3, row-major; every frame once.
    void write(int frame, const std::vector<float>& vertices);
    void commit();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes `path` over the `count` shards of a run (shard_path in dataset/shards.h), the motions shard after shard; no
/// vertices are copied, so that the two are moved together. Throws InputError where a shard is missing, or is of other
/// inputs, options or bodies than the first.
DynamicsSet join_dynamics(const std::string& path, int count, const Provenance& provenance);

/// A file whose frames are read when asked for.
class DynamicsReader {
public:
    /// Throws InputError naming file, dataset and value for what does not fit together.
    explicit DynamicsReader(const std::string& path);
    ~DynamicsReader();
    DynamicsReader(DynamicsReader&&) noexcept;

    const DynamicsSet& set() const;
    /// N x 3. Throws InputError for a frame that is not there or damaged.
    Points frame(int frame) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
