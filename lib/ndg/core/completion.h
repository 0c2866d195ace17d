// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/options.h"

#include <string>
#include <vector>

namespace ndg {

/// What may follow a flag on the command line.
struct CompletedFlag {
    enum class Value { none, any, file, choice };

    std::string name;  ///< "--output"
    Value value = Value::none;
    std::vector<std::string> choices = {};
};

/// The flags of these options and those that every tool has.
std::vector<CompletedFlag> completed_flags(const OptionList& list);

/// A script for bash that completes flags, choices and file names of a command. To be sourced, or kept as
/// share/bash-completion/completions/<command>. Names and choices hold nothing that bash would expand.
std::string bash_completion(const std::string& command, const std::vector<CompletedFlag>& flags);

}  // namespace ndg
