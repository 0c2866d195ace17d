// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/h5_handles.h"

#include "ndg/core/error.h"
#include "ndg/core/text_file.h"
#include "ndg/io/h5_guard.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>

namespace ndg::h5 {
namespace {

herr_t keep_description(unsigned, const H5E_error2_t* error, void* result)
{
    auto& text = *static_cast<std::string*>(result);
    if (text.empty() && error->desc != nullptr) text = error->desc;
    return 0;
}

/// The strings in memory that `read` fills: char pointers (variable length) or padded fields (fixed length).
template <typename Read>
std::vector<std::string> read_texts(hid_t file_type, hid_t space, std::size_t count, Read&& read)
{
    std::vector<std::string> texts(count);
    if (count == 0) return texts;
    const Handle type(H5Tcopy(file_type), H5Tclose);
    if (H5Tis_variable_str(type) > 0) {
        std::vector<char*> pointers(count, nullptr);
        const bool done = read(type, pointers.data());
        for (std::size_t i = 0; done && i < count; ++i) texts[i] = pointers[i] != nullptr ? pointers[i] : "";
        H5Dvlen_reclaim(type, space, H5P_DEFAULT, pointers.data());
        if (!done) texts.clear();
        return texts;
    }
    const std::size_t size = H5Tget_size(type);
    std::vector<char> bytes(size * count);
    if (!read(type, bytes.data())) return {};
    const bool spaces = H5Tget_strpad(type) == H5T_STR_SPACEPAD;
    for (std::size_t i = 0; i < count; ++i) {
        const char* begin = bytes.data() + i * size;
        texts[i].assign(begin, std::find(begin, begin + size, '\0'));
        while (spaces && !texts[i].empty() && texts[i].back() == ' ') texts[i].pop_back();
    }
    return texts;
}

}  // namespace

void silence_errors()
{
    static const bool set_up = [] {
        // Finished files never change (writers rename), so reading needs no lock, which some network file systems lack.
        // Of files that a virtual dataset opens only the environment decides, read when HDF5 starts; and a file cannot
        // be opened twice, once with locks and once without.
        ::setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0);
        // A file that could not be written (disk full) stays open within HDF5, whose clean-up at exit would then
        // crash. Nothing is left to it anyway: every file of ours is closed by its handle.
        return H5dont_atexit() >= 0;
    }();
    static_cast<void>(set_up);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string last_error()
{
    std::string text;
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, keep_description, &text);
    // Of a failed system call the reason alone, without buffers and offsets.
    const std::string mark = "error message = '";
    const std::size_t begin = text.find(mark), end = text.find('\'', begin + mark.size());
    if (begin != std::string::npos && end != std::string::npos) {
        return text.substr(begin + mark.size(), end - begin - mark.size());
    }
    return text.empty() ? "unknown HDF5 error" : text;
}

bool is_h5(const std::string& path)
{
    silence_errors();
    const ReadingGuard guard(path);
    std::error_code error;
    return std::filesystem::is_regular_file(path, error) && H5Fis_hdf5(path.c_str()) > 0;
}

Handle open_file(const std::string& path)
{
    silence_errors();
    const ReadingGuard guard(path);
    std::error_code error;
    require_input(std::filesystem::exists(path, error), "{}: does not exist", path);
    require_input(!std::filesystem::is_directory(path, error), "{}: is a folder, expected an HDF5 file", path);
    require_input(H5Fis_hdf5(path.c_str()) > 0, "{}: is not an HDF5 file", path);
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    H5Pset_file_locking(access, false, true);
    H5Pset_fclose_degree(access, H5F_CLOSE_WEAK);  // as HDF5 opens the files of a virtual dataset
    Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose);
    if (!file.valid()) {
        const std::string reason = last_error();
        if (reason.find("lock file") != std::string::npos) {
            throw InputError(fmt::format("{}: another program holds a lock on it ({})", path, reason));
        }
        throw InputError(fmt::format("{}: cannot open, truncated or damaged ({})", path, reason));
    }
    return file;
}

