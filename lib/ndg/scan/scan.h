// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/axis.h"
#include "ndg/core/options.h"
#include "ndg/core/types.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// A scan of a person: a triangle mesh, or a point cloud when it has no triangles. Metres, y up.
struct Scan {
    Points vertices;      ///< N x 3
    Triangles triangles;  ///< T x 3, may be empty
    Points normals;       ///< N x 3 unit normals, outward; zero rows where unknown
};

enum class LengthUnit { metre, decimetre, centimetre, millimetre, inch, foot };
template <>
inline constexpr EnumName<LengthUnit> enum_table<LengthUnit>[] = {
    {LengthUnit::metre, "m"},       {LengthUnit::decimetre, "dm"}, {LengthUnit::centimetre, "cm"},
    {LengthUnit::millimetre, "mm"}, {LengthUnit::inch, "in"},      {LengthUnit::foot, "ft"}};
double metres_of_unit(LengthUnit unit);

/// How a scan file is to be understood.
struct ScanOptions {
    std::optional<LengthUnit> unit;  ///< none: guessed
    std::optional<Axis> up;          ///< of the file; none: found
    int max_points = 60000;          ///< scans with more are thinned to about that many
};
void describe(OptionList& list, ScanOptions& options);

/// Points of a scan's surface as they are registered: metres, but axes as in the file.
struct ScanPoints {
    Points points;                        ///< N x 3
    Points normals;                       ///< N x 3 unit normals, outward
    double spacing = 0.0;                 ///< median distance of a point to its nearest neighbour, m
    LengthUnit unit = LengthUnit::metre;  ///< of the file
    double metres_per_unit = 1.0;
    bool unit_guessed = false;
    std::vector<Axis> up_axes;    ///< those that may be up, likeliest first; one where it was given
    std::size_t file_points = 0;  ///< vertices in the file
    bool is_cloud = false;        ///< the file has no triangles
    /// Of a floor that was cut away: unit normal towards the person, height of the plane along it, m.
    std::optional<Eigen::Vector4d> floor;
    std::vector<std::string> notes;  ///< what was cut away or turned, for people
};

/// Reads OBJ, PLY, OFF, STL or GLB, mesh or point cloud. The unit is guessed from the largest extent, which for a
/// standing adult lies between 1.2 and 2.9 m in one unit only; an axis may be up if the extent along it is at least
/// two thirds of the largest. Of a mesh the surface is sampled: long edges are split, parts that face inwards are
/// turned; vertices that belong to no triangle are left out. A floor and stray parts are cut away (scan_cut.h). Throws
/// InputError naming file and value for a file that cannot be read, fewer than 500 points, or a size that is no
/// standing adult's.
ScanPoints read_scan(const std::string& path, const ScanOptions& options);
/// The same for a mesh or cloud in memory; `name` starts the messages.
ScanPoints prepare_scan(const std::string& name, const Eigen::Ref<const Points>& vertices,
                        const Eigen::Ref<const Triangles>& triangles, const ScanOptions& options);

/// Rotation that turns the axis `up` of a file to +y.
Eigen::Matrix3d rotation_to_y_up(Axis up);

}  // namespace ndg
