// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ndg {

/// Path of what stands under this name in configs/ of the project ("joint-maps", "joint-limits.json"), found from where
/// the running program lies: in configs/ or share/neural_deformation_gradients/configs/ of the folders above it, the
/// nearest first (a source tree with its build folder, a release, an installation). "" where there is none.
std::string find_project_config(const std::string& name);

}  // namespace ndg
