// SPDX-License-Identifier: Apache-2.0
// The schema against files that break it, and against the tables of docs/formats.md.
#include "ndg/io/schema.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/h5.h"
#include "ndg/io/h5_virtual.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <filesystem>
#include <map>
#include <regex>
#include <sstream>

using namespace ndg;
using ndg::test::TemporaryFolder;

namespace {

std::string trimmed(const std::string& text)
{
    const std::size_t begin = text.find_first_not_of(' ');
    return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

std::vector<std::string> parts_of(const std::string& text, char separator)
{
    std::vector<std::string> parts;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, separator);) parts.push_back(trimmed(part));
    return parts;
}

/// Texts between backticks.
std::vector<std::string> in_backticks(const std::string& text)
{
    std::vector<std::string> words;
    for (std::size_t begin = text.find('`'); begin != std::string::npos;) {
        const std::size_t end = text.find('`', begin + 1);
        words.push_back(text.substr(begin + 1, end - begin - 1));
        begin = text.find('`', end + 1);
    }
    return words;
}

/// The k-th of the entries of a cell, of which one may stand for all.
std::string entry(const std::vector<std::string>& entries, std::size_t k)
{
    if (entries.empty()) return "";
    return entries.size() == 1 ? entries[0] : entries.at(k);
}

/// The page: a schema for each section whose title names a format, and what its tables of sizes explain.
struct Page {
    std::map<std::string, Schema> schemas;
    std::vector<std::string> common, sizes;
};

Page read_page()
{
    Page page;
    std::vector<std::string> formats;
    std::string table;
    std::istringstream lines(read_file(NDG_TEST_SOURCE "/docs/formats.md"));
    for (std::string line; std::getline(lines, line);) {
        if (line.rfind("## ", 0) == 0) {
            formats.clear();
            table = line == "## Sizes used below" ? "sizes" : "";
            std::smatch version;
            if (!std::regex_search(line, version, std::regex(", version (\\d+)"))) continue;
            for (const std::string& format : in_backticks(line)) {
                formats.push_back(format);
                page.schemas[format] = {format, std::stoi(version[1]), {}};
            }
        }
        if (line.rfind("| ", 0) != 0) continue;
        std::vector<std::string> cells = parts_of(line.substr(1), '|');
        if (cells.size() >= 2 && (cells[0] == "dataset" || cells[0] == "attribute" || cells[0] == "option")) {
            table = cells[0];
            continue;
        }
        const std::vector<std::string> names = in_backticks(cells[0]);
        if (table == "sizes") page.sizes.insert(page.sizes.end(), names.begin(), names.end());
        if (table == "attribute") page.common.insert(page.common.end(), names.begin(), names.end());
        if (table != "dataset") continue;
        INFO(line);
        REQUIRE(!formats.empty());
        REQUIRE(cells.size() == 4);
        cells[1].erase(std::remove(cells[1].begin(), cells[1].end(), '`'), cells[1].end());
        const std::vector<std::string> shapes = parts_of(cells[1], ','), types = parts_of(cells[2], ',');
        for (std::size_t k = 0; k < names.size(); ++k)
            for (const std::string& format : formats) {
                const std::size_t only = cells[3].find("` only");
                if (only != std::string::npos && cells[3].find("`" + format + "` only") == std::string::npos) continue;
                page.schemas[format].items.push_back(
                    {names[k], entry(shapes, k), entry(types, k), cells[3].rfind("optional", 0) == 0});
            }
    }
    return page;
}

std::vector<std::string> described(const Schema& schema)
{
    std::vector<std::string> lines;
    for (const SchemaItem& item : schema.items)
        lines.push_back(item.name + " | " + item.shape + " | " + item.type + (item.optional ? " | optional" : ""));
    std::sort(lines.begin(), lines.end());
    return lines;
}

/// A file of gradients as it should be.
std::vector<FileItem> gradient_items()
{
    return {{"@format", "text", {}},
            {"@method", "text", {}},
            {"/gradients/pairs", "int32", {4, 2}},
            {"/gradients/splits", "text", {4}},
            {"/gradients/F", "float32", {4, 100, 9}}};
}

}  // namespace

