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
    std::string nodes = R"({"mesh":0,"rotation":[0.7071068,0,0,0.7071068]})";
    std::string scenes = R"("scene":0,"scenes":[{"nodes":[0]}],)";

    std::string bytes() const
    {
        std::string binary;
        for (const float value : positions) append(binary, value);
        for (const std::uint16_t value : indices) append(binary, value);
        while (binary.size() % 4 != 0) binary += '\0';
        const std::size_t position_bytes = 4 * positions.size(), index_bytes = 2 * indices.size();
        std::string json = fmt::format(
            R"({{"asset":{{"version":"2.0"}},{}"nodes":[{}],)"
            R"("meshes":[{{"name":"wedge","primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],)"
            R"("accessors":[{{"bufferView":0,"componentType":5126,"count":{},"type":"{}"}},)"
            R"({{"bufferView":1,"componentType":{},"count":{},"type":"SCALAR"}}],)"
            R"("bufferViews":[{{"buffer":0,"byteLength":{}}},{{"buffer":0,"byteOffset":{},"byteLength":{}}}],)"
            R"("buffers":[{{"byteLength":{}}}]{}}})",
            scenes, nodes, position_count, position_type, index_type, index_count, position_bytes, position_bytes,
            index_bytes, binary.size(), extra);
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

TEST_CASE("GLB: meshes as they are stored")
{
    const test::TemporaryFolder folder;
    const std::string path = folder.file("Wedge.GLB");
    write_file(path, TinyGlb().bytes());
    MeshReading stored;
    stored.placed = false;
    const MeshFile mesh = read_mesh(path, stored);
    REQUIRE(mesh.vertices.rows() == 4);
    REQUIRE(mesh.triangles.rows() == 4);
    // The node's rotation about x is left out: the second vertex but one stays on y.
    CHECK(mesh.vertices.row(2).isApprox(Eigen::RowVector3d(0, 2, 0)));
    CHECK(mesh.vertices.row(3).isApprox(Eigen::RowVector3d(0, 0, 3)));
    CHECK(mesh.triangles.row(3) == Eigen::RowVector3i(0, 3, 2));
    CHECK(mesh.triangle_groups == std::vector<std::string>(4, "wedge"));
}

namespace {

MeshFile read_with_nodes(const std::string& nodes, const std::string& scenes = TinyGlb().scenes)
{
    const test::TemporaryFolder folder;
    TinyGlb glb;
    glb.nodes = nodes;
    glb.scenes = scenes;
    write_file(folder.file("x.glb"), glb.bytes());
    return read_mesh(folder.file("x.glb"));
}

double volume(const MeshFile& mesh)
{
    double six_times = 0;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        Eigen::Matrix3d corners;
        for (int k = 0; k < 3; ++k) corners.row(k) = mesh.vertices.row(mesh.triangles(t, k));
        six_times += corners.determinant();
    }
    return six_times / 6;
}

}  // namespace

TEST_CASE("GLB: meshes lie where the nodes of the default scene place them")
{
    SECTION("turned about x by a quarter")
    {
        const MeshFile mesh = read_with_nodes(TinyGlb().nodes);
        CHECK(mesh.vertices.row(2).isApprox(Eigen::RowVector3d(0, 0, 2), 1e-6));
        CHECK(mesh.vertices.row(3).isApprox(Eigen::RowVector3d(0, -3, 0), 1e-6));
        CHECK(volume(mesh) == Approx(1.0));
    }
    SECTION("moved, turned and scaled by a chain of nodes, in that order")
    {
        const MeshFile mesh =
            read_with_nodes(R"({"children":[1],"translation":[10,0,0],"rotation":[0,0,0.7071068,0.7071068]},)"
                            R"({"mesh":0,"translation":[0,1,0],"scale":[2,3,4]})");
        // (1, 0, 0) -> (2, 1, 0) -> a quarter about z (-1, 2, 0) -> (9, 2, 0)
        CHECK(mesh.vertices.row(1).isApprox(Eigen::RowVector3d(9, 2, 0), 1e-6));
        CHECK(volume(mesh) == Approx(24.0));
    }
    SECTION("a matrix, column by column")
    {
        const MeshFile mesh = read_with_nodes(R"({"mesh":0,"matrix":[0,1,0,0, -1,0,0,0, 0,0,1,0, 5,6,7,1]})");
        CHECK(mesh.vertices.row(2).isApprox(Eigen::RowVector3d(3, 6, 7), 1e-6));
    }
    SECTION("left and right exchanged: triangles still face outward")
    {
        const MeshFile mesh = read_with_nodes(R"({"mesh":0,"scale":[-1,1,1]})");
        CHECK(mesh.vertices.row(1).isApprox(Eigen::RowVector3d(-1, 0, 0)));
        CHECK(volume(mesh) == Approx(1.0));
    }
    SECTION("instances are as many meshes; what the scene does not show is not there")
    {
        const std::string nodes = R"({"mesh":0},{"mesh":0,"translation":[5,0,0]},{"mesh":0,"translation":[9,0,0]})";
        const MeshFile two = read_with_nodes(nodes, R"("scene":1,"scenes":[{"nodes":[2]},{"nodes":[0,1]}],)");
        CHECK(two.vertices.rows() == 8);
        CHECK(two.vertices.col(0).maxCoeff() == Approx(6.0));
        CHECK(read_with_nodes(nodes, "").vertices.rows() == 12);  // without scenes: all
    }
}

