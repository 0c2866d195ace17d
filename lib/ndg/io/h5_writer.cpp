// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_handles.h"
#include "ndg/io/licences.h"
#include "ndg/io/schema.h"

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace ndg {
namespace {

using h5::Handle;
using Shape = std::vector<std::size_t>;

std::size_t count_of(const Shape& shape)
{
    std::size_t count = 1;
    for (const std::size_t extent : shape) count *= extent;
    return count;
}

/// Rows of one chunk: about 256 KiB, so that reading one slice does not unpack much more than the slice.
std::size_t chunk_rows(const Shape& shape, std::size_t element_size)
{
    constexpr std::size_t wanted_bytes = 256 * 1024;
    const std::size_t row_bytes = std::max<std::size_t>(1, count_of(shape) / shape[0] * element_size);
    return std::clamp<std::size_t>(wanted_bytes / row_bytes, 1, shape[0]);
}

/// (0, 3, 1) for flat index 10 of shape 2 x 4 x 2...
std::string index_text(const Shape& shape, std::size_t flat)
{
    std::string text;
    for (std::size_t axis = shape.size(); axis > 0; --axis) {
        text = std::to_string(flat % shape[axis - 1]) + (text.empty() ? "" : ", ") + text;
        flat /= shape[axis - 1];
    }
    return "(" + text + ")";
}

}  // namespace

struct H5Writer::State {
    struct Sliced {
        Handle dataset;
        Shape shape;
        std::vector<bool> written;
    };
    std::string path, temporary_path, format;
    Handle file;
    std::vector<FileItem> items;  // what was written so far, for the schema
    std::map<std::string, Sliced> sliced;
    bool committed = false;

    void check(bool done, const std::string& item) const
    {
        require(done, "{}: cannot write {} ({})", path, item, h5::last_error());
    }
    void put_text_attribute(hid_t object, const std::string& name, const std::string& value) const;
    template <typename T>
    void put_number_attribute(hid_t object, const std::string& name, hid_t file_type, hid_t type, T value) const;
    Handle create(const std::string& name, const Shape& shape, hid_t type, const std::string& description,
                  Handle creation = Handle(H5Pcreate(H5P_DATASET_CREATE), H5Pclose));
    void put(const std::string& name, const Shape& shape, hid_t file_type, hid_t memory_type, const void* data,
             const std::string& description);
    template <typename T>
    void check_finite(const std::string& name, const Shape& shape, const T* data, std::size_t begin,
                      std::size_t end) const;
    void put_reals(const std::string& name, const Shape& shape, const double* data, const std::string& description,
                   Storage storage);
};

void H5Writer::State::put_text_attribute(hid_t object, const std::string& name, const std::string& value) const
{
    require(value.find('\0') == std::string::npos, "{}: attribute {} holds a zero byte", path, name);
    check(h5::write_text_attribute(object, name, value), "attribute " + name);
}

template <typename T>
void H5Writer::State::put_number_attribute(hid_t object, const std::string& name, hid_t file_type, hid_t type,
                                           T value) const
{
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    if (H5Aexists(object, name.c_str()) > 0) H5Adelete(object, name.c_str());
    const Handle attribute(H5Acreate2(object, name.c_str(), file_type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(attribute.valid() && H5Awrite(attribute, type, &value) >= 0, "attribute " + name);
}

Handle H5Writer::State::create(const std::string& name, const Shape& shape, hid_t type, const std::string& description,
                               Handle creation)
{
    require(!committed, "{}: dataset {} written after commit", path, name);
    require(!name.empty() && name.front() == '/', "{}: dataset name '{}' must start with /", path, name);
    const std::vector<hsize_t> extent(shape.begin(), shape.end());
    const Handle space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
    H5Pset_obj_track_times(creation, false);  // equal content gives equal bytes
    const std::size_t count = count_of(shape), element_size = H5Tget_size(type);
    constexpr std::size_t bulk_bytes = 64 * 1024;
    const bool is_text = H5Tget_class(type) == H5T_STRING;
    const bool is_virtual = H5Pget_layout(creation) == H5D_VIRTUAL;
    if (count > 0 && !is_text && !is_virtual && (shape.size() >= 2 || count * element_size >= bulk_bytes)) {
        std::vector<hsize_t> chunk = extent;
        chunk[0] = chunk_rows(shape, element_size);
        const std::size_t chunk_bytes = count / shape[0] * chunk[0] * element_size;
        require(chunk_bytes <= std::numeric_limits<std::uint32_t>::max(),
                "{}: one slice of dataset {} exceeds the 4 GiB of an HDF5 chunk", path, name);
        H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data());
        H5Pset_shuffle(creation);
        H5Pset_deflate(creation, 4);
        H5Pset_fletcher32(creation);
    }
    const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    H5Pset_create_intermediate_group(links, 1);
    Handle dataset(H5Dcreate2(file, name.c_str(), type, space, links, creation, H5P_DEFAULT), H5Dclose);
    check(dataset.valid(), "dataset " + name);
    put_text_attribute(dataset, "description", description);
    items.push_back({name, h5::type_name(type), shape});
    return dataset;
}

void H5Writer::State::put(const std::string& name, const Shape& shape, hid_t file_type, hid_t memory_type,
                          const void* data, const std::string& description)
{
    const Handle dataset = create(name, shape, file_type, description);
    if (count_of(shape) == 0) return;
    check(H5Dwrite(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0, "dataset " + name);
}

/// `data` holds the elements [begin, end) of the dataset.
template <typename T>
void H5Writer::State::check_finite(const std::string& name, const Shape& shape, const T* data, std::size_t begin,
                                   std::size_t end) const
{
    for (std::size_t i = begin; i < end; ++i) {
        require(std::isfinite(data[i - begin]), "{}: dataset {} is not finite at {}: {}", path, name,
                index_text(shape, i), data[i - begin]);
    }
}

void H5Writer::State::put_reals(const std::string& name, const Shape& shape, const double* data,
                                const std::string& description, Storage storage)
{
    check_finite(name, shape, data, 0, count_of(shape));
    if (storage == Storage::float64) return put(name, shape, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, data, description);
    std::vector<float> values(count_of(shape));
    std::transform(data, data + values.size(), values.begin(), [](double value) { return static_cast<float>(value); });
    check_finite(name, shape, values.data(), 0, values.size());  // a large double may overflow
    put(name, shape, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, values.data(), description);
}

H5Writer::H5Writer(const std::string& path, const std::string& format, int format_version, const Provenance& provenance)
    : state_(std::make_unique<State>())
{
    check_format(format, format_version);
    h5::silence_errors();
    state_->path = path;
    state_->format = format;
    state_->temporary_path = temporary_name(path);
    // Gathered before the file exists: an input that cannot be read must leave nothing behind.
    const std::string licences = merge_licences(provenance);

    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_libver_bounds(access, H5F_LIBVER_EARLIEST, H5F_LIBVER_V110);
    H5Pset_fclose_degree(access, H5F_CLOSE_STRONG);
    H5Pset_file_locking(access, false, true);  // the temporary name is ours alone
    const Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_obj_track_times(creation, false);
    state_->file = Handle(H5Fcreate(state_->temporary_path.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose);
    require(state_->file.valid(), "{}: cannot create {} ({})", path, state_->temporary_path, h5::last_error());

    try {
        using nlohmann::json;
        const hid_t root = state_->file;
        state_->put_text_attribute(root, "format", format);
        state_->put_number_attribute(root, "format_version", H5T_STD_I32LE, H5T_NATIVE_INT, format_version);
        state_->put_text_attribute(root, "units", "m");
        state_->put_text_attribute(root, "up_axis", "y");
        const json created_by = {
            {"tool", provenance.tool}, {"version", project_version()}, {"commit", project_commit()}};
        state_->put_text_attribute(root, "created_by", created_by.dump());
        state_->put_text_attribute(root, "config", provenance.config_json);
        json inputs = json::array();
        for (const auto& input : provenance.inputs) {
            inputs.push_back({{"path", input.path}, {"sha256", input.sha256}});
        }
        state_->put_text_attribute(root, "inputs", inputs.dump());
        state_->put_text_attribute(root, "licences", licences);
    } catch (...) {
        state_->file.reset();
        ::unlink(state_->temporary_path.c_str());
        throw;
    }
}

H5Writer::~H5Writer()
{
    if (state_->committed) return;
    state_->sliced.clear();
    state_->file.reset();
    ::unlink(state_->temporary_path.c_str());
}

void H5Writer::write(const std::string& name, const Eigen::Ref<const RowMatrix>& matrix, const std::string& description,
                     Storage storage)
{
    const RowMatrix contiguous = matrix;  // a block has gaps between its rows
    const Shape shape = {static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())};
    state_->put_reals(name, shape, contiguous.data(), description, storage);
}

void H5Writer::write(const std::string& name, const Eigen::Ref<const RowMatrixI>& matrix,
                     const std::string& description)
{
    const RowMatrixI contiguous = matrix;
    const Shape shape = {static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())};
    state_->put(name, shape, H5T_STD_I32LE, H5T_NATIVE_INT, contiguous.data(), description);
}

void H5Writer::write(const std::string& name, const std::vector<double>& values, const std::string& description,
                     Storage storage)
{
    state_->put_reals(name, {values.size()}, values.data(), description, storage);
}

void H5Writer::write(const std::string& name, const std::vector<int>& values, const std::string& description)
{
    state_->put(name, {values.size()}, H5T_STD_I32LE, H5T_NATIVE_INT, values.data(), description);
}

void H5Writer::write(const std::string& name, const std::vector<std::string>& values, const std::string& description)
{
    std::vector<const char*> texts;
    for (const std::string& value : values) {
        require(value.find('\0') == std::string::npos, "{}: dataset {} holds a zero byte", state_->path, name);
        texts.push_back(value.c_str());
    }
    const Handle type = h5::text_type();
    state_->put(name, {values.size()}, type, type, texts.data(), description);
}

void H5Writer::write(const std::string& name, const std::vector<std::size_t>& shape, const float* data,
                     const std::string& description)
{
    state_->check_finite(name, shape, data, 0, count_of(shape));
    state_->put(name, shape, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT, data, description);
}

void H5Writer::create(const std::string& name, const std::vector<std::size_t>& shape, const std::string& description)
{
    require(!shape.empty(), "{}: dataset {} needs at least one axis", state_->path, name);
    Handle dataset = state_->create(name, shape, H5T_IEEE_F32LE, description);
    state_->sliced[name] = {std::move(dataset), shape, std::vector<bool>(shape[0], count_of(shape) == 0)};
}

void H5Writer::write_slice(const std::string& name, std::size_t index, const float* data)
{
    const auto found = state_->sliced.find(name);
    require(found != state_->sliced.end(), "{}: dataset {} was not created for slices", state_->path, name);
    State::Sliced& sliced = found->second;
    require(index < sliced.shape[0], "{}: dataset {} has {} slices, cannot write slice {}", state_->path, name,
            sliced.shape[0], index);
    Shape slice_shape = sliced.shape;
    slice_shape[0] = 1;
    const std::size_t count = count_of(slice_shape);
    state_->check_finite(name, sliced.shape, data, index * count, (index + 1) * count);
    std::vector<hsize_t> start(slice_shape.size(), 0);
    start[0] = index;
    const std::vector<hsize_t> extent(slice_shape.begin(), slice_shape.end());
    const int rank = static_cast<int>(extent.size());
    const Handle file_space(H5Dget_space(sliced.dataset), H5Sclose);
    const Handle memory_space(H5Screate_simple(rank, extent.data(), nullptr), H5Sclose);
    state_->check(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr) >= 0 &&
                      H5Dwrite(sliced.dataset, H5T_NATIVE_FLOAT, memory_space, file_space, H5P_DEFAULT, data) >= 0,
                  "dataset " + name);
    sliced.written[index] = true;
}

void H5Writer::link(const std::string& name, const std::vector<std::size_t>& shape,
                    const std::vector<VirtualSource>& sources, const std::string& description)
{
    require(!shape.empty(), "{}: dataset {} needs at least one axis", state_->path, name);
    state_->create(name, shape, H5T_IEEE_F32LE, description, h5::virtual_creation(state_->path, name, shape, sources));
}

void H5Writer::attribute(const std::string& name, const std::string& value)
{
    state_->put_text_attribute(state_->file, name, value);
    state_->items.push_back({"@" + name, "text", {}});
}

void H5Writer::attribute(const std::string& name, double value)
{
    require(std::isfinite(value), "{}: attribute {} is not finite: {}", state_->path, name, value);
    state_->put_number_attribute(state_->file, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, value);
    state_->items.push_back({"@" + name, "float64", {}});
}

void H5Writer::commit()
{
    require(!state_->committed, "{}: committed twice", state_->path);
    const std::string violation = schema_violation(state_->format, state_->items);
    require(violation.empty(), "{}: {}", state_->path, violation);
    for (auto& [name, sliced] : state_->sliced) {
        const auto missing = std::find(sliced.written.begin(), sliced.written.end(), false);
        require(missing == sliced.written.end(), "{}: slice {} of dataset {} was never written", state_->path,
                missing - sliced.written.begin(), name);
        state_->check(sliced.dataset.reset(), "dataset " + name);
    }
    state_->sliced.clear();
    state_->check(state_->file.reset(), "the file");
    replace_file(state_->temporary_path, state_->path);
    state_->committed = true;
}

}  // namespace ndg