TEST_CASE("docs/formats.md lists the datasets, shapes, types and versions of the schema, and no others")
{
    const Page page = read_page();
    for (const Schema& schema : schemas()) {
        INFO(schema.format);
        REQUIRE(page.schemas.count(schema.format) == 1);
        CHECK(page.schemas.at(schema.format).version == schema.version);
        CHECK(described(page.schemas.at(schema.format)) == described(schema));
    }
    CHECK(page.schemas.size() == schemas().size());
    std::vector<std::string> common;
    for (const SchemaItem& item : common_attributes()) common.push_back(item.name.substr(1));
    CHECK(page.common == common);
}

TEST_CASE("docs/formats.md explains every size that stands in a shape")
{
    const std::vector<std::string> sizes = read_page().sizes;
    for (const Schema& schema : schemas())
        for (const SchemaItem& item : schema.items) {
            std::string shape = std::regex_replace(item.shape, std::regex(" x | or "), " ");
            for (const std::string& word : parts_of(shape, ' ')) {
                INFO(schema.format << " " << item.name << ": " << item.shape);
                const bool number = word.find_first_not_of("0123456789") == std::string::npos;
                CHECK((number || std::count(sizes.begin(), sizes.end(), word) > 0));
            }
        }
}

TEST_CASE("What does not follow the schema is named")
{
    CHECK(schema_violation("ndg-gradients", gradient_items()).empty());
    std::vector<FileItem> items = gradient_items();
    const auto check_violation = [&](const std::string& message) {
        CHECK(schema_violation("ndg-gradients", items) == message);
        items = gradient_items();
    };
    items[3].shape = {5};
    check_violation("/gradients/splits is 5, the schema of ndg-gradients says n, where n = 4 of /gradients/pairs");
    items[4].shape = {4, 100, 3};
    check_violation("/gradients/F is 4 x 100 x 3, the schema of ndg-gradients says n_slices x N_p x 9");
    items[4].shape = {4, 900};
    check_violation("/gradients/F is 4 x 900, the schema of ndg-gradients says n_slices x N_p x 9");
    items[4].type = "float64";
    check_violation("/gradients/F holds float64, the schema of ndg-gradients says float32");
    items[1].shape = {1};
    check_violation("@method is 1, the schema of ndg-gradients says ");
    items.pop_back();
    check_violation("/gradients/F is missing");
    items.erase(items.begin() + 1);
    check_violation("@method is missing");
    items.push_back({"/gradients/G", "float32", {4, 100, 9}});
    check_violation("/gradients/G is not in the schema of ndg-gradients");
    items.push_back({"@note", "text", {}});
    check_violation("@note is not in the schema of ndg-gradients");
}

