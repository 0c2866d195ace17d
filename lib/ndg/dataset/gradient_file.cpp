// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/gradient_file.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace ndg {

namespace {

const std::string gradient_format = "ndg-gradients";

}  // namespace

struct GradientWriter::State {
    H5Writer file;
    std::string path;
    std::vector<char> written;

    State(const std::string& path_in, const Provenance& provenance)
        : file(path_in, gradient_format, gradient_file_version, provenance), path(path_in)
    {
    }
};

GradientWriter::GradientWriter(const std::string& path, const std::string& method, const std::vector<SamplePair>& pairs,
                               const std::vector<std::string>& pair_splits, int num_prisms,
                               const Provenance& provenance)
{
    require(!pairs.empty() && num_prisms > 0, "{}: there are no gradients to write ({} samples of {} prisms)", path,
            pairs.size(), num_prisms);
    require(pairs.size() == pair_splits.size(), "{}: {} pairs but {} split names", path, pairs.size(),
            pair_splits.size());
    state_ = std::make_unique<State>(path, provenance);
    state_->written.assign(pairs.size(), 0);

    RowMatrixI indices(static_cast<Eigen::Index>(pairs.size()), 2);
    for (Eigen::Index i = 0; i < indices.rows(); ++i) {
        const SamplePair& pair = pairs[static_cast<std::size_t>(i)];
        indices.row(i) << pair.body_idx, pair.pose_idx;
    }
    state_->file.attribute("method", method);
    state_->file.write("/gradients/pairs", indices, "body index and pose index of each sample");
    state_->file.write("/gradients/splits", pair_splits, "split of each sample");
    state_->file.create("/gradients/F", {pairs.size(), static_cast<std::size_t>(num_prisms), 9},
                        "deformation gradient of each prism, row-major");
}

GradientWriter::~GradientWriter() = default;

void GradientWriter::write(int sample_idx, const float* gradients)
{
    require(sample_idx >= 0 && sample_idx < static_cast<int>(state_->written.size()),
            "{}: sample {} is not among the {} announced", state_->path, sample_idx, state_->written.size());
    state_->file.write_slice("/gradients/F", static_cast<std::size_t>(sample_idx), gradients);
    state_->written[static_cast<std::size_t>(sample_idx)] = 1;
}

void GradientWriter::commit()
{
    const auto missing = std::find(state_->written.begin(), state_->written.end(), 0);
    require(missing == state_->written.end(), "{}: the gradients of sample {} were not written", state_->path,
            missing - state_->written.begin());
    state_->file.commit();
}

struct GradientReader::State {
    H5Reader file;
    std::string method;
    std::vector<SamplePair> pairs;
    std::vector<std::string> pair_splits;
    int num_prisms = 0;

    explicit State(const std::string& path) : file(path, gradient_format, gradient_file_version) {}
};

GradientReader::GradientReader(const std::string& path, int num_prisms) : state_(std::make_unique<State>(path))
{
    State& state = *state_;
    state.method = state.file.attribute("method");
    const std::vector<std::size_t> shape = state.file.shape("/gradients/F");
    require_input(shape.size() == 3 && shape[0] > 0 && shape[1] > 0 && shape[2] == 9,
                  "{}: /gradients/F has shape ({}), expected samples x prisms x 9", path, fmt::join(shape, " x "));
    require_input(num_prisms < 0 || shape[1] == static_cast<std::size_t>(num_prisms),
                  "{}: /gradients/F holds {} prisms, the template has {}", path, shape[1], num_prisms);
    state.num_prisms = static_cast<int>(shape[1]);
    const RowMatrixI indices = state.file.read_int_matrix("/gradients/pairs", static_cast<Eigen::Index>(shape[0]), 2, 0,
                                                          std::numeric_limits<int>::max());
    for (Eigen::Index i = 0; i < indices.rows(); ++i) state.pairs.push_back({indices(i, 0), indices(i, 1)});
    state.pair_splits = state.file.read_strings("/gradients/splits", static_cast<std::int64_t>(shape[0]));
}

GradientReader::~GradientReader() = default;
GradientReader::GradientReader(GradientReader&&) noexcept = default;

int GradientReader::size() const
{
    return static_cast<int>(state_->pairs.size());
}

int GradientReader::num_prisms() const
{
    return state_->num_prisms;
}

const std::string& GradientReader::method() const
{
    return state_->method;
}

const std::vector<SamplePair>& GradientReader::pairs() const
{
    return state_->pairs;
}

const std::vector<std::string>& GradientReader::pair_splits() const
{
    return state_->pair_splits;
}

std::vector<float> GradientReader::read(int sample_idx) const
{
    return state_->file.read_slice("/gradients/F", static_cast<std::size_t>(sample_idx));
}

}  // namespace ndg
