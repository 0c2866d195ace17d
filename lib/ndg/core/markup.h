// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace ndg {

/// Text as it may stand in XML and HTML, between tags and in attributes in double quotes: & < > and " as entities.
std::string escaped_markup(const std::string& text);

}  // namespace ndg
