// SPDX-License-Identifier: Apache-2.0
// A body in motion as animate shows it: mesh files, a page, a picture.
#pragma once

#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/deform/deformer.h"
#include "ndg/scene/pictures.h"

#include <string>

namespace ndg {

/// Files to write, and how.
struct MotionDisplay {
    std::string mesh, page, picture;  ///< empty: none
    std::string surface = "all";      ///< what `mesh` holds, one of body_mesh_choices
    int count = 6;                    ///< frames on the picture
    PictureSettings settings;

    /// --mesh, --page, --picture and how they look; the tool keeps references.
    void add(Tool& tool);
    bool wanted() const { return !mesh.empty() || !page.empty() || !picture.empty(); }
    /// Before anything is deformed: throws InputError for samples of several bodies, a file name that no format of
    /// meshes fits, and files of `mesh` that exist already, unless `force`.
    void check(const SampleIndex& samples, bool force) const;
    /// `deformed`: all samples by the method of `deformer`, which is asked for the anatomy alone. Reads frame after
    /// frame; what a format holds in memory is its own (formats.md). Throws Interrupted when a signal asks for it.
    void write(const SampleInputs& inputs, const DeformationSet& deformed, Deformer& deformer,
               const std::string& credits) const;
};

}  // namespace ndg
