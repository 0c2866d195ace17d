// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/h5.h"
#include "support/support.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

using namespace ndg;
using ndg::test::TemporaryFolder;

namespace {

const double not_a_number = std::numeric_limits<double>::quiet_NaN();

Provenance example_provenance()
{
    Provenance provenance;
    provenance.tool = "make-template";
    provenance.config_json = R"({"make-template":{"seed":3}})";
    provenance.inputs = {{"skin.obj", "abc123", "CC0: base mesh"}};
    provenance.licences = "CC-BY: anatomy";
    return provenance;
}

RowMatrix example_matrix()
{
    RowMatrix matrix(3, 2);
    matrix << 1, 2, 3, 4, 5, 6.5;
    return matrix;
}

/// One dataset of each kind.
void write_example(const std::string& path)
{
    H5Writer writer(path, "test-file", 2, example_provenance());
    writer.write("/group/reals", example_matrix(), "three points");
    writer.write("/group/exact", example_matrix() / 3.0, "thirds", Storage::float64);
    RowMatrixI indices(2, 3);
    indices << 0, 1, 2, 3, 4, 5;
    writer.write("/indices", indices, "two triangles");
    writer.write("/values", std::vector<double>{0.1, -2.0}, "doubles");
    writer.write("/counts", std::vector<int>{7, -1, 9}, "integers");
    writer.write("/names", std::vector<std::string>{"left_foot", "", "Fuß"}, "texts");
    std::vector<float> cube(24);
    std::iota(cube.begin(), cube.end(), 0.0f);
    writer.write("/cube", {2, 3, 4}, cube.data(), "three axes");
    writer.create("/samples", {3, 4, 2}, "slices");
    for (std::size_t i : {2, 0, 1}) {
        const std::vector<float> slice(8, static_cast<float>(i) + 0.5f);
        writer.write_slice("/samples", i, slice.data());
    }
    writer.write("/none", RowMatrix(0, 3), "no rows");
    writer.attribute("note", "hand-made");
    writer.attribute("thickness", 0.25);
    writer.commit();
}

}  // namespace

TEST_CASE("what is written is read back")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("x.h5");
    write_example(path);
    const H5Reader reader(path, "test-file", 2);
    CHECK(reader.path() == path);
    CHECK(reader.read_matrix("/group/reals", 3, 2) == example_matrix());
    CHECK(reader.read_matrix("/group/exact") == example_matrix() / 3.0);
    CHECK(reader.read_int_matrix("/indices", -1, 3, 0, 5)(1, 2) == 5);
    CHECK(reader.read_doubles("/values") == std::vector<double>{0.1, -2.0});
    CHECK(reader.read_ints("/counts", 3, -1, 9) == std::vector<int>{7, -1, 9});
    CHECK(reader.read_strings("/names", 3) == std::vector<std::string>{"left_foot", "", "Fuß"});
    CHECK(reader.shape("/cube") == std::vector<std::size_t>{2, 3, 4});
    CHECK(reader.read_slice("/cube", 1)[11] == 23.0f);
    CHECK(reader.read_slice("/cube", 1).size() == 12);
    for (std::size_t i = 0; i < 3; ++i) {
        CHECK(reader.read_slice("/samples", i) == std::vector<float>(8, static_cast<float>(i) + 0.5f));
    }
    CHECK(reader.read_matrix("/none", 0, 3).rows() == 0);
    CHECK(reader.has("/group/reals"));
    CHECK_FALSE(reader.has("/group/other"));
    CHECK_FALSE(reader.has("/nogroup/other"));
    CHECK(reader.attribute("note") == "hand-made");
    CHECK(reader.attribute_double("thickness") == 0.25);
    CHECK_NOTHROW(check_h5(path));
}

TEST_CASE("blocks of larger matrices are stored row by row")
{
    const TemporaryFolder folder;
    RowMatrix large(4, 5);
    std::iota(large.data(), large.data() + large.size(), 0.0);
    {
        H5Writer writer(folder.file("x.h5"), "test-file", 1, {});
        writer.write("/block", large.block(1, 1, 2, 3), "a block");
        writer.commit();
    }
    CHECK(H5Reader(folder.file("x.h5"), "test-file", 1).read_matrix("/block") == large.block(1, 1, 2, 3));
}

TEST_CASE("datasets of many chunks")
{
    const TemporaryFolder folder;
    RowMatrix large(70000, 3);
    for (Eigen::Index i = 0; i < large.rows(); ++i) large.row(i) << 0.5 * static_cast<double>(i), 1, -2;
    std::vector<int> many(100000);
    std::iota(many.begin(), many.end(), 0);
    {
        H5Writer writer(folder.file("x.h5"), "test-file", 1, {});
        writer.write("/large", large, "several chunks");
        writer.write("/many", many, "a long list");
        writer.commit();
    }
    const H5Reader reader(folder.file("x.h5"), "test-file", 1);
    CHECK(reader.read_matrix("/large") == large);
    CHECK(reader.read_ints("/many", 100000, 0, 99999) == many);
    CHECK(reader.read_slice("/large", 69999) == std::vector<float>{34999.5f, 1, -2});
}

