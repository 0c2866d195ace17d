// SPDX-License-Identifier: Apache-2.0
// HDF5 files of the project (docs/formats.md). No HDF5 type leaks from this header.
//
// Every file carries the root attributes format, format_version, units ("m"), up_axis ("y"), created_by (JSON: tool,
// version, commit), config (JSON), inputs (JSON list of path and sha256) and licences (one a line: the tool's own and
// those of every input that is an HDF5 file with such an attribute).
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

enum class Storage { float32, float64 };
struct VirtualSource;

/// Writes to PATH.<pid>.tmp and renames on commit(); without commit() nothing is left behind.
/// Dataset names are absolute paths ("/skin/vertices"); groups are made as needed. Matrices are stored row-major.
/// Real data must be finite: NaN or infinity throws Error naming file, dataset and index. So does a format or version
/// that schema.h does not know.
class H5Writer {
public:
    H5Writer(const std::string& path, const std::string& format, int format_version, const Provenance& provenance);
    ~H5Writer();
    H5Writer(const H5Writer&) = delete;
    H5Writer& operator=(const H5Writer&) = delete;

    void write(const std::string& name, const Eigen::Ref<const RowMatrix>& matrix, const std::string& description,
               Storage storage = Storage::float32);
    void write(const std::string& name, const Eigen::Ref<const RowMatrixI>& matrix, const std::string& description);
    void write(const std::string& name, const std::vector<double>& values, const std::string& description,
               Storage storage = Storage::float64);
    void write(const std::string& name, const std::vector<int>& values, const std::string& description);
    void write(const std::string& name, const std::vector<std::string>& values, const std::string& description);
    /// N-dimensional float32 data, row-major, chunked along the first axis, shuffle and deflate.
    void write(const std::string& name, const std::vector<std::size_t>& shape, const float* data,
               const std::string& description);

    /// An N-dimensional float32 dataset filled slice by slice along the first axis: create, then write_slice for each.
    void create(const std::string& name, const std::vector<std::size_t>& shape, const std::string& description);
    void write_slice(const std::string& name, std::size_t index, const float* data);

    /// A float32 dataset whose slices along the first axis stay in the files they lie in (a virtual dataset). What no
    /// source covers, or lies in a source that is lost, reads as not-a-number, which every reader here refuses.
    void link(const std::string& name, const std::vector<std::size_t>& shape, const std::vector<VirtualSource>& sources,
              const std::string& description);

    void attribute(const std::string& name, const std::string& value);
    void attribute(const std::string& name, double value);

    /// Flushes, fsyncs and renames to the final name. Every slice of every created dataset must have been written, and
    /// all that was written must follow the schema of the format (schema.h), otherwise Error.
    void commit();

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Opens read-only and checks format and version. Every reading function throws InputError naming file, dataset and
/// what is wrong: missing dataset, wrong rank or shape, wrong type, non-finite value, truncated file.
class H5Reader {
public:
    H5Reader(const std::string& path, const std::string& format, int format_version);
    ~H5Reader();
    H5Reader(H5Reader&&) noexcept;

    const std::string& path() const;
    bool has(const std::string& name) const;
    std::vector<std::size_t> shape(const std::string& name) const;

    /// rows or cols -1: any.
    RowMatrix read_matrix(const std::string& name, Eigen::Index rows = -1, Eigen::Index cols = -1) const;
    /// Every entry must lie in [low, high].
    RowMatrixI read_int_matrix(const std::string& name, Eigen::Index rows, Eigen::Index cols, int low, int high) const;
    std::vector<double> read_doubles(const std::string& name, std::int64_t count = -1) const;
    std::vector<int> read_ints(const std::string& name, std::int64_t count, int low, int high) const;
    std::vector<std::string> read_strings(const std::string& name, std::int64_t count = -1) const;
    /// Slice `index` along the first axis of an N-dimensional dataset, as float32 in row-major order; finite.
    std::vector<float> read_slice(const std::string& name, std::size_t index) const;

    std::string attribute(const std::string& name) const;
    /// Whether there is a text attribute of that name.
    bool has_attribute(const std::string& name) const;
    double attribute_double(const std::string& name) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// What stands in any of our files, for ndg-info: (path, type and shape, description) a dataset and (name, value) an
/// attribute. Throws InputError if it is not an HDF5 file.
struct H5Listing {
    struct Dataset {
        std::string path, type, description;
        std::vector<std::size_t> shape;
    };
    std::vector<Dataset> datasets;
    std::vector<std::pair<std::string, std::string>> attributes;
};
H5Listing list_h5(const std::string& path);
/// Reads every dataset of an HDF5 file with all its checksums. Throws InputError naming the first that is damaged,
/// holds a value that is not finite or does not follow the schema of the file's format.
void check_h5(const std::string& path);

}  // namespace ndg
