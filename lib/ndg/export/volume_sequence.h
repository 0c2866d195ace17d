// SPDX-License-Identifier: Apache-2.0
// Volumes that are exported: cells that move, with fields on vertices and cells.
#pragma once

#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// Where numbers stand already: a dataset of an HDF5 file, or a slice of it along its first axis.
struct StoredArray {
    std::string file, dataset;
    std::vector<std::size_t> shape;  ///< of the whole dataset
    int slice = -1;                  ///< -1: all of it
};

enum class CellKind { wedge, tetrahedron };

/// Fields by name, one value a vertex or cell.
using Fields = std::map<std::string, Eigen::VectorXf>;

/// What cells of one kind keep in all frames.
struct VolumeGrid {
    std::string name;  ///< "flesh"
    CellKind kind = CellKind::wedge;
    StoredArray cells;  ///< int32, C x 6 (outer triangle, inner triangle) or C x 4
    Fields cell_fields;
};

/// One grid in one frame.
struct VolumeFrame {
    Points vertices;                             ///< m, y up; their number is the same in all frames
    std::optional<StoredArray> stored_vertices;  ///< where the same stand as float32, in all frames or in none
    Fields point_fields, cell_fields;            ///< of the same names in all frames
};

struct VolumeSequence {
    std::vector<VolumeGrid> grids;
    /// One entry a grid. Asked for in ascending order, each frame once.
    std::function<std::vector<VolumeFrame>(int frame_idx)> frame;
    Provenance provenance;  ///< of files written beside
};

}  // namespace ndg
