// SPDX-License-Identifier: Apache-2.0
// Figures of bodies in motion with inertia as one page: pictures, distances, what is inside of what.
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/scene/camera.h"

#include <string>
#include <vector>

namespace ndg {

/// One result of simulate-dynamics.
struct DynamicsFigureRun {
    std::string label;
    std::string path;  ///< of the file, one motion
};

/// distance: the last frames of all runs side by side, coloured by the distance from the skinned shape. motion: frames
/// of each run, and what is inside of what.
enum class DynamicsFigureKind { distance, motion };

struct DynamicsFigure {
    std::string title, note;
    DynamicsFigureKind kind = DynamicsFigureKind::distance;
    double range_metre = 0.02;  ///< shown in full red
    View view = View::front;
    int frames = 5;  ///< of a motion
    std::vector<DynamicsFigureRun> runs;
};

/// Reads JSON {"figures": [{"title", "note", "kind": "distance" or "motion", "range_mm", "view", "frames", "runs":
/// [{"label", "name"}]}]}; `name`: of <folder>/<name>.h5. Throws InputError naming file, place and value.
std::vector<DynamicsFigure> read_dynamics_figures(const std::string& path, const std::string& folder);

/// What a run shows in numbers.
struct DynamicsFigures {
    double largest_metre = 0, mean_metre = 0;  ///< of the skin that gives way from the skinned shape, last frame
    double largest_ever_metre = 0;             ///< in any frame
};

/// Writes the page at `output` and a PNG file of each figure beside it. A file <folder>/<name>.txt, where there is one,
/// is the command that made a run and is shown with it. Throws InputError for a run that is not of the avatar.
void write_dynamics_report(const std::string& output, const std::vector<DynamicsFigure>& figures, const Avatar& avatar,
                           int picture_height);

}  // namespace ndg
