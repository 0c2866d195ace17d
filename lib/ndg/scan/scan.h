// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// A scan of a person: a triangle mesh, or a point cloud when it has no triangles. Metres, y up.
struct Scan {
    Points vertices;      ///< N x 3
    Triangles triangles;  ///< T x 3, may be empty
    Points normals;       ///< N x 3 unit normals, outward; zero rows where unknown
};

/// How a scan file is to be understood.
struct ScanOptions {
    std::string unit = "auto";  ///< "auto" or one of scan_units()
    std::string up = "auto";    ///< "auto", "x", "y", "z", "-x", "-y" or "-z"
    int max_points = 60000;     ///< scans with more are thinned to about that many
};

/// "m", "dm", "cm", "mm", "in", "ft".
const std::vector<std::string>& scan_units();

/// Throws InputError for an unknown unit.
double metres_of_unit(const std::string& unit);

/// Points of a scan as they are registered: metres, but axes as in the file.
struct ScanPoints {
    Points points;         ///< N x 3
    Points normals;        ///< N x 3 unit normals, outward
    double spacing = 0.0;  ///< median distance of a point to its nearest neighbour, m
    std::string unit;      ///< of the file
    double metres_per_unit = 1.0;
    bool unit_guessed = false;
    std::vector<std::string> up_axes;  ///< those that may be up, likeliest first; one where it was given
    std::size_t file_points = 0;       ///< vertices in the file
    bool is_cloud = false;             ///< the file has no triangles
};

/// Reads OBJ, PLY, OFF, STL or GLB, mesh or point cloud. The unit is guessed from the largest extent, which for a
/// standing adult lies between 1.2 and 2.35 m in one unit only; an axis may be up if the extent along it is at least
/// two thirds of the largest. Vertices that belong to no triangle of a mesh are left out. Throws InputError naming file
/// and value for a file that cannot be read, fewer than 500 points, or a size that is no standing adult's.
ScanPoints read_scan(const std::string& path, const ScanOptions& options);
/// The same for a mesh or cloud in memory; `name` starts the messages.
ScanPoints prepare_scan(const std::string& name, const Eigen::Ref<const Points>& vertices,
                        const Eigen::Ref<const Triangles>& triangles, const ScanOptions& options);

/// Rotation that turns the axis `up` ("x"... "-z") of a file to +y.
Eigen::Matrix3d rotation_to_y_up(const std::string& up);

}  // namespace ndg