TEST_CASE("equal content gives equal bytes")
{
    const TemporaryFolder folder;
    write_example(folder.file("a.h5"));
    write_example(folder.file("b.h5"));
    CHECK(read_file(folder.file("a.h5")) == read_file(folder.file("b.h5")));
}

TEST_CASE("root attributes say where the file came from; licences of inputs are carried over")
{
    const TemporaryFolder folder;
    write_example(folder.file("first.h5"));
    Provenance provenance;
    provenance.tool = "sample-bodies";
    provenance.inputs = {{folder.file("first.h5"), "00", ""}, {folder.file("missing.csv"), "11", ""}};
    provenance.licences = "CC0: base mesh\nODbL: measurements";
    {
        H5Writer writer(folder.file("second.h5"), "test-file", 1, provenance);
        writer.commit();
    }
    const H5Reader reader(folder.file("second.h5"), "test-file", 1);
    CHECK(reader.attribute("licences") == "CC0: base mesh\nODbL: measurements\nCC-BY: anatomy");
    CHECK(reader.attribute("units") == "m");
    CHECK(reader.attribute("up_axis") == "y");
    const auto created_by = nlohmann::json::parse(reader.attribute("created_by"));
    CHECK(created_by["tool"] == "sample-bodies");
    CHECK(created_by["version"] == project_version());
    CHECK(created_by["commit"] == project_commit());
    const auto inputs = nlohmann::json::parse(reader.attribute("inputs"));
    CHECK(inputs[0]["path"] == folder.file("first.h5"));
    CHECK(inputs[1]["sha256"] == "11");
}

TEST_CASE("without commit nothing is left behind and the old file stays")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("x.h5");
    write_example(path);
    const std::string before = read_file(path);
    {
        H5Writer writer(path, "test-file", 2, {});
        writer.write("/values", std::vector<double>{1}, "new");
        CHECK(std::filesystem::exists(temporary_name(path)));
    }
    CHECK_FALSE(std::filesystem::exists(temporary_name(path)));
    CHECK(read_file(path) == before);
}

TEST_CASE("the writer refuses what would make a bad file")
{
    const TemporaryFolder folder;
    H5Writer writer(folder.file("x.h5"), "test-file", 1, {});
    RowMatrix matrix = example_matrix();
    matrix(2, 1) = not_a_number;
    CHECK_THROWS_WITH(writer.write("/m", matrix, ""), Catch::Contains("x.h5: dataset /m is not finite at (2, 1): nan"));
    matrix(2, 1) = 1e300;
    CHECK_THROWS_WITH(writer.write("/m", matrix, ""), Catch::Contains("(2, 1): inf"));
    CHECK_NOTHROW(writer.write("/m", matrix, "", Storage::float64));
    CHECK_THROWS_WITH(writer.write("/m", matrix, "", Storage::float64), Catch::Contains("/m"));
    CHECK_THROWS_WITH(writer.write("m", example_matrix(), ""), Catch::Contains("must start with /"));
    writer.create("/s", {2, 2}, "");
    const std::vector<float> good = {1, 2}, bad = {1, static_cast<float>(not_a_number)};
    CHECK_THROWS_WITH(writer.write_slice("/s", 1, bad.data()), Catch::Contains("/s is not finite at (1, 1)"));
    CHECK_THROWS_WITH(writer.write_slice("/s", 2, good.data()), Catch::Contains("has 2 slices, cannot write slice 2"));
    CHECK_THROWS_WITH(writer.write_slice("/t", 0, good.data()), Catch::Contains("/t was not created"));
    writer.write_slice("/s", 1, good.data());
    CHECK_THROWS_WITH(writer.commit(), Catch::Contains("slice 0 of dataset /s was never written"));
    writer.write_slice("/s", 0, good.data());
    CHECK_NOTHROW(writer.commit());
    CHECK_THROWS_AS(H5Writer(folder.file("no/such/x.h5"), "test-file", 1, {}), Error);
}

