// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cctype>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>
#include <vector>

using namespace ndg;
using ndg::test::TemporaryFolder;

namespace {

/// A tetrahedron with corners that single precision holds exactly.
const Points& corners()
{
    static const Points points = (Points(4, 3) << 0, 0, 0, 1.5, 0, 0, 0, -2.25, 0, 0, 0, 0.125).finished();
    return points;
}

const Triangles& faces()
{
    static const Triangles triangles = (Triangles(4, 3) << 0, 1, 2, 0, 3, 1, 0, 2, 3, 1, 3, 2).finished();
    return triangles;
}

MeshFile read_text(const std::string& name, const std::string& content)
{
    const TemporaryFolder folder;
    write_file(folder.file(name), content);
    return read_mesh(folder.file(name));
}

void check_refused(const std::string& name, const std::string& content, const std::string& message)
{
    const TemporaryFolder folder;
    write_file(folder.file(name), content);
    INFO(content);
    CHECK_THROWS_AS(read_mesh(folder.file(name)), InputError);
    CHECK_THROWS_WITH(read_mesh(folder.file(name)), Catch::StartsWith(folder.file(name) + ": " + message));
}

template <typename T>
void put(std::string& bytes, T value)
{
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

TEST_CASE("round trip through every format")
{
    const TemporaryFolder folder;
    for (const char* name : {"x.obj", "x.ply", "x.off", "x.stl", "X.OBJ"}) {
        INFO(name);
        write_mesh(folder.file(name), corners(), faces());
        const MeshFile mesh = read_mesh(folder.file(name));
        REQUIRE(mesh.vertices.rows() == 4);
        REQUIRE(mesh.triangles.rows() == 4);
        CHECK(mesh.triangle_groups == std::vector<std::string>(4, ""));
        // STL numbers vertices anew: compare corner positions.
        for (Eigen::Index i = 0; i < 4; ++i) {
            for (Eigen::Index k = 0; k < 3; ++k) {
                CHECK(mesh.vertices.row(mesh.triangles(i, k)) == corners().row(faces()(i, k)));
            }
        }
        if (std::strcmp(name, "x.stl") != 0) {
            CHECK(mesh.vertices == corners());
            CHECK(mesh.triangles == faces());
        }
    }
}

TEST_CASE("a point cloud keeps its points")
{
    const TemporaryFolder folder;
    for (const char* name : {"x.obj", "x.ply", "x.off"}) {
        write_mesh(folder.file(name), corners(), Triangles(0, 3));
        CHECK(read_mesh(folder.file(name)).vertices == corners());
        CHECK(read_mesh(folder.file(name)).triangles.rows() == 0);
    }
}

TEST_CASE("what cannot be written is refused and leaves nothing")
{
    const TemporaryFolder folder;
    Points bad = corners();
    bad(2, 1) = std::numeric_limits<double>::infinity();
    CHECK_THROWS_WITH(write_mesh(folder.file("x.ply"), bad, faces()), Catch::Contains("coordinate 1 of vertex 2"));
    Triangles outside = faces();
    outside(3, 0) = 4;
    CHECK_THROWS_WITH(write_mesh(folder.file("x.obj"), corners(), outside), Catch::Contains("vertex 4 of triangle 3"));
    CHECK_THROWS_AS(write_mesh(folder.file("x.fbx"), corners(), faces()), InputError);
    CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("OBJ: groups, polygons, negative indices, all forms of corners, comments and continued lines")
{
    const MeshFile mesh = read_text("x.obj",
                                    "# a square and a triangle\r\n"
                                    "mtllib x.mtl\no thing\n"
                                    "v 0 0 0 1.0\nv +1 0 0\nv 1 1e0 0\nv 0 1 \\\n 0\n"
                                    "vt 0 0\nvn 0 0 1\n"
                                    "g left arm\nusemtl skin\ns off\n"
                                    "f 1/1 2/1/1 3//1 4 # four\n"
                                    "g\nf -4 -3 -1\n"
                                    "g helper-eye\nf 1 2 3");
    CHECK(mesh.vertices == (Points(4, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0).finished());
    CHECK(mesh.triangles == (Triangles(4, 3) << 0, 1, 2, 0, 2, 3, 0, 1, 3, 0, 1, 2).finished());
    CHECK(mesh.triangle_groups == std::vector<std::string>{"left arm", "left arm", "", "helper-eye"});
}

TEST_CASE("OBJ: bad files")
{
    const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\n";
    check_refused("x.obj", square + "f 1 2 4\n", "line 4: vertex 4 is not among the 3 vertices");
    check_refused("x.obj", square + "f 1 2 0\n", "line 4: index 0 in '0', OBJ counts from 1");
    check_refused("x.obj", square + "f 1 2 -4\n", "line 4: vertex -4 reaches back beyond the 3 vertices so far");
    check_refused("x.obj", square + "f 1 2\n", "line 4: a face needs three vertices, got 2");
    check_refused("x.obj", square + "f 1 2 x/1\n", "line 4: 'x' is not an integer");
    check_refused("x.obj", square + "f 1 2 3/1/1/1\n", "line 4: '3/1/1/1' has more than three indices");
    check_refused("x.obj", square + "f 1 2 /1\n", "line 4: '' is not an integer");
    check_refused("x.obj", "v 0 0\n", "line 1: a vertex needs three coordinates, got 2");
    check_refused("x.obj", "v 0 nan 0\n", "line 1: 'nan' is not finite");
    check_refused("x.obj", "v 0 1e999 0\n", "line 1: '1e999' is not finite");
    check_refused("x.obj", "v 0 1,5 0\n", "line 1: '1,5' is not a number");
    check_refused("x.obj", "# nothing\n", "holds no vertices");
    check_refused("x.obj", "", "is empty");
    check_refused("x.xyz", "0 0 0\n", "unknown mesh format '.xyz'");
    CHECK_THROWS_WITH(read_mesh("/nowhere/x.obj"), "/nowhere/x.obj: does not exist");
}

TEST_CASE("PLY: ascii with extra properties, lists and elements")
{
    const MeshFile mesh =
        read_text("x.ply",
                  "ply\r\nformat ascii 1.0\r\ncomment x\r\nelement camera 1\r\nproperty float fov\r\n"
                  "element vertex 4\r\nproperty uchar red\r\nproperty double x\r\nproperty float y\r\n"
                  "property float z\r\nproperty list uchar float uv\r\nelement face 2\r\n"
                  "property int flags\r\nproperty list uchar uint vertex_index\r\nend_header\r\n"
                  "40.5\r\n"
                  "255 0 0 0 0\r\n1 1 0 0 2 0.5 0.5\r\n2 1 1 0 0\r\n3 0 1 -0.5 1 7\r\n"
                  "9 4 0 1 2 3\r\n8 3 3 2 1\r\n");
    CHECK(mesh.vertices == (Points(4, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, -0.5).finished());
    CHECK(mesh.triangles == (Triangles(3, 3) << 0, 1, 2, 0, 2, 3, 3, 2, 1).finished());
}

TEST_CASE("PLY: binary with extra properties of every size")
{
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\n"
        "property short z\nproperty uchar red\nproperty list ushort char extra\nelement face 1\n"
        "property list int ushort vertex_indices\nend_header\n";
    for (int i = 0; i < 3; ++i) {
        put(bytes, static_cast<float>(i));
        put(bytes, 0.1 * i);
        put(bytes, static_cast<std::int16_t>(-i));
        put(bytes, std::uint8_t{200});
        put(bytes, static_cast<std::uint16_t>(i));
        for (int k = 0; k < i; ++k) put(bytes, std::int8_t{-1});
    }
    put(bytes, std::int32_t{3});
    for (const int corner : {2, 0, 1}) put(bytes, static_cast<std::uint16_t>(corner));
    const MeshFile mesh = read_text("x.ply", bytes);
    CHECK(mesh.vertices == (Points(3, 3) << 0, 0, 0, 1, 0.1, -1, 2, 0.2, -2).finished());
    CHECK(mesh.triangles == (Triangles(1, 3) << 2, 0, 1).finished());

    check_refused("x.ply", bytes.substr(0, bytes.size() - 1), "face 0: truncated");
    check_refused("x.ply", bytes.substr(0, bytes.size() - 11), "truncated, 1 elements face do not fit");
}

TEST_CASE("PLY: bad files")
{
    const std::string vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    const std::string face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    const std::string text = "ply\nformat ascii 1.0\n" + vertices + face;
    check_refused("x.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "face 0: vertex 3 is not among the 3 vertices");
    check_refused("x.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "face 0: vertex -1 is not among");
    check_refused("x.ply", text + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "vertex 1: coordinate nan is not finite");
    check_refused("x.ply", text + "0 0 0\n1 0 0\n0 1 0\n3 0 1\n", "face 0: truncated");
    check_refused("x.ply", text + "0 0 0\n1 0 0\n0 1 0\n2 0 1\n", "face 0: a face needs three vertices, got 2");
    check_refused("x.ply", text + "0 0 0\n", "truncated, 3 elements vertex do not fit");
    check_refused("x.ply", "plx\n", "does not begin with \"ply\"");
    check_refused("x.ply", "ply\nformat ascii 1.0\n" + vertices, "truncated, the header has no end");
    check_refused("x.ply", "ply\nformat binary_big_endian 1.0\n", "line 2: PLY format 'binary_big_endian' is not");
    check_refused("x.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n",
                  "line 4: unknown PLY type 'half'");
    check_refused("x.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n",
                  "vertices have no property y");
    check_refused(
        "x.ply",
        "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nproperty float y\n"
        "property float z\nend_header\nabc",
        "truncated, 4000000000 elements vertex do not fit into its 3 bytes");
    std::string binary = "ply\nformat binary_little_endian 1.0\n" + vertices + "end_header\n";
    for (int i = 0; i < 9; ++i) put(binary, i == 4 ? std::numeric_limits<float>::quiet_NaN() : 0.0f);
    check_refused("x.ply", binary, "vertex 1: coordinate nan is not finite");
}

TEST_CASE("OFF: header on one line, comments, colours, polygons")
{
    const MeshFile mesh = read_text("x.off",
                                    "COFF 4 1 0 # counts\n\n# corners\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n1 1 0\n0 1 0\n"
                                    "4 0 1 2 3 255 0 0\n");
    CHECK(mesh.vertices.row(2) == Eigen::RowVector3d(1, 1, 0));
    CHECK(mesh.triangles == (Triangles(2, 3) << 0, 1, 2, 0, 2, 3).finished());

    check_refused("x.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n",
                  "line 6: vertex 3 is not among the 3 vertices");
    check_refused("x.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 inf 0\n3 0 1 2\n", "line 5: 'inf' is not finite");
    check_refused("x.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0.0001\n", "truncated after line 5");
    check_refused("x.off", "OFF\n3000000 1 0\n0 0 0\n", "line 2: truncated, 3000000 vertices");
    check_refused("x.off", "OFF\n-3 1 0\n0 0 0\n", "line 2: truncated, -3 vertices");
    check_refused("x.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n", "line 6: a face of 4 vertices, with 3 words");
    check_refused("x.off", "PLY\n", "line 1: 'PLY' is not an OFF header");
}

TEST_CASE("STL: ascii and binary, equal corners merged")
{
    const std::string ascii =
        "solid two\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\nendloop\nendfacet\n"
        "facet normal 0 0 1\nouter loop\nvertex -0 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid two\n";
    const MeshFile mesh = read_text("x.stl", ascii);
    CHECK(mesh.vertices == (Points(4, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0).finished());
    CHECK(mesh.triangles == (Triangles(2, 3) << 0, 1, 2, 0, 2, 3).finished());

    std::string binary = "solid but binary";
    binary.resize(80, ' ');
    put(binary, std::uint32_t{1});
    for (const float value : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) put(binary, value);
    put(binary, std::uint16_t{0});
    CHECK(read_text("x.stl", binary).triangles == (Triangles(1, 3) << 0, 1, 2).finished());

    check_refused("x.stl", ascii.substr(0, ascii.size() - 14), "truncated, no endsolid before its end at line 15");
    check_refused("x.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0\n", "line 4: a vertex needs three");
    check_refused("x.stl", "solid\nvertex 0 0 nan\n", "line 2: 'nan' is not finite");
    check_refused("x.stl", "solid\nvertex 0 0 1e39\n", "line 2: coordinate inf is not finite");
    check_refused("x.stl", "solid\nvertex 0 0 1\nendloop\n", "line 3: a facet of 1 vertices, expected 3");
    std::string cut = std::string(80, '\0');
    put(cut, std::uint32_t{2});
    cut.append(50, '\0');
    check_refused("x.stl", cut, "truncated, 2 triangles need 184 bytes, the file has 134");
    std::string bad = binary;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(bad.data() + 84 + 12, &nan, 4);
    check_refused("x.stl", bad, "triangle 0: coordinate nan is not finite");
}

namespace {

std::string with_line_ends(const std::string& text, const std::string& end)
{
    std::string result;
    for (const char c : text) result += c == '\n' ? end : std::string(1, c);
    return result;
}

const std::string text_of(const std::string& format)
{
    if (format == "obj") return "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    if (format == "off") return "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    if (format == "ply")
        return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
               "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    return "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
           "endsolid s\n";
}

}  // namespace

TEST_CASE("texts with any line ends, marks, blanks, case and tails are the same mesh")
{
    const Points expected = (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished();
    for (const char* format : {"obj", "off", "ply", "stl"}) {
        const std::string text = text_of(format);
        std::string upper = text;
        for (char& c : upper) c = static_cast<char>(std::toupper(c));
        const std::vector<std::pair<const char*, std::string>> variants = {
            {"CR LF", with_line_ends(text, "\r\n")},
            {"CR", with_line_ends(text, "\r")},
            {"mark", "\xEF\xBB\xBF" + text},
            {"mark and CR", "\xEF\xBB\xBF" + with_line_ends(text, "\r")},
            {"blanks", "  " + text},
            {"end of file", text + "\x1A"},
            {"zeros", text + std::string(7, '\0')},
            {"no last line end", text.substr(0, text.size() - 1)},
            // Keywords of OBJ and PLY's header but for its first word are lower case by their definitions.
            {"case", std::string(format) == "off" || std::string(format) == "stl" ? upper : text}};
        for (const auto& [what, content] : variants) {
            INFO(format << ", " << what);
            const MeshFile mesh = read_text(std::string("x.") + format, content);
            CHECK(mesh.vertices == expected);
            CHECK(mesh.triangles.rows() == 1);
        }
        std::string wide = "\xFF\xFE";
        for (const char c : text) wide += std::string(1, c) + '\0';
        check_refused(std::string("x.") + format, wide, "is text in UTF-16");
        if (std::string(format) == "obj" || std::string(format) == "off")
            check_refused(std::string("x.") + format, wide.substr(2), "is text in UTF-16");
    }
    // Words that are no UTF-8 come from Latin-1.
    const MeshFile mesh = read_text("x.obj",
                                    "# K\xF6rper\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng F\xFC\xDF"
                                    "e\nf 1 2 3\n");
    CHECK(mesh.triangle_groups == std::vector<std::string>{"F\xC3\xBC\xC3\x9F"
                                                           "e"});
}

TEST_CASE("STL: binary files that begin with \"solid\" or have a tail are told from texts by their bytes")
{
    const TemporaryFolder folder;
    write_mesh(folder.file("x.stl"), corners(), faces());
    std::string bytes = read_file(folder.file("x.stl"));
    for (const char* start : {"solid", "  SOLID made by a scanner"}) {
        for (const char* tail : {"", "more bytes"}) {
            INFO(start << ", tail '" << tail << "'");
            std::string changed = bytes + tail;
            changed.replace(0, std::strlen(start), start);
            CHECK(read_text("y.stl", changed).triangles.rows() == 4);
        }
    }
}

TEST_CASE("points that are no numbers are dropped with their triangles where that is asked for")
{
    const TemporaryFolder folder;
    MeshReading reading;
    reading.drop_invalid = true;
    const std::vector<std::pair<const char*, std::string>> files = {
        {"x.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\ng left\nf 1 4 3\n"},
        {"x.off", "OFF\n4 2 0\n0 0 0\n0 inf 0\n0 1 0\n1 1 0\n3 0 1 2\n3 0 3 2\n"},
        {"x.ply",
         "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
         "0 0 0\nnan nan nan\n0 1 0\n1 1 0\n3 0 1 2\n3 0 3 2\n"}};
    for (const auto& [name, content] : files) {
        INFO(name);
        write_file(folder.file(name), content);
        const MeshFile mesh = read_mesh(folder.file(name), reading);
        CHECK(mesh.num_dropped == 1);
        CHECK(mesh.vertices == (Points(3, 3) << 0, 0, 0, 0, 1, 0, 1, 1, 0).finished());
        CHECK(mesh.triangles == (Triangles(1, 3) << 0, 2, 1).finished());
        CHECK(mesh.triangle_groups.size() == 1);
        CHECK_THROWS_AS(read_mesh(folder.file(name)), InputError);
    }
    write_file(folder.file("y.obj"), "v nan 0 0\nv 0 nan 0\n");
    CHECK_THROWS_WITH(read_mesh(folder.file("y.obj"), reading), Catch::Contains("none of its 2 vertices"));
    write_mesh(folder.file("z.stl"), corners(), faces());
    std::string bytes = read_file(folder.file("z.stl"));
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(bytes.data() + 84 + 12, &nan, 4);
    write_file(folder.file("z.stl"), bytes);
    CHECK(read_mesh(folder.file("z.stl"), reading).triangles.rows() == 3);
}