TEST_CASE("Multiples, alternatives and words in names are understood")
{
    const auto violation = [](std::size_t rows, const std::string& last, std::size_t inputs, std::size_t basis) {
        std::vector<FileItem> items;
        for (const SchemaItem& item : schemas()[std::size_t(10)].items)
            if (item.name.rfind("/network", 0) != 0 && !item.optional)
                items.push_back({item.name, item.type, std::vector<std::size_t>(item.shape.empty() ? 0 : 1, 60)});
        items.erase(std::find_if(items.begin(), items.end(),
                                 [](const FileItem& item) { return item.name == "/shape_space/components"; }));
        items.push_back({"/shape_space/components", "float64", {rows, 60}});
        items.push_back({"/network/layer_0/weight", "float32", {8, inputs}});
        items.push_back({"/network/layer_0/bias", "float32", {8}});
        items.push_back({"/network/layer_1/weight", "float32", {3, 8}});
        items.push_back({last, "float32", {3}});
        items.push_back({"/network/output_basis", "float32", {3, basis}});
        return schema_violation("ndg-model", items);
    };
    REQUIRE(schemas()[10].format == "ndg-model");
    CHECK(violation(60, "/network/layer_1/bias", 20, 90).empty());
    CHECK_THAT(violation(59, "/network/layer_1/bias", 20, 90), Catch::Contains("says 3 N_v x d, where N_v = 20"));
    CHECK_THAT(violation(60, "/network/layer_0/norm_bias", 20, 90), Catch::Contains("layer_0/norm_bias is 3"));
    CHECK_THAT(violation(60, "/network/layer_1/a/bias", 20, 90), Catch::Contains("not in the schema"));

    std::vector<FileItem> poses = {{"/skeleton/joint_names", "text", {60}},
                                   {"/poses/rotations", "float32", {5, 60, 9}},
                                   {"/poses/root_translations", "float64", {5, 3}},
                                   {"/poses/clip_idx", "int32", {5}},
                                   {"/poses/frame_idx", "int32", {5}},
                                   {"/poses/covering_radius", "float64", {0}},
                                   {"/clips/names", "text", {2}},
                                   {"/clips/frame_rates", "float64", {2}}};
    CHECK(schema_violation("ndg-poses", poses).empty());
    poses[5].shape = {5};
    CHECK(schema_violation("ndg-poses", poses).empty());
    poses[5].shape = {4};
    CHECK_THAT(schema_violation("ndg-poses", poses), Catch::Contains("/poses/covering_radius is 4"));
}

TEST_CASE("A writer refuses unknown formats and to finish a file that differs from its schema")
{
    const TemporaryFolder folder;
    CHECK_THROWS_WITH(H5Writer(folder.file("x.h5"), "ndg-other", 1, {}), "The format \"ndg-other\" has no schema");
    CHECK_THROWS_WITH(H5Writer(folder.file("x.h5"), "ndg-splits", 2, {}), Catch::Contains("has version 1, not 2"));
    CHECK_THROWS_WITH(H5Reader(folder.file("x.h5"), "ndg-splits", 2), Catch::Contains("has version 1, not 2"));
    {
        H5Writer writer(folder.file("x.h5"), "ndg-splits", 1, {});
        writer.write("/splits/train/bodies", std::vector<int>{1, 2}, "");
        writer.write("/splits/train/poses", std::vector<int>{1}, "");
        CHECK_THROWS_WITH(writer.commit(), folder.file("x.h5") + ": /splits/<split>/pairs is missing");
        writer.write("/splits/train/pairs", RowMatrixI(RowMatrixI::Zero(3, 2)), "");
        writer.attribute("note", 1.0);
        CHECK_THROWS_WITH(writer.commit(), Catch::Contains("@note is not in the schema"));
    }
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("Linked slices count as the dataset; a check of a file finds what is missing from it")
{
    const TemporaryFolder folder;
    {
        H5Writer writer(folder.file("part.h5"), "test-part", 1, {});
        writer.write("/gradients/F", {2, 1, 9}, std::vector<float>(18, 0.5f).data(), "");
        writer.commit();
        H5Writer whole(folder.file("whole.h5"), "ndg-gradients", 1, {});
        whole.attribute("method", "FEM");
        whole.write("/gradients/pairs", RowMatrixI(RowMatrixI::Zero(2, 2)), "");
        whole.write("/gradients/splits", std::vector<std::string>{"train", "test"}, "");
        whole.link("/gradients/F", {2, 1, 9}, {{"part.h5", 2, {1, 0}, {0, 1}}}, "");
        whole.commit();
    }
    CHECK(H5Reader(folder.file("whole.h5"), "ndg-gradients", 1).read_slice("/gradients/F", 1)[8] == 0.5f);
    CHECK_NOTHROW(check_h5(folder.file("whole.h5")));
    std::string bytes = read_file(folder.file("whole.h5"));
    for (std::size_t at = bytes.find("splits"); at != std::string::npos; at = bytes.find("splits", at + 1))
        bytes.replace(at, 6, "splitz");
    write_file(folder.file("whole.h5"), bytes);
    CHECK_THROWS_WITH(check_h5(folder.file("whole.h5")), Catch::Contains("/gradients/splits is missing"));
}
