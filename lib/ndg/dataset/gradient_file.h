// SPDX-License-Identifier: Apache-2.0
// Deformation gradients on disk: format "ndg-gradients", version 1 (docs/formats.md).
//   /gradients/F       n x N_p x 9 float32, F_p row-major (F00, F01, F02, F10, ..., F22)
//   /gradients/pairs   n x 2 int32, body index and pose index
//   /gradients/splits  n strings, the split of each sample
//   attribute method   e.g. "NDG"
#pragma once

#include "ndg/dataset/splits.h"
#include "ndg/core/provenance.h"

#include <memory>
#include <string>
#include <vector>

namespace ndg {

constexpr int gradient_file_version = 1;

/// Writes sample by sample; without commit() nothing is left behind.
class GradientWriter {
public:
    /// `pair_splits`: one name a pair. Throws Error when the counts differ or are zero.
    GradientWriter(const std::string& path, const std::string& method, const std::vector<SamplePair>& pairs,
                   const std::vector<std::string>& pair_splits, int num_prisms, const Provenance& provenance);
    ~GradientWriter();
    GradientWriter(const GradientWriter&) = delete;
    GradientWriter& operator=(const GradientWriter&) = delete;

    /// `gradients`: N_p x 9 float32, row-major; finite (Error otherwise).
    void write(int sample_idx, const float* gradients);
    /// Throws Error when a sample was not written.
    void commit();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Reads sample by sample. Throws InputError naming file, dataset and value for anything inconsistent.
class GradientReader {
public:
    /// `num_prisms` -1: unchecked.
    explicit GradientReader(const std::string& path, int num_prisms = -1);
    ~GradientReader();
    GradientReader(GradientReader&&) noexcept;

    int size() const;
    int num_prisms() const;
    const std::string& method() const;
    const std::vector<SamplePair>& pairs() const;
    const std::vector<std::string>& pair_splits() const;
    /// N_p * 9 float32, row-major.
    std::vector<float> read(int sample_idx) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
