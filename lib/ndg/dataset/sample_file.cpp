// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/sample_file.h"

#include "ndg/core/error.h"

#include <mutex>

namespace ndg {

SampleWriter::SampleWriter(const std::string& path, const SamplePayload& payload, const SampleIndex& index,
                           int num_rows, const Provenance& provenance)
    : file_(path, payload.format, payload.version, provenance),
      path_(path),
      payload_(payload),
      index_(index),
      num_rows_(static_cast<std::size_t>(num_rows))
{
    write_sample_index(file_, path, payload.group, index);
    file_.create(payload.dataset, {index.num_slices(), num_rows_, static_cast<std::size_t>(payload.columns)},
                 payload.description);
}

void SampleWriter::write_frames(int sample_idx, const float* values, std::size_t count)
{
    const std::size_t first = index_.first_slice(sample_idx), frames = index_.pairs[sample_idx].num_frames;
    const std::size_t length = num_rows_ * payload_.columns;
    require(count == frames * length, "{}: sample {} has {} values, expected {} x {} {} x {}", path_, sample_idx, count,
            frames, num_rows_, payload_.rows, payload_.columns);
    for (std::size_t f = 0; f < frames; ++f) file_.write_slice(payload_.dataset, first + f, values + f * length);
}

void SampleWriter::write(int sample_idx, const std::vector<float>& values)
{
    write_frames(sample_idx, values.data(), values.size());
}

void SampleWriter::write(int sample_idx, const Eigen::Ref<const RowMatrixF>& values)
{
    write_frames(sample_idx, values.data(), static_cast<std::size_t>(values.size()));
}

void SampleWriter::write(int sample_idx, const Eigen::Ref<const RowMatrix>& values)
{
    write(sample_idx, RowMatrixF(values.cast<float>()));
}

SampleReader::SampleReader(const std::string& path, const SamplePayload& payload, int num_rows)
    : file_(path, payload.format, payload.version), payload_(payload), index_(read_sample_index(file_, payload.group))
{
    const std::vector<std::size_t> shape = file_.shape(payload.dataset);
    require_input(
        shape.size() == 3 && shape[0] == index_.num_slices() && shape[2] == static_cast<std::size_t>(payload.columns),
        "{}: {} has shape {} instead of {} samples x {} x {}", path, payload.dataset, fmt::join(shape, " x "),
        index_.num_slices(), payload.rows, payload.columns);
    num_rows_ = static_cast<int>(shape[1]);
    require_input(num_rows < 0 || num_rows_ == num_rows, "{}: {} has {} {} a sample, but the template has {}", path,
                  payload.dataset, num_rows_, payload.rows, num_rows);
}

std::vector<float> SampleReader::read(int sample_idx) const
{
    static std::mutex mutex;  // of all files: HDF5 is not thread-safe
    const std::lock_guard<std::mutex> lock(mutex);
    const std::size_t first = index_.first_slice(sample_idx), frames = index_.pairs[sample_idx].num_frames;
    std::vector<float> values = file_.read_slice(payload_.dataset, first);
    for (std::size_t f = 1; f < frames; ++f) {
        const std::vector<float> frame = file_.read_slice(payload_.dataset, first + f);
        values.insert(values.end(), frame.begin(), frame.end());
    }
    return values;
}

}  // namespace ndg
