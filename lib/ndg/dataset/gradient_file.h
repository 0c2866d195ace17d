// SPDX-License-Identifier: Apache-2.0
// Deformation gradients on disk: format "ndg-gradients", version 1 (docs/formats.md); of each prism F_p row-major (F00,
// F01, F02, F10, ..., F22).
#pragma once

#include "ndg/dataset/sample_file.h"

namespace ndg {

/// N_p x 9 a sample.
class GradientWriter : public SampleWriter {
public:
    GradientWriter(const std::string& path, const SampleIndex& index, int num_prisms, const Provenance& provenance);
};

class GradientReader : public SampleReader {
public:
    /// `num_prisms` -1: unchecked.
    explicit GradientReader(const std::string& path, int num_prisms = -1);
    int num_prisms() const { return num_rows(); }
};

}  // namespace ndg
