// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/export/mesh_sequence.h"

#include <string>
#include <vector>

namespace ndg {

/// How a format keeps several frames: in files of their own, numbered by name, or in one file; or as the name says, in
/// one file where it holds no place of a number.
enum class Frames { numbered_files, one_file, by_name };

/// What a format holds of a MeshSequence: its meshes; its meshes, one of which may be on a skeleton; its volume alone.
enum class Contents { surfaces, surfaces_and_rig, volume };

/// A way to write meshes, chosen by the extension of the file name. The list is formats.def: a new format is a row
/// there and a file that defines its writer.
struct ExportFormat {
    std::string extension;  ///< ".glb"
    Frames frames = Frames::numbered_files;
    Contents contents = Contents::surfaces;
    /// Writes through a temporary name. Of numbered files it gets one frame at a time.
    void (*write)(const std::string& path, const MeshSequence& sequence) = nullptr;
    std::string summary;  ///< what it is, half a sentence
};
const std::vector<ExportFormat>& export_formats();
/// The format of a file name. Throws InputError naming the known extensions.
const ExportFormat& export_format(const std::string& path);

/// The files that export_meshes writes for `num_frames` frames. A name of numbered files holds the place of the number
/// as "{}" or, with leading zeros, "{:04}"; frames count from 0. Throws InputError where that is malformed, or missing
/// although there are several frames.
std::vector<std::string> exported_files(const std::string& path, int num_frames);

/// Writes all frames, by extension. Throws Error for a sequence without what the format holds, meshes without a name of
/// their own, values that are not finite, indices out of range, and numbers of vertices, colours or scalars that do not
/// fit.
void export_meshes(const std::string& path, const MeshSequence& sequence);

}  // namespace ndg
