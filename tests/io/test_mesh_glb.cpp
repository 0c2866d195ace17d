// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cstdint>
#include <cstring>
#include <limits>
#include <vector>

using namespace ndg;

namespace {

template <typename T>
void append(std::string& bytes, T value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// A tetrahedron as binary glTF, written by hand from the specification: one buffer of 4 positions and 12 indices.
struct TinyGlb {
    std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 3};
    std::vector<std::uint16_t> indices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
    int position_count = 4, index_count = 12;
    int index_type = 5123;  // unsigned short
    std::string position_type = "VEC3", extra;

    std::string bytes() const
    {
        std::string binary;
        for (const float value : positions) append(binary, value);
        for (const std::uint16_t value : indices) append(binary, value);
        while (binary.size() % 4 != 0) binary += '\0';
        const std::size_t position_bytes = 4 * positions.size(), index_bytes = 2 * indices.size();
        std::string json = fmt::format(
            R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],)"
            R"("nodes":[{{"mesh":0,"rotation":[0.7071068,0,0,0.7071068]}}],)"
            R"("meshes":[{{"name":"wedge","primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],)"
            R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"{}"}},)"
            R"({{"bufferView":1,"componentType":{},"count":{},"type":"SCALAR"}}],)"
            R"("bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],)"
            R"("buffers":[{{"byteLength":{}}}]{}}})",
            position_count, position_type, index_type, index_count, position_bytes, position_bytes, index_bytes,
            binary.size(), extra);
        while (json.size() % 4 != 0) json += ' ';
        std::string result = "glTF";
        append(result, std::uint32_t(2));
        append(result, std::uint32_t(12 + 8 + json.size() + 8 + binary.size()));
        append(result, std::uint32_t(json.size()));
        result += "JSON" + json;
        append(result, std::uint32_t(binary.size()));
        result += std::string("BIN\0", 4) + binary;
        return result;
    }
};

/// The message of the InputError that reading these bytes gives; it has to name the file.
std::string refusal(const std::string& bytes)
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("part.glb");
    write_file(path, bytes);
    try {
        read_mesh(path);
    } catch (const InputError& error) {
        CHECK_THAT(error.what(), Catch::Matchers::Contains("part.glb"));
        return error.what();
    }
    FAIL("was read");
    return "";
}

/// The same of a tetrahedron with one thing changed.
template <typename Change>
std::string refusal_after(const Change& change)
{
    TinyGlb glb;
    change(glb);
    return refusal(glb.bytes());
}

}  // namespace

TEST_CASE("GLB: vertices and triangles are read in the file's own coordinates")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("Wedge.GLB");
    write_file(path, TinyGlb().bytes());
    const MeshFile mesh = read_mesh(path);
    REQUIRE(mesh.vertices.rows() == 4);
    REQUIRE(mesh.triangles.rows() == 4);
    // The node's rotation about x is left out: the second vertex but one stays on y.
    CHECK(mesh.vertices.row(2).isApprox(Eigen::RowVector3d(0, 2, 0)));
    CHECK(mesh.vertices.row(3).isApprox(Eigen::RowVector3d(0, 0, 3)));
    CHECK(mesh.triangles.row(3) == Eigen::RowVector3i(0, 3, 2));
    CHECK(mesh.triangle_groups == std::vector<std::string>(4, "wedge"));
}

TEST_CASE("GLB: files that are no whole GLB are refused with the file's name")
{
    const std::string good = TinyGlb().bytes();
    CHECK_THAT(refusal("solid nothing that is long enough"), Catch::Matchers::Contains("not a binary glTF"));
    for (const std::size_t length : {4u, 19u, 21u, 60u, 300u}) refusal(good.substr(0, length));
    CHECK_THAT(refusal(good.substr(0, good.size() - 6)), Catch::Matchers::Contains("truncated"));
    std::string bytes = good;  // a header that lies about its chunks
    const std::uint32_t huge = 0xfffffff0u;
    std::memcpy(&bytes[12], &huge, 4);
    refusal(bytes);
}

TEST_CASE("GLB: malformed content is refused with the file's name")
{
    struct Case {
        const char* what;
        void (*spoil)(TinyGlb&);
        const char* message;
    };
    const std::vector<Case> cases = {
        {"more vertices than the buffer", [](TinyGlb& glb) { glb.position_count = 5; }, "5 elements do not fit"},
        {"more indices than the buffer", [](TinyGlb& glb) { glb.index_count = 1200; }, "1200 elements do not fit"},
        {"an index beyond the vertices", [](TinyGlb& glb) { glb.indices[7] = 4; }, "vertex 4 is not among the 4"},
        {"positions that are not points", [](TinyGlb& glb) { glb.position_type = "VEC2"; }, ""},
        {"indices that are not integers", [](TinyGlb& glb) { glb.index_type = 5126; }, "component type 5126"},
        {"not whole triangles", [](TinyGlb& glb) { glb.index_count = 11; }, "11 indices"},
        {"not a number", [](TinyGlb& glb) { glb.positions[4] = std::numeric_limits<float>::quiet_NaN(); }, "vertex 1"},
        {"compressed by an extension",
         [](TinyGlb& glb) {
             glb.extra = R"(,"extensionsUsed":["KHR_draco_mesh_compression"],)"
                         R"("extensionsRequired":["KHR_draco_mesh_compression"])";
         },
         ""},
    };
    for (const Case& entry : cases) {
        INFO(entry.what);
        TinyGlb glb;
        entry.spoil(glb);
        CHECK_THAT(refusal(glb.bytes()), Catch::Matchers::Contains(entry.message));
    }
}
