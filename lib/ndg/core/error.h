// SPDX-License-Identifier: Apache-2.0
// The error vocabulary. Every error carries one sentence for the user; Tool::run maps the type to the exit code.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>

namespace ndg {

/// Exit codes of every tool (docs/formats.md).
enum ExitCode : int {
    exit_done = 0,
    exit_failed = 1,
    exit_bad_input = 2,
    exit_quality_gate = 3,
    exit_interrupted = 75,
};

/// Something failed while running (exit code 1).
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Wrong arguments, files or values (exit code 2). The message names the file, the item and the value.
class InputError : public Error {
public:
    using Error::Error;
};

/// A linear or non-linear solver failed: singular, indefinite or non-finite system (exit code 1).
class SolverError : public Error {
public:
    using Error::Error;
};

/// Finished, but a quality gate did not hold (exit code 3).
class QualityError : public Error {
public:
    using Error::Error;
};

/// Stopped by a signal; running the same command again resumes (exit code 75).
class Interrupted : public Error {
public:
    using Error::Error;
};

/// Throws InputError with the formatted message unless `condition` holds. Stays on in Release.
template <typename... Args>
void require_input(bool condition, fmt::format_string<Args...> format, Args&&... args)
{
    if (!condition) throw InputError(fmt::format(format, std::forward<Args>(args)...));
}

/// Throws Error with the formatted message unless `condition` holds. Stays on in Release.
template <typename... Args>
void require(bool condition, fmt::format_string<Args...> format, Args&&... args)
{
    if (!condition) throw Error(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace ndg
