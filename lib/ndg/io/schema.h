// SPDX-License-Identifier: Apache-2.0
// What stands in every kind of file of ours. H5Writer, H5Reader and check_h5 hold files to this list, and a test holds
// the tables of docs/formats.md to it, so that neither code nor page can drift. A new dataset is a row in schema.cpp
// and one in the page.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace ndg {

/// A dataset ("/skin/vertices") or an attribute of the root ("@method") that files of a format hold.
struct SchemaItem {
    /// "<word>" in it stands for any text without a slash: "/splits/<split>/pairs".
    std::string name;
    /// Extents along the axes, "N_s x 3": numbers, sizes, or multiples of sizes ("9 N_p"). A size has one value in a
    /// file; where its name holds the word of `name` ("n_<split>") one for each match. " or " parts alternatives; the
    /// first that fits counts. "": a single value.
    std::string shape;
    std::string type;  ///< "float32", "float64", "int32" or "text"
    bool optional = false;
};

/// One format and all that its files may hold beyond common_attributes().
struct Schema {
    std::string format;
    int version = 0;
    std::vector<SchemaItem> items;
};

const std::vector<Schema>& schemas();
/// Attributes that stand in the root of every file.
const std::vector<SchemaItem>& common_attributes();

/// A dataset or an attribute as it stands in a file; names as in SchemaItem.
struct FileItem {
    std::string name, type;
    std::vector<std::size_t> shape;
};

/// Throws Error unless `format` is in schemas() with this version. Names that begin with "test-" are free.
void check_format(const std::string& format, int version);
/// The first way in which `items` differ from the format's schema: an item that is not in it, of another type or shape,
/// or a required one that is missing. "" if there is none, and for a format without a schema.
std::string schema_violation(const std::string& format, const std::vector<FileItem>& items);
/// Throws InputError naming the first such way of an HDF5 file. Reads no data; check_h5 (h5.h) does.
void check_h5_schema(const std::string& path);

}  // namespace ndg
