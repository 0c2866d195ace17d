// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_guard.h"
#include "ndg/io/h5_handles.h"
#include "ndg/io/schema.h"

#include <cmath>
#include <map>
#include <mutex>

namespace ndg {
namespace {

using h5::Handle;
using Shape = std::vector<std::size_t>;

std::string shape_text(const Shape& shape)
{
    if (shape.empty()) return "a scalar";
    std::string text;
    for (const std::size_t extent : shape) text += (text.empty() ? "" : " x ") + std::to_string(extent);
    return text;
}

std::string wanted_text(const std::vector<std::int64_t>& wanted)
{
    std::string text;
    for (const std::int64_t extent : wanted) {
        text += (text.empty() ? "" : " x ") + (extent < 0 ? std::string("N") : std::to_string(extent));
    }
    return text;
}

std::size_t count_of(const Shape& shape)
{
    std::size_t count = 1;
    for (const std::size_t extent : shape) count *= extent;
    return count;
}

/// "(2, 1)" for a matrix, "5" for a vector.
std::string index_text(const Shape& shape, std::size_t flat)
{
    if (shape.size() != 2) return std::to_string(flat);
    return fmt::format("({}, {})", flat / shape[1], flat % shape[1]);
}

}  // namespace

struct H5Reader::State {
    std::string path;
    Handle file;
    std::mutex mutex;                               // of the map
    std::map<std::string, Handle> sliced_datasets;  // stay open between slices and so keep their chunk cache

