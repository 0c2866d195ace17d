// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/enum_names.h"

#include "ndg/core/error.h"

#include <fmt/ranges.h>

namespace ndg {

void throw_value_without_name(int value)
{
    throw Error(fmt::format("{} is no value of its enum", value));
}

void throw_unknown_name(std::string_view text, const std::string& what, const std::vector<std::string>& known)
{
    throw InputError(
        fmt::format("{}{}\"{}\" is none of {}", what, what.empty() ? "" : ": ", text, fmt::join(known, " | ")));
}

}  // namespace ndg
