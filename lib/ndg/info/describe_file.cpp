// SPDX-License-Identifier: Apache-2.0
#include "ndg/info/describe_file.h"

#include "ndg/core/error.h"
#include "ndg/info/describers.h"
#include "ndg/io/mesh.h"
#include "ndg/motion/keyframes.h"

#include <algorithm>
#include <fstream>
#include <iterator>

namespace ndg {
namespace {

using std::string_literals::operator""s;

/// Whether the name ends in one of these, in either case.
bool ends_in(const FileQuestion& file, std::initializer_list<const char*> extensions)
{
    const std::string extension = lower_extension(file.path);
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

bool is_json(const FileQuestion& file)
{
    const std::size_t first = file.head.find_first_not_of(" \t\r\n");
    return first != std::string::npos && file.head[first] == '{' && ends_in(file, {".json", ".txt"});
}

bool is_character(const FileQuestion& file)
{
    return is_json(file) && file.head.find("\"Skeleton\"") != std::string::npos;
}

/// By the first that matches. Kinds that begin with bytes of their own come before those told by names.
const FileKind kinds[] = {
    {[](const FileQuestion& f) { return f.begins_with("\x89HDF\r\n\x1a\n"); }, describe_h5},
    {[](const FileQuestion& f) { return f.begins_with("ndg-runtime\0"s); }, describe_runtime_model},
    {[](const FileQuestion& f) { return f.begins_with("PK\3\4"); }, describe_zip},
    {[](const FileQuestion& f) { return f.begins_with("\x89PNG\r\n\x1a\n"); }, describe_picture},
    {[](const FileQuestion& f) { return f.begins_with("POINTCACHE2\0"s); }, describe_point_cache},
    {[](const FileQuestion& f) { return ends_in(f, {".html"}); }, describe_page},
    {[](const FileQuestion& f) { return ends_in(f, {".md"}); }, describe_markdown},
    {[](const FileQuestion& f) { return ends_in(f, {".safetensors"}); }, describe_safetensors},
    {[](const FileQuestion& f) { return ends_in(f, {".onnx"}); }, describe_onnx},
    {[](const FileQuestion& f) { return is_mesh_name(f.path); }, describe_mesh},
    {[](const FileQuestion& f) {
         return ends_in(f, {".bvh", ".amc", ".npz"});
     },
     describe_motion},
    {[](const FileQuestion& f) { return ends_in(f, {".asf"}) || is_character(f); }, describe_skeleton},
    {[](const FileQuestion& f) { return f.begins_with("\x1f\x8b") && ends_in(f, {".gz"}); }, describe_makehuman_target},
    {[](const FileQuestion& f) { return is_json(f) && f.head.find("\"Frames\"") != std::string::npos; },
     describe_motion},
    {[](const FileQuestion& f) { return is_keyframe_motion(f.path); }, describe_motion},
    {is_json, describe_json},
    // What should begin with bytes of its own and does not: their readers say what is wrong.
    {[](const FileQuestion& f) { return ends_in(f, {".h5"}); }, describe_h5},
    {[](const FileQuestion& f) { return ends_in(f, {".ndg"}); }, describe_runtime_model},
    {[](const FileQuestion& f) {
         return ends_in(f, {".pt", ".checkpoint"});
     },
     describe_zip},
};

}  // namespace

FileReport describe_file(FileQuestion question)
{
    std::ifstream stream(question.path, std::ios::binary);
    question.head.resize(4096);
    stream.read(question.head.data(), static_cast<std::streamsize>(question.head.size()));
    question.head.resize(stream.gcount());
    const auto kind = std::find_if(std::begin(kinds), std::end(kinds),
                                   [&](const FileKind& candidate) { return candidate.matches(question); });
    require_input(kind != std::end(kinds), "{}: is of no kind that is known here{}", question.path,
                  question.head.empty() ? " (it is empty)" : "");
    FileReport report;
    kind->describe(question, report);
    return report;
}

}  // namespace ndg
