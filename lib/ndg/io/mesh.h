// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// A surface as read from or written to a file, in the file's own unit and axes. Polygons are split into fans.
struct MeshFile {
    Points vertices;      ///< N x 3
    Triangles triangles;  ///< T x 3, empty for a point cloud
    /// One entry a triangle: the OBJ group it belongs to ("" elsewhere).
    std::vector<std::string> triangle_groups;
};

/// Whether the name ends in .obj, .ply, .off, .stl or .glb, in either case.
bool is_mesh_name(const std::string& path);

/// OBJ, PLY (ascii, binary little endian), OFF, STL (ascii, binary; equal corners merged), GLB (binary glTF 2.0: the
/// triangles of all meshes in their own coordinates, node transforms left out; groups are mesh names), by extension.
/// Throws InputError naming file, line or element and value: missing, truncated, index out of range, non-finite.
MeshFile read_mesh(const std::string& path);

/// OBJ, PLY (binary), OFF, STL (binary), by extension; coordinates in single precision. Writes to a temporary name and
/// renames.
void write_mesh(const std::string& path, const Eigen::Ref<const Points>& vertices,
                const Eigen::Ref<const Triangles>& triangles);

}  // namespace ndg
