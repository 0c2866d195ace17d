// SPDX-License-Identifier: Apache-2.0
// Registered sequences as other programs write them.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/capture/capture.h"
#include "ndg/core/options.h"

#include <functional>
#include <string>

namespace ndg {

struct CaptureImportOptions {
    double frame_rate_hertz = 60;  ///< of the recording
    double metres_per_unit = 1;
    double most_missing = 0.1;  ///< share of a sequence's frames that may be missing
};
void describe(OptionList& list, CaptureImportOptions& options);

/// The surface that frames are registered to.
struct CaptureSurface {
    Eigen::Index num_vertices = 0;
    Triangles triangles;
};

/// One sequence of each of: a folder of OBJ and PLY files whose names end in the frame's number; a .npy or .npz array
/// K x N x 3; every dataset of an HDF5 file that is K x N x 3, or N x 3 x K as in the registrations of DFAUST and Dyna.
/// A sequence is called after its folder, file, or dataset. `say` gets a line for each: what was found, whether axes
/// were swapped, frames that are missing, and frames left out as missing because a vertex is no number. Throws
/// InputError naming file, frame and value: another number of vertices or other triangles than the surface's, two
/// frames of one number, more missing frames than allowed, no frames.
std::vector<CaptureSequence> import_sequences(const std::string& path, const CaptureSurface& surface,
                                              const CaptureImportOptions& options,
                                              const std::function<void(const std::string&)>& say);
/// Gives a sequence the poses of the clip of its name, at the times of its frames. Throws InputError that names `path`,
/// the file of the poses, where there is no such clip, and where it lasts another time than the sequence by more than
/// two frames of the capture: then one of both frame rates is not what it was said to be.
void attach_poses(CaptureSequence& sequence, const PoseSet& poses, const std::string& path);

}  // namespace ndg
