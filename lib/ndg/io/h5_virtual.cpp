// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/h5_virtual.h"

#include "ndg/core/error.h"
#include "ndg/io/h5_handles.h"

#include <algorithm>
#include <limits>

namespace ndg {
namespace {

using h5::Handle;

/// Slices [source, source + count) of a source that stand at place, place + stride, ...
struct Run {
    std::size_t source = 0, place = 0, stride = 1, count = 1;
};

/// The longest runs in turn: a shard of every n-th sample is one.
std::vector<Run> runs_of(const VirtualSource& source)
{
    std::vector<Run> runs;
    for (std::size_t i = 0; i < source.places.size();) {
        Run run{source.slices[i], source.places[i], 1, 1};
        std::size_t next = i + 1;
        if (next < source.places.size()) run.stride = source.places[next] - source.places[i];
        while (next < source.places.size() && source.slices[next] == source.slices[next - 1] + 1 &&
               source.places[next] == source.places[next - 1] + run.stride) {
            ++next;
        }
        run.count = next - i;
        if (run.count == 1) run.stride = 1;
        runs.push_back(run);
        i = next;
    }
    return runs;
}

/// HDF5 takes a percent sign in a source's name for a format.
std::string escape(const std::string& path)
{
    std::string text;
    for (const char letter : path) text += letter == '%' ? "%%" : std::string(1, letter);
    return text;
}

bool select_slices(hid_t space, const std::vector<std::size_t>& shape, std::size_t first, std::size_t stride,
                   std::size_t count)
{
    // Per axis: one block of the whole extent, but along the first `count` blocks of one slice.
    std::vector<hsize_t> start, strides, counts, blocks;
    for (const std::size_t extent : shape) {
        const bool is_first = start.empty();
        start.push_back(is_first ? first : 0);
        strides.push_back(is_first ? stride : 1);
        counts.push_back(is_first ? count : 1);
        blocks.push_back(is_first ? 1 : extent);
    }
    return H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), strides.data(), counts.data(), blocks.data()) >= 0;
}

Handle make_space(std::vector<std::size_t> shape, std::size_t num_slices)
{
    shape[0] = num_slices;
    const std::vector<hsize_t> extent(shape.begin(), shape.end());
    return Handle(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
}

}  // namespace

Handle h5::virtual_creation(const std::string& path, const std::string& name, const std::vector<std::size_t>& shape,
                            const std::vector<VirtualSource>& sources)
{
    Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    const float fill = std::numeric_limits<float>::quiet_NaN();
    H5Pset_fill_value(creation, H5T_NATIVE_FLOAT, &fill);
    const Handle space = make_space(shape, shape[0]);
    for (const VirtualSource& source : sources) {
        require(source.slices.size() == source.places.size(), "{}: {} slices of {} were given {} places", path,
                source.slices.size(), source.path, source.places.size());
        const Handle source_space = make_space(shape, source.num_slices);
        for (const Run& run : runs_of(source)) {
            require(select_slices(space, shape, run.place, run.stride, run.count) &&
                        select_slices(source_space, shape, run.source, 1, run.count) &&
                        H5Pset_virtual(creation, space, escape(source.path).c_str(), name.c_str(), source_space) >= 0,
                    "{}: cannot write virtual dataset {} ({})", path, name, h5::last_error());
        }
    }
    return creation;
}

std::vector<std::string> virtual_sources(const std::string& path, const std::string& name)
{
    const Handle file = h5::open_file(path);
    const Handle dataset = h5::open_dataset(file, path, name);
    const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
    std::vector<std::string> sources;
    if (H5Pget_layout(creation) != H5D_VIRTUAL) return sources;
    std::size_t count = 0;
    H5Pget_virtual_count(creation, &count);
    for (std::size_t i = 0; i < count; ++i) {
        const auto length = H5Pget_virtual_filename(creation, i, nullptr, 0);
        require_input(length > 0, "{}: dataset {} names no file for its part {}", path, name, i);
        std::string stored(static_cast<std::size_t>(length) + 1, '\0');
        H5Pget_virtual_filename(creation, i, stored.data(), stored.size());
        std::string source;
        for (std::size_t at = 0; at < static_cast<std::size_t>(length); ++at) {
            source += stored[at];
            if (stored[at] == '%' && stored[at + 1] == '%') ++at;
        }
        if (std::find(sources.begin(), sources.end(), source) == sources.end()) sources.push_back(source);
    }
    return sources;
}

}  // namespace ndg