TEST_CASE("GLB: a mesh on a skeleton stands where its joints do, not where its node is")
{
    // A joint at (0, 4, 0) under an armature that scales by a hundredth; bound at the origin of a mesh in centimetres.
    const test::TemporaryFolder folder;
    TinyGlb glb;
    // Joints and weights of four vertices, then a bind matrix, behind the indices (24 bytes of indices, 48 of
    // positions).
    std::vector<float> tail;
    for (int i = 0; i < 4; ++i) tail.insert(tail.end(), {1, 0, 0, 0});             // weights
    tail.insert(tail.end(), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, -1, -1, 1});  // joint_from_mesh
    for (int i = 0; i < 8; ++i) tail.push_back(0);                                 // joints, 4 x 4 ushorts
    glb.positions.insert(glb.positions.end(), tail.begin(), tail.end());
    glb.nodes = R"({"children":[1],"scale":[0.01,0.01,0.01]},{"translation":[0,400,0]},)"
                R"({"mesh":0,"skin":0,"translation":[77,77,77]})";
    glb.scenes = R"("scene":0,"scenes":[{"nodes":[0,2]}],"skins":[{"joints":[1],"inverseBindMatrices":4}],)";
    std::string bytes = glb.bytes();
    // Attributes and accessors of the skin are written into the JSON by hand.
    const auto replace = [&bytes](const std::string& old, const std::string& with) {
        const std::size_t at = bytes.find(old);
        REQUIRE(at != std::string::npos);
        bytes.replace(at, old.size(), with);
    };
    replace(R"({"POSITION":0})", R"({"POSITION":0,"WEIGHTS_0":2,"JOINTS_0":3})");
    replace(R"("bufferViews":)",
            R"(,{"bufferView":0,"byteOffset":48,"componentType":5126,"count":4,"type":"VEC4"},)"
            R"({"bufferView":0,"byteOffset":176,"componentType":5123,"count":4,"type":"VEC4"},)"
            R"({"bufferView":0,"byteOffset":112,"componentType":5126,"count":1,"type":"MAT4"}],"bufferViews":)");
    replace("],,{", ",{");
    std::uint32_t json_length = 0;
    std::memcpy(&json_length, &bytes[12], 4);
    const std::size_t binary = bytes.find(std::string("BIN\0", 4)) - 4;
    std::string json = bytes.substr(20, binary - 20);
    while (json.size() % 4 != 0) json += ' ';
    std::string whole = bytes.substr(0, 8);
    append(whole, std::uint32_t(20 + json.size() + bytes.size() - binary));
    append(whole, std::uint32_t(json.size()));
    whole += "JSON" + json + bytes.substr(binary);
    write_file(folder.file("x.glb"), whole);
    const MeshFile mesh = read_mesh(folder.file("x.glb"));
    // (1, 0, 0) -> bound (0, -1, -1) -> joint (0, 399, -1) -> armature
    CHECK(mesh.vertices.row(1).isApprox(Eigen::RowVector3d(0, 3.99, -0.01), 1e-6));
    CHECK(mesh.vertices.row(0).isApprox(Eigen::RowVector3d(-0.01, 3.99, -0.01), 1e-6));
}

TEST_CASE("GLB: scenes that cannot be are refused")
{
    const auto refused = [](const std::string& nodes, const std::string& message) {
        CHECK_THROWS_WITH(read_with_nodes(nodes), Catch::Contains(message));
    };
    refused(R"({"mesh":0,"skin":0})", "skin 0 is not among the 0");
    refused(R"({"mesh":3})", "mesh 3 is not among the 1");
    refused(R"({"children":[1]},{"children":[0],"mesh":0})", "own ancestors");
    refused(R"({"mesh":0,"children":[7]})", "node 7 is not among the 1");
    refused(R"({"children":[2]},{"children":[2]},{"mesh":0})", "two parents");
    refused(R"({"name":"empty"})", "shows none of the 1 meshes");
    CHECK_THROWS_WITH(read_with_nodes(R"({"mesh":0})", R"("scene":4,"scenes":[{"nodes":[0]}],)"),
                      Catch::Contains("scene 4 is not among the 1"));
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
