// SPDX-License-Identifier: Apache-2.0
// Logging to stderr. stdout is kept for results.
#pragma once

#include "ndg/core/enum_names.h"

#include <fmt/format.h>

#include <string>
#include <utility>

namespace ndg {

enum class LogLevel { debug, info, warning, error, off };
template <>
inline constexpr EnumName<LogLevel> enum_table<LogLevel>[] = {{LogLevel::debug, "debug"},
                                                              {LogLevel::info, "info"},
                                                              {LogLevel::warning, "warning"},
                                                              {LogLevel::error, "error"},
                                                              {LogLevel::off, "off"}};

/// Sets the level below which messages are dropped.
void set_log_level(LogLevel level);
/// Whether messages of this level are written.
bool log_enabled(LogLevel level);
/// Writes one line to stderr, with time and level.
void log_message(LogLevel level, const std::string& message);

template <typename... Args>
void log_debug(fmt::format_string<Args...> format, Args&&... args)
{
    log_message(LogLevel::debug, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void log_info(fmt::format_string<Args...> format, Args&&... args)
{
    log_message(LogLevel::info, fmt::format(format, std::forward<Args>(args)...));
}
template <typename... Args>
void log_warning(fmt::format_string<Args...> format, Args&&... args)
{
    log_message(LogLevel::warning, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace ndg
