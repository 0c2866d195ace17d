// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

namespace ndg {

/// viewer/dist/viewer.js: the script of every page, with the licence of three.js in it.
std::string_view viewer_bundle();

}  // namespace ndg