bool link_exists(hid_t file, const std::string& name)
{
    if (name.empty() || name.front() != '/') return false;
    std::size_t end = 0;
    while (end != std::string::npos) {
        end = name.find('/', end + 1);
        if (H5Lexists(file, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    }
    return true;
}

namespace {

/// Throws InputError naming the filter where a dataset is packed by one that the library here lacks.
void require_filters(hid_t dataset, const std::string& path, const std::string& name)
{
    const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
    const int num_filters = H5Pget_nfilters(creation);
    for (int i = 0; i < num_filters; ++i) {
        unsigned flags = 0, config = 0;
        std::size_t num_values = 0;
        std::array<char, 64> label{};
        const H5Z_filter_t filter = H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &num_values, nullptr,
                                                   label.size() - 1, label.data(), &config);
        require_input(filter < 0 || H5Zfilter_avail(filter) > 0,
                      "{}: dataset {} is packed by HDF5 filter {}{}, which is missing here (h5repack -f GZIP=5 writes "
                      "the file without it)",
                      path, name, static_cast<int>(filter),
                      label[0] == '\0' ? std::string() : fmt::format(" (\"{}\")", label.data()));
    }
}

}  // namespace

Handle open_dataset(hid_t file, const std::string& path, const std::string& name)
{
    silence_errors();
    const ReadingGuard guard(path);
    require_input(link_exists(file, name), "{}: dataset {} is missing", path, name);
    Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
    require_input(dataset.valid(), "{}: cannot open dataset {} ({})", path, name, last_error());
    require_filters(dataset, path, name);
    return dataset;
}

std::vector<std::size_t> dataset_shape(hid_t dataset)
{
    const Handle space(H5Dget_space(dataset), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    std::vector<hsize_t> extent(std::max(rank, 0));
    H5Sget_simple_extent_dims(space, extent.data(), nullptr);
    return {extent.begin(), extent.end()};
}

void check_stored_size(hid_t dataset, const std::string& path, const std::string& name)
{
    const ReadingGuard guard(path);
    const Handle creation(H5Dget_create_plist(dataset), H5Pclose);
    if (H5Pget_layout(creation) == H5D_VIRTUAL) return;  // its data stands in other files
    double count = 1;
    for (const std::size_t extent : dataset_shape(dataset)) count *= static_cast<double>(extent);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    const double promised = count * static_cast<double>(H5Tget_size(type));
    const auto stored = static_cast<double>(H5Dget_storage_size(dataset));
    // Deflate cannot shrink by more than about 1032, so a header that promises more is wrong or the data is missing.
    require_input(promised <= 1100.0 * stored, "{}: dataset {} promises {} bytes but holds {}", path, name, promised,
                  stored);
}

bool read_text_attribute(hid_t object, const std::string& path, const std::string& name, std::string& value)
{
    silence_errors();
    const ReadingGuard guard(path);
    if (H5Aexists(object, name.c_str()) <= 0) return false;
    const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
    const Handle type(H5Aget_type(attribute), H5Tclose);
    const Handle space(H5Aget_space(attribute), H5Sclose);
    if (H5Tget_class(type) != H5T_STRING || H5Sget_simple_extent_npoints(space) != 1) return false;
    const auto texts = read_texts(
        type, space, 1, [&](hid_t memory_type, void* data) { return H5Aread(attribute, memory_type, data) >= 0; });
    require_input(!texts.empty(), "{}: cannot read attribute {} ({})", path, name, last_error());
    require_input(is_utf8(texts.front()), "{}: attribute {} is text that is not UTF-8, damaged", path, name);
    value = texts.front();
    return true;
}

std::vector<std::string> read_text_dataset(hid_t dataset, const std::string& path, const std::string& name)
{
    const ReadingGuard guard(path);
    const Handle type(H5Dget_type(dataset), H5Tclose);
    require_input(H5Tget_class(type) == H5T_STRING, "{}: dataset {} holds {}, expected text", path, name,
                  type_name(type));
    check_stored_size(dataset, path, name);
    std::size_t count = 1;
    for (const std::size_t extent : dataset_shape(dataset)) count *= extent;
    const Handle space(H5Dget_space(dataset), H5Sclose);
    auto texts = read_texts(type, space, count, [&](hid_t memory_type, void* data) {
        return H5Dread(dataset, memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0;
    });
    require_input(texts.size() == count, "{}: cannot read dataset {}, truncated or damaged ({})", path, name,
                  last_error());
    for (std::size_t i = 0; i < count; ++i)
        require_input(is_utf8(texts[i]), "{}: dataset {} at {} is text that is not UTF-8, damaged", path, name, i);
    return texts;
}

std::string type_name(hid_t type)
{
    const auto bits = 8 * H5Tget_size(type);
    switch (H5Tget_class(type)) {
        case H5T_FLOAT:
            return fmt::format("float{}", bits);
        case H5T_INTEGER:
            return fmt::format("{}int{}", H5Tget_sign(type) == H5T_SGN_NONE ? "u" : "", bits);
        case H5T_STRING:
            return "text";
        default:
            return "another type";
    }
}

Handle text_type()
{
    Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

bool write_text_attribute(hid_t object, const std::string& name, const std::string& value)
{
    const Handle type = text_type();
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    if (H5Aexists(object, name.c_str()) > 0) H5Adelete(object, name.c_str());
    const Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    const char* text = value.c_str();
    return attribute.valid() && H5Awrite(attribute, type, &text) >= 0;
}

}  // namespace ndg::h5
