// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_guard.h"
#include "ndg/io/h5_handles.h"
#include "ndg/io/schema.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

using h5::Handle;

herr_t collect_dataset(hid_t, const char* name, const H5O_info_t* info, void* result)
{
    if (info->type == H5O_TYPE_DATASET)
        static_cast<std::vector<std::string>*>(result)->push_back("/" + std::string(name));
    return 0;
}

herr_t collect_attribute(hid_t, const char* name, const H5A_info_t*, void* result)
{
    static_cast<std::vector<std::string>*>(result)->emplace_back(name);
    return 0;
}

std::vector<std::string> dataset_names(hid_t file, const std::string& path)
{
    std::vector<std::string> names;
    require_input(H5Ovisit2(file, H5_INDEX_NAME, H5_ITER_INC, collect_dataset, &names, H5O_INFO_BASIC) >= 0,
                  "{}: cannot list its datasets, truncated or damaged ({})", path, h5::last_error());
    return names;
}

std::vector<std::string> attribute_names(hid_t file, const std::string& path)
{
    std::vector<std::string> names;
    require_input(H5Aiterate2(file, H5_INDEX_NAME, H5_ITER_INC, nullptr, collect_attribute, &names) >= 0,
                  "{}: cannot list its attributes, truncated or damaged ({})", path, h5::last_error());
    return names;
}

/// Text and single numbers; anything else as its type.
std::string attribute_text(hid_t file, const std::string& path, const std::string& name)
{
    std::string text;
    if (h5::read_text_attribute(file, path, name, text)) return text;
    const Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Handle type(H5Aget_type(attribute), H5Tclose);
    const Handle space(H5Aget_space(attribute), H5Sclose);
    const H5T_class_t type_class = H5Tget_class(type);
    const bool single = H5Sget_simple_extent_npoints(space) == 1;
    double real = 0;
    std::int64_t integer = 0;
    if (single && type_class == H5T_FLOAT && H5Aread(attribute, H5T_NATIVE_DOUBLE, &real) >= 0) {
        return fmt::format("{}", real);
    }
    if (single && type_class == H5T_INTEGER && H5Aread(attribute, H5T_NATIVE_INT64, &integer) >= 0) {
        return fmt::format("{}", integer);
    }
    return "(" + h5::type_name(type) + ")";
}

/// Reads a numeric dataset row by row along its first axis, so that memory stays small; reals must be finite.
void check_numbers(hid_t dataset, const std::string& path, const std::string& name)
{
    const std::vector<std::size_t> shape = h5::dataset_shape(dataset);
    std::size_t row_count = 1;
    for (std::size_t axis = 1; axis < shape.size(); ++axis) row_count *= shape[axis];
    const std::size_t num_rows = shape.empty() ? 1 : shape[0];
    if (num_rows * row_count == 0) return;
    constexpr std::size_t values_at_once = 1 << 20;
    const std::size_t step = std::max<std::size_t>(1, values_at_once / row_count);
    std::vector<double> values;
    const Handle file_space(H5Dget_space(dataset), H5Sclose);
    for (std::size_t begin = 0; begin < num_rows; begin += step) {
        const std::size_t rows = std::min(step, num_rows - begin);
        values.resize(rows * row_count);
        std::vector<hsize_t> start(shape.size(), 0), extent(shape.begin(), shape.end());
        if (!shape.empty()) {
            start[0] = begin;
            extent[0] = rows;
            H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr);
        }
        const hsize_t count = values.size();
        const Handle memory_space(H5Screate_simple(1, &count, nullptr), H5Sclose);
        require_input(H5Dread(dataset, H5T_NATIVE_DOUBLE, memory_space, file_space, H5P_DEFAULT, values.data()) >= 0,
                      "{}: cannot read dataset {} at row {}, truncated or damaged ({})", path, name, begin,
                      h5::last_error());
        for (std::size_t i = 0; i < values.size(); ++i) {
            require_input(std::isfinite(values[i]), "{}: dataset {} is not finite in row {}: {}", path, name,
                          begin + i / row_count, values[i]);
        }
    }
}

void check_schema(hid_t file, const std::string& path)
{
    std::vector<FileItem> items;
    for (const std::string& name : dataset_names(file, path)) {
        const Handle dataset = h5::open_dataset(file, path, name);
        const Handle type(H5Dget_type(dataset), H5Tclose);
        items.push_back({name, h5::type_name(type), h5::dataset_shape(dataset)});
    }
    for (const std::string& name : attribute_names(file, path)) {
        const Handle attribute(H5Aopen(file, name.c_str(), H5P_DEFAULT), H5Aclose);
        const Handle type(H5Aget_type(attribute), H5Tclose);
        items.push_back({"@" + name, h5::type_name(type), {}});
    }
    std::string format;
    h5::read_text_attribute(file, path, "format", format);
    const std::string violation = schema_violation(format, items);
    require_input(violation.empty(), "{}: {}", path, violation);
}

}  // namespace

H5Listing list_h5(const std::string& path)
{
    const h5::ReadingGuard guard(path);
    const Handle file = h5::open_file(path);
    H5Listing listing;
    for (const std::string& name : attribute_names(file, path)) {
        listing.attributes.emplace_back(name, attribute_text(file, path, name));
    }
    for (const std::string& name : dataset_names(file, path)) {
        const Handle dataset = h5::open_dataset(file, path, name);
        const Handle type(H5Dget_type(dataset), H5Tclose);
        H5Listing::Dataset entry;
        entry.path = name;
        entry.type = h5::type_name(type);
        entry.shape = h5::dataset_shape(dataset);
        h5::read_text_attribute(dataset, path, "description", entry.description);
        listing.datasets.push_back(std::move(entry));
    }
    return listing;
}

void check_h5_schema(const std::string& path)
{
    const h5::ReadingGuard guard(path);
    check_schema(h5::open_file(path), path);
}

void check_h5(const std::string& path)
{
    const h5::ReadingGuard guard(path, false);  // reads all of it
    const Handle file = h5::open_file(path);
    for (const std::string& name : dataset_names(file, path)) {
        const Handle dataset = h5::open_dataset(file, path, name);
        const Handle type(H5Dget_type(dataset), H5Tclose);
        const H5T_class_t type_class = H5Tget_class(type);
        if (type_class == H5T_STRING) {
            h5::read_text_dataset(dataset, path, name);
        } else {
            require_input(type_class == H5T_FLOAT || type_class == H5T_INTEGER,
                          "{}: dataset {} holds neither numbers nor text", path, name);
            h5::check_stored_size(dataset, path, name);
            check_numbers(dataset, path, name);
        }
    }
    check_schema(file, path);
}

}  // namespace ndg
