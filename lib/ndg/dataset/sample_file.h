// SPDX-License-Identifier: Apache-2.0
// Files of samples: an index and a payload, a matrix of float32 for each frame of each sample. Both ways sample after
// sample, so that a result of any size passes through little memory.
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/core/types.h"
#include "ndg/dataset/sample_index.h"
#include "ndg/io/h5.h"

#include <string>
#include <vector>

namespace ndg {

/// Format of a file of samples.
struct SamplePayload {
    std::string format;
    int version = 1;
    std::string group;        ///< of the index, e.g. "/deformations"
    std::string dataset;      ///< e.g. "/deformations/vertices": slices x rows x columns
    std::string rows;         ///< what a row stands for, e.g. "vertices"
    int columns = 3;          ///< of a row
    std::string description;  ///< of the dataset
};

/// Without commit() nothing is left behind.
class SampleWriter {
public:
    /// Throws Error where there is not one split a pair, InputError where it is not the name of one.
    SampleWriter(const std::string& path, const SamplePayload& payload, const SampleIndex& index, int num_rows,
                 const Provenance& provenance);

    /// In any order. `values`: frames x rows x columns, row-major; finite (Error otherwise).
    void write(int sample_idx, const std::vector<float>& values);
    /// Of a sample of one frame: rows x columns; double is rounded.
    void write(int sample_idx, const Eigen::Ref<const RowMatrixF>& values);
    void write(int sample_idx, const Eigen::Ref<const RowMatrix>& values);
    /// Throws Error when a sample was not written.
    void commit() { file_.commit(); }

protected:
    H5Writer file_;

private:
    void write_frames(int sample_idx, const float* values, std::size_t count);

    std::string path_;
    SamplePayload payload_;
    SampleIndex index_;
    std::size_t num_rows_;
};

/// Throws InputError naming file, dataset and value for anything inconsistent.
class SampleReader {
public:
    /// `num_rows` -1: unchecked.
    SampleReader(const std::string& path, const SamplePayload& payload, int num_rows = -1);

    const SampleIndex& index() const { return index_; }
    int size() const { return index_.size(); }
    int num_rows() const { return num_rows_; }
    /// frames x rows x columns, row-major. May be called by any thread.
    std::vector<float> read(int sample_idx) const;
    const H5Reader& file() const { return file_; }

private:
    H5Reader file_;
    SamplePayload payload_;
    SampleIndex index_;
    int num_rows_ = 0;
};

}  // namespace ndg
