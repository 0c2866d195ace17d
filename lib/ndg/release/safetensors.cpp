// SPDX-License-Identifier: Apache-2.0
#include "ndg/release/safetensors.h"

#include "ndg/core/error.h"
#include "ndg/core/stream_file.h"
#include "ndg/io/h5.h"
#include "ndg/runtime/model_traits.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdint>

namespace ndg {
namespace {

using nlohmann::json;

std::size_t item_bytes(const H5Listing::Dataset& dataset)
{
    return dataset.type == "float64" ? 8 : 4;
}

const char* type_name(const H5Listing::Dataset& dataset)
{
    return dataset.type == "float64" ? "F64" : dataset.type == "float32" ? "F32" : "I32";
}

std::string tensor_name(const std::string& dataset)
{
    std::string name = dataset.substr(1);
    std::replace(name.begin(), name.end(), '/', '.');
    return name;
}

template <typename T>
void put(std::ostream& stream, const std::vector<T>& values)
{
    stream.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(sizeof(T) * values.size()));
}

void put_numbers(std::ostream& stream, const H5Reader& file, const H5Listing::Dataset& dataset)
{
    const std::string& name = dataset.path;
    if (dataset.type == "int32") return put(stream, file.read_ints(name, -1, -(1 << 30), 1 << 30));
    if (dataset.type == "float64" && dataset.shape.size() == 2) {
        const RowMatrix matrix = file.read_matrix(name);
        return put(stream, std::vector<double>(matrix.data(), matrix.data() + matrix.size()));
    }
    if (dataset.type == "float64") return put(stream, file.read_doubles(name));
    if (dataset.shape.size() == 1) {
        const std::vector<double> values = file.read_doubles(name);  // of float32, so exact
        return put(stream, std::vector<float>(values.begin(), values.end()));
    }
    for (std::size_t row = 0; row < dataset.shape[0]; ++row) put(stream, file.read_slice(name, row));
}

}  // namespace

void write_safetensors(const std::string& path, const std::string& model_path)
{
    const H5Reader file(model_path, model_format, model_version);
    const H5Listing listing = list_h5(model_path);
    std::vector<H5Listing::Dataset> tensors;
    for (const H5Listing::Dataset& dataset : listing.datasets)
        if (dataset.type != "text") tensors.push_back(dataset);
    // Numbers of eight bytes first: every tensor is then aligned to its own.
    std::stable_sort(tensors.begin(), tensors.end(),
                     [](const auto& a, const auto& b) { return item_bytes(a) > item_bytes(b); });

    json header;
    for (const auto& [name, value] : listing.attributes) header["__metadata__"][name] = value;
    std::size_t end = 0;
    for (const H5Listing::Dataset& dataset : tensors) {
        const std::size_t begin = end;
        std::size_t count = 1;
        for (const std::size_t extent : dataset.shape) count *= extent;
        end += count * item_bytes(dataset);
        header[tensor_name(dataset.path)] = {
            {"dtype", type_name(dataset)}, {"shape", dataset.shape}, {"data_offsets", {begin, end}}};
    }
    std::string text = header.dump();
    text.resize((text.size() + 7) / 8 * 8, ' ');

    write_stream(path, [&](std::ostream& stream) {
        put(stream, std::vector<std::uint64_t>{text.size()});
        stream << text;
        for (const H5Listing::Dataset& dataset : tensors) put_numbers(stream, file, dataset);
    });
}

}  // namespace ndg