    /// Opens a dataset of the wanted class and shape (-1: any extent).
    Handle open(const std::string& name, H5T_class_t type_class, const std::vector<std::int64_t>& wanted) const;
    template <typename T>
    std::vector<T> read(const std::string& name, hid_t dataset, hid_t memory_type) const;
    std::vector<double> read_reals(const std::string& name, const std::vector<std::int64_t>& wanted,
                                   Shape* shape) const;
    std::vector<int> read_integers(const std::string& name, const std::vector<std::int64_t>& wanted, int low, int high,
                                   Shape* shape) const;
};

Handle H5Reader::State::open(const std::string& name, H5T_class_t type_class,
                             const std::vector<std::int64_t>& wanted) const
{
    const h5::ReadingGuard guard(path);
    Handle dataset = h5::open_dataset(file, path, name);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const char* expected = type_class == H5T_FLOAT ? "real numbers" : type_class == H5T_INTEGER ? "integers" : "text";
    require_input(H5Tget_class(type) == type_class, "{}: dataset {} holds {}, expected {}", path, name,
                  h5::type_name(type), expected);
    const Shape shape = h5::dataset_shape(dataset);
    bool fits = shape.size() == wanted.size();
    for (std::size_t i = 0; fits && i < wanted.size(); ++i) {
        fits = wanted[i] < 0 || shape[i] == static_cast<std::size_t>(wanted[i]);
    }
    require_input(fits, "{}: dataset {} is {}, expected {}", path, name, shape_text(shape), wanted_text(wanted));
    h5::check_stored_size(dataset, path, name);
    return dataset;
}

template <typename T>
std::vector<T> H5Reader::State::read(const std::string& name, hid_t dataset, hid_t memory_type) const
{
    std::vector<T> values(count_of(h5::dataset_shape(dataset)));
    if (values.empty()) return values;
    const h5::ReadingGuard guard(path, false);
    require_input(H5Dread(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) >= 0,
                  "{}: cannot read dataset {}, truncated or damaged ({})", path, name, h5::last_error());
    return values;
}

std::vector<double> H5Reader::State::read_reals(const std::string& name, const std::vector<std::int64_t>& wanted,
                                                Shape* shape) const
{
    const Handle dataset = open(name, H5T_FLOAT, wanted);
    *shape = h5::dataset_shape(dataset);
    auto values = read<double>(name, dataset, H5T_NATIVE_DOUBLE);
    for (std::size_t i = 0; i < values.size(); ++i) {
        require_input(std::isfinite(values[i]), "{}: dataset {} is not finite at {}: {}", path, name,
                      index_text(*shape, i), values[i]);
    }
    return values;
}

std::vector<int> H5Reader::State::read_integers(const std::string& name, const std::vector<std::int64_t>& wanted,
                                                int low, int high, Shape* shape) const
{
    const Handle dataset = open(name, H5T_INTEGER, wanted);
    *shape = h5::dataset_shape(dataset);
    // Through 64 bits, so that a value beyond int is seen and not clipped.
    const auto values = read<std::int64_t>(name, dataset, H5T_NATIVE_INT64);
    for (std::size_t i = 0; i < values.size(); ++i) {
        require_input(values[i] >= low && values[i] <= high, "{}: dataset {} at {} is {}, expected {} to {}", path,
                      name, index_text(*shape, i), values[i], low, high);
    }
    return {values.begin(), values.end()};
}

H5Reader::H5Reader(const std::string& path, const std::string& format, int format_version)
    : state_(std::make_unique<State>())
{
    check_format(format, format_version);
    state_->path = path;
    state_->file = h5::open_file(path);
    std::string found;
    require_input(h5::read_text_attribute(state_->file, path, "format", found),
                  "{}: attribute format is missing, not a file of this project", path);
    require_input(found == format, "{}: format is \"{}\", expected \"{}\"", path, found, format);
    const double version = attribute_double("format_version");
    require_input(version == format_version, "{}: format_version is {}, this program reads {}", path, version,
                  format_version);
    for (const auto& [name, value] : {std::pair<const char*, const char*>{"units", "m"}, {"up_axis", "y"}}) {
        const std::string stored = attribute(name);
        require_input(stored == value, "{}: attribute {} is \"{}\", expected \"{}\"", path, name, stored, value);
    }
}

H5Reader::~H5Reader()
{
    if (!state_) return;
    const h5::ReadingGuard guard(state_->path);
    state_.reset();
}
H5Reader::H5Reader(H5Reader&&) noexcept = default;

const std::string& H5Reader::path() const
{
    return state_->path;
}

bool H5Reader::has(const std::string& name) const
{
    h5::silence_errors();
    const h5::ReadingGuard guard(state_->path);
    return h5::link_exists(state_->file, name);
}

std::vector<std::size_t> H5Reader::shape(const std::string& name) const
{
    return h5::dataset_shape(h5::open_dataset(state_->file, state_->path, name));
}

RowMatrix H5Reader::read_matrix(const std::string& name, Eigen::Index rows, Eigen::Index cols) const
{
    Shape shape;
    const std::vector<double> values = state_->read_reals(name, {rows, cols}, &shape);
    return Eigen::Map<const RowMatrix>(values.data(), static_cast<Eigen::Index>(shape[0]),
                                       static_cast<Eigen::Index>(shape[1]));
}

RowMatrixI H5Reader::read_int_matrix(const std::string& name, Eigen::Index rows, Eigen::Index cols, int low,
                                     int high) const
{
    Shape shape;
    const std::vector<int> values = state_->read_integers(name, {rows, cols}, low, high, &shape);
    return Eigen::Map<const RowMatrixI>(values.data(), static_cast<Eigen::Index>(shape[0]),
                                        static_cast<Eigen::Index>(shape[1]));
}

std::vector<double> H5Reader::read_doubles(const std::string& name, std::int64_t count) const
{
    Shape shape;
    return state_->read_reals(name, {count}, &shape);
}

std::vector<int> H5Reader::read_ints(const std::string& name, std::int64_t count, int low, int high) const
{
    Shape shape;
    return state_->read_integers(name, {count}, low, high, &shape);
}

std::vector<std::string> H5Reader::read_strings(const std::string& name, std::int64_t count) const
{
    const Handle dataset = state_->open(name, H5T_STRING, {count});
    return h5::read_text_dataset(dataset, state_->path, name);
}

std::vector<float> H5Reader::read_slice(const std::string& name, std::size_t index) const
{
    h5::silence_errors();
    const h5::ReadingGuard guard(state_->path, false);
    const std::lock_guard<std::mutex> lock(state_->mutex);
    auto found = state_->sliced_datasets.find(name);
    if (found == state_->sliced_datasets.end()) {
        const std::size_t rank = shape(name).size();
        require_input(rank > 0, "{}: dataset {} is a scalar, expected slices", state_->path, name);
        Handle opened = state_->open(name, H5T_FLOAT, std::vector<std::int64_t>(rank, -1));
        found = state_->sliced_datasets.emplace(name, std::move(opened)).first;
    }
    const hid_t dataset = found->second;
    const Shape whole = h5::dataset_shape(dataset);
    require_input(index < whole[0], "{}: dataset {} has {} slices, slice {} was asked for", state_->path, name,
                  whole[0], index);
    std::vector<hsize_t> start(whole.size(), 0), extent(whole.begin(), whole.end());
    start[0] = index;
    extent[0] = 1;
    std::vector<float> values(count_of({extent.begin(), extent.end()}));
    if (values.empty()) return values;
    const Handle file_space(H5Dget_space(dataset), H5Sclose);
    const Handle memory_space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
    const bool done =
        H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr) >= 0 &&
        H5Dread(dataset, H5T_NATIVE_FLOAT, memory_space, file_space, H5P_DEFAULT, values.data()) >= 0;
    require_input(done, "{}: cannot read slice {} of dataset {}, truncated or damaged ({})", state_->path, index, name,
                  h5::last_error());
    for (std::size_t i = 0; i < values.size(); ++i) {
        require_input(std::isfinite(values[i]), "{}: slice {} of dataset {} is not finite at {}: {}", state_->path,
                      index, name, i, values[i]);
    }
    return values;
}

std::string H5Reader::attribute(const std::string& name) const
{
    std::string value;
    require_input(h5::read_text_attribute(state_->file, state_->path, name, value),
                  "{}: attribute {} is missing or no text", state_->path, name);
    return value;
}

bool H5Reader::has_attribute(const std::string& name) const
{
    std::string value;
    return h5::read_text_attribute(state_->file, state_->path, name, value);
}

double H5Reader::attribute_double(const std::string& name) const
{
    h5::silence_errors();
    const h5::ReadingGuard guard(state_->path);
    require_input(H5Aexists(state_->file, name.c_str()) > 0, "{}: attribute {} is missing", state_->path, name);
    const Handle attribute(H5Aopen(state_->file, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Handle type(H5Aget_type(attribute), H5Tclose);
    const Handle space(H5Aget_space(attribute), H5Sclose);
    const H5T_class_t type_class = H5Tget_class(type);
    require_input((type_class == H5T_FLOAT || type_class == H5T_INTEGER) && H5Sget_simple_extent_npoints(space) == 1,
                  "{}: attribute {} is not a single number", state_->path, name);
    double value = 0;
    require_input(H5Aread(attribute, H5T_NATIVE_DOUBLE, &value) >= 0 && std::isfinite(value),
                  "{}: attribute {} cannot be read as a finite number", state_->path, name);
    return value;
}

}  // namespace ndg
