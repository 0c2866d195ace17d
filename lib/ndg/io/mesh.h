// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/colour.h"
#include "ndg/core/types.h"

#include <map>
#include <string>
#include <vector>

namespace ndg {

/// A surface as read from or written to a file, in the file's own unit and axes. Polygons are split into fans.
struct MeshFile {
    Points vertices;      ///< N x 3
    Triangles triangles;  ///< T x 3, empty for a point cloud
    /// One entry a triangle: the OBJ group it belongs to ("" elsewhere).
    std::vector<std::string> triangle_groups;
    /// Points that were no numbers and are left out, with the triangles at them (MeshReading::drop_invalid).
    Eigen::Index num_dropped = 0;

    // Written where the format has a place for them; not read.
    VertexColours vertex_colours;                           ///< N x 3 or empty; PLY
    std::map<std::string, Eigen::VectorXf> vertex_scalars;  ///< N each, by the name of the property; PLY
    std::string comment;                                    ///< any number of lines; OBJ, OFF and PLY
};

/// Extension of a file name with its dot, in lower case.
std::string lower_extension(const std::string& path);

/// Whether the name ends in .obj, .ply, .off, .stl or .glb, in either case.
bool is_mesh_name(const std::string& path);

struct MeshReading {
    /// GLB: what the default scene shows, meshes where its nodes place them, at rest on their skeletons. Otherwise all
    /// meshes in the coordinates they are stored in.
    bool placed = true;
    /// Points that are no numbers, as depth cameras give them, are left out and counted instead of refused.
    bool drop_invalid = false;
};

/// OBJ, PLY (ascii, binary little endian), OFF, STL (ascii, binary; equal corners merged), GLB (binary glTF 2.0, groups
/// are mesh names, morph targets left out), by extension. Texts may have any line ends and case of keywords.
/// Throws InputError naming file, line or element and value: missing, truncated, index out of range, non-finite.
MeshFile read_mesh(const std::string& path, const MeshReading& reading = {});

/// OBJ, PLY (binary), OFF, STL (binary), by extension; coordinates in single precision. Writes to a temporary name and
/// renames. Groups may be empty. Throws Error for values that are not finite, indices out of range or other numbers of
/// colours, scalars and groups than of vertices and triangles, InputError for an unknown extension.
void write_mesh(const std::string& path, const MeshFile& mesh);
void write_mesh(const std::string& path, const Eigen::Ref<const Points>& vertices,
                const Eigen::Ref<const Triangles>& triangles);

}  // namespace ndg
