// SPDX-License-Identifier: Apache-2.0
// Deformed anatomy on disk: format "ndg-anatomy", version 1 (docs/formats.md).
//   /anatomy/vertices   n x N_a x 3 float32
//   /anatomy/triangles  T x 3 int32, the same for all samples
//   /anatomy/pairs      n x 2 int32, body index and pose index
//   /anatomy/splits     n strings
//   attribute method
#pragma once

#include "ndg/dataset/splits.h"
#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// Writes sample by sample; without commit() nothing is left behind.
class AnatomyWriter {
public:
    /// Throws Error when there are no samples or vertices or not one split name a pair.
    AnatomyWriter(const std::string& path, const std::string& method, const std::vector<SamplePair>& pairs,
                  const std::vector<std::string>& pair_splits, const Triangles& triangles, int num_vertices,
                  const Provenance& provenance);
    ~AnatomyWriter();
    AnatomyWriter(const AnatomyWriter&) = delete;
    AnatomyWriter& operator=(const AnatomyWriter&) = delete;

    /// N_a x 3.
    void write(int sample_idx, const Eigen::Ref<const Points>& vertices);
    void commit();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Everything of such a file. Throws InputError naming file, dataset and value.
struct AnatomySet {
    std::string method;
    Triangles triangles;
    std::vector<SamplePair> pairs;
    std::vector<std::string> pair_splits;
    std::vector<std::vector<float>> vertices;  ///< per sample N_a * 3, row-major
};
/// `num_vertices` -1: unchecked.
AnatomySet read_anatomy(const std::string& path, int num_vertices = -1);

}  // namespace ndg
