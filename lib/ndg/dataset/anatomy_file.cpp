// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/anatomy_file.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

#include <limits>

namespace ndg {

namespace {

const std::string anatomy_format = "ndg-anatomy";
constexpr int anatomy_version = 1;

}  // namespace

struct AnatomyWriter::State {
    H5Writer file;
    std::string path;
    int num_vertices;

    State(const std::string& path_in, const Provenance& provenance, int num_vertices_in)
        : file(path_in, anatomy_format, anatomy_version, provenance), path(path_in), num_vertices(num_vertices_in)
    {
    }
};

AnatomyWriter::AnatomyWriter(const std::string& path, const std::string& method, const std::vector<SamplePair>& pairs,
                             const std::vector<std::string>& pair_splits, const Triangles& triangles, int num_vertices,
                             const Provenance& provenance)
{
    require(!pairs.empty() && num_vertices > 0, "{}: there is no anatomy to write ({} samples of {} vertices)", path,
            pairs.size(), num_vertices);
    require(pairs.size() == pair_splits.size(), "{}: {} pairs but {} split names", path, pairs.size(),
            pair_splits.size());
    state_ = std::make_unique<State>(path, provenance, num_vertices);
    RowMatrixI indices(static_cast<Eigen::Index>(pairs.size()), 2);
    for (Eigen::Index i = 0; i < indices.rows(); ++i) {
        const SamplePair& pair = pairs[static_cast<std::size_t>(i)];
        indices.row(i) << pair.body_idx, pair.pose_idx;
    }
    state_->file.attribute("method", method);
    state_->file.write("/anatomy/triangles", RowMatrixI(triangles), "triangles of the anatomy vertices");
    state_->file.write("/anatomy/pairs", indices, "body index and pose index of each sample");
    state_->file.write("/anatomy/splits", pair_splits, "split of each sample");
    state_->file.create("/anatomy/vertices", {pairs.size(), static_cast<std::size_t>(num_vertices), 3},
                        "anatomy vertices carried by the deformed volume");
}

AnatomyWriter::~AnatomyWriter() = default;

void AnatomyWriter::write(int sample_idx, const Eigen::Ref<const Points>& vertices)
{
    require(vertices.rows() == state_->num_vertices, "{}: sample {} has {} anatomy vertices, expected {}", state_->path,
            sample_idx, vertices.rows(), state_->num_vertices);
    const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> single = vertices.cast<float>();
    state_->file.write_slice("/anatomy/vertices", static_cast<std::size_t>(sample_idx), single.data());
}

void AnatomyWriter::commit()
{
    state_->file.commit();
}

AnatomySet read_anatomy(const std::string& path, int num_vertices)
{
    const H5Reader file(path, anatomy_format, anatomy_version);
    const std::vector<std::size_t> shape = file.shape("/anatomy/vertices");
    require_input(shape.size() == 3 && shape[2] == 3,
                  "{}: /anatomy/vertices has shape ({}), expected samples x vertices x 3", path,
                  fmt::join(shape, " x "));
    require_input(num_vertices < 0 || shape[1] == static_cast<std::size_t>(num_vertices),
                  "{}: /anatomy/vertices holds {} vertices, the template has {}", path, shape[1], num_vertices);
    AnatomySet set;
    set.method = file.attribute("method");
    set.triangles = file.read_int_matrix("/anatomy/triangles", -1, 3, 0, static_cast<int>(shape[1]) - 1);
    const RowMatrixI indices = file.read_int_matrix("/anatomy/pairs", static_cast<Eigen::Index>(shape[0]), 2, 0,
                                                    std::numeric_limits<int>::max());
    for (Eigen::Index i = 0; i < indices.rows(); ++i) set.pairs.push_back({indices(i, 0), indices(i, 1)});
    set.pair_splits = file.read_strings("/anatomy/splits", static_cast<std::int64_t>(shape[0]));
    for (std::size_t i = 0; i < shape[0]; ++i) set.vertices.push_back(file.read_slice("/anatomy/vertices", i));
    return set;
}

}  // namespace ndg
