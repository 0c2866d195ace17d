// SPDX-License-Identifier: Apache-2.0
// Deformed anatomy on disk: format "ndg-anatomy", version 1 (docs/formats.md).
#pragma once

#include "ndg/dataset/sample_file.h"

namespace ndg {

/// N_a x 3 a sample.
class AnatomyWriter : public SampleWriter {
public:
    /// `triangles`: the same for all samples.
    AnatomyWriter(const std::string& path, const SampleIndex& index, const Triangles& triangles, int num_vertices,
                  const Provenance& provenance);
};

class AnatomyReader : public SampleReader {
public:
    /// `num_vertices` -1: unchecked.
    explicit AnatomyReader(const std::string& path, int num_vertices = -1);
    Triangles triangles() const;
};

}  // namespace ndg