TEST_CASE("the reader names file, dataset and what is wrong")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("x.h5");
    write_example(path);
    const auto opening = [](const std::string& file, const std::string& format, int version) {
        H5Reader reader(file, format, version);
    };
    CHECK_THROWS_WITH(opening(path, "ndg-bodies", 1), path + ": format is \"test-file\", expected \"ndg-bodies\"");
    CHECK_THROWS_WITH(opening(path, "test-file", 1), path + ": format_version is 2, this program reads 1");
    CHECK_THROWS_WITH(opening(folder.file("no.h5"), "test-file", 1), folder.file("no.h5") + ": does not exist");
    CHECK_THROWS_WITH(opening(folder.path(), "test-file", 1), Catch::Contains("is a folder"));
    write_file(folder.file("text.h5"), "hello");
    CHECK_THROWS_WITH(opening(folder.file("text.h5"), "test-file", 1), Catch::Contains("is not an HDF5 file"));

    const H5Reader reader(path, "test-file", 2);
    CHECK_THROWS_WITH(reader.read_matrix("/nothing"), path + ": dataset /nothing is missing");
    CHECK_THROWS_WITH(reader.read_matrix("/group"), Catch::Contains("cannot open dataset /group"));
    CHECK_THROWS_WITH(reader.read_matrix("/group/reals", 4, 2),
                      path + ": dataset /group/reals is 3 x 2, expected 4 x 2");
    CHECK_THROWS_WITH(reader.read_matrix("/group/reals", -1, 3), Catch::Contains("is 3 x 2, expected N x 3"));
    CHECK_THROWS_WITH(reader.read_matrix("/values"), Catch::Contains("/values is 2, expected N x N"));
    CHECK_THROWS_WITH(reader.read_matrix("/indices"), Catch::Contains("/indices holds int32, expected real numbers"));
    CHECK_THROWS_WITH(reader.read_ints("/values", -1, 0, 1), Catch::Contains("holds float64, expected integers"));
    CHECK_THROWS_WITH(reader.read_doubles("/names"), Catch::Contains("holds text, expected real numbers"));
    CHECK_THROWS_WITH(reader.read_strings("/values"), Catch::Contains("expected text"));
    CHECK_THROWS_WITH(reader.read_int_matrix("/indices", 2, 3, 0, 4),
                      path + ": dataset /indices at (1, 2) is 5, expected 0 to 4");
    CHECK_THROWS_WITH(reader.read_ints("/counts", 3, 0, 9), Catch::Contains("/counts at 1 is -1, expected 0 to 9"));
    CHECK_THROWS_WITH(reader.read_slice("/samples", 3), Catch::Contains("/samples has 3 slices, slice 3"));
    CHECK_THROWS_WITH(reader.attribute("other"), Catch::Contains("attribute other is missing"));
    CHECK_THROWS_WITH(reader.attribute("thickness"), Catch::Contains("attribute thickness is missing or no text"));
    CHECK_THROWS_WITH(reader.attribute_double("note"), Catch::Contains("attribute note is not a single number"));
    CHECK_THROWS_AS(reader.read_matrix("/nothing"), InputError);
}

TEST_CASE("a truncated file is an InputError wherever it is cut")
{
    const TemporaryFolder folder;
    write_example(folder.file("x.h5"));
    const std::string whole = read_file(folder.file("x.h5"));
    for (const double part : {0.0, 0.001, 0.1, 0.5, 0.9, 0.999}) {
        const auto size = static_cast<std::size_t>(part * static_cast<double>(whole.size()));
        write_file(folder.file("cut.h5"), whole.substr(0, size));
        CHECK_THROWS_AS(check_h5(folder.file("cut.h5")), InputError);
        CHECK_THROWS_AS(list_h5(folder.file("cut.h5")), InputError);
        CHECK_THROWS_AS(H5Reader(folder.file("cut.h5"), "test-file", 2), InputError);
    }
}

TEST_CASE("a flipped bit in bulk data is found by its checksum")
{
    const TemporaryFolder folder;
    RowMatrix matrix(2000, 3);
    for (Eigen::Index i = 0; i < matrix.size(); ++i) matrix.data()[i] = std::sin(static_cast<double>(i));
    {
        H5Writer writer(folder.file("x.h5"), "test-file", 1, {});
        writer.write("/bulk", matrix, "");
        writer.commit();
    }
    std::string bytes = read_file(folder.file("x.h5"));
    bytes[bytes.size() - bytes.size() / 4] ^= 1;  // the one chunk fills most of the file
    write_file(folder.file("x.h5"), bytes);
    CHECK_THROWS_WITH(check_h5(folder.file("x.h5")), Catch::Contains("cannot read dataset /bulk"));
    CHECK_THROWS_WITH(H5Reader(folder.file("x.h5"), "test-file", 1).read_matrix("/bulk"),
                      Catch::Contains("cannot read dataset /bulk, truncated or damaged"));
}

TEST_CASE("listing names datasets with type, shape and description, and attributes")
{
    const TemporaryFolder folder;
    write_example(folder.file("x.h5"));
    const H5Listing listing = list_h5(folder.file("x.h5"));
    std::vector<std::string> paths;
    for (const auto& dataset : listing.datasets) paths.push_back(dataset.path);
    CHECK(paths == std::vector<std::string>{"/counts", "/cube", "/group/exact", "/group/reals", "/indices", "/names",
                                            "/none", "/samples", "/values"});
    CHECK(listing.datasets[3].type == "float32");
    CHECK(listing.datasets[3].shape == std::vector<std::size_t>{3, 2});
    CHECK(listing.datasets[3].description == "three points");
    CHECK(listing.datasets[5].type == "text");
    const std::vector<std::pair<std::string, std::string>> wanted = {
        {"format", "test-file"}, {"format_version", "2"}, {"note", "hand-made"}, {"thickness", "0.25"}};
    for (const auto& entry : wanted) {
        CHECK(std::count(listing.attributes.begin(), listing.attributes.end(), entry) == 1);
    }
}
