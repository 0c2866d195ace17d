// SPDX-License-Identifier: Apache-2.0
// One small example of every kind of file of the body module, and ways to damage it.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/splits.h"
#include "ndg/body/shape_space.h"
#include "ndg/body/template.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg::test {

Provenance example_provenance();
BodySet example_bodies(const Template& tube);
PoseSet example_poses();
Splits example_splits();
DeformationSet example_deformations();
ShapeSpace example_shape_space(const BodySet& bodies);

/// Writes the shape space with codes and errors of the bodies.
void write_example_shape_space(const std::string& path, const BodySet& bodies);

/// Runs a Python script (h5py as h5py, numpy as np) and fails the test with its output if it fails.
void run_python(const std::string& script);

/// An edit of a file: Python statements on the open file `f` (`put(name, array)` replaces a dataset), and words that
/// the error must contain.
struct Damage {
    std::string python;
    std::vector<std::string> expected;
};
/// Every damage is done to a copy of the file; reading the copy must throw an InputError that names the copy and has
/// the expected words.
void check_damages(const std::string& path, const std::vector<Damage>& damages,
                   const std::function<void(const std::string&)>& read);

}  // namespace ndg::test
