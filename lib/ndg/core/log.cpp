// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/log.h"

#include "ndg/core/error.h"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>

namespace ndg {
namespace {

spdlog::level::level_enum spdlog_level(LogLevel level)
{
    switch (level) {
        case LogLevel::debug:
            return spdlog::level::debug;
        case LogLevel::info:
            return spdlog::level::info;
        case LogLevel::warning:
            return spdlog::level::warn;
        case LogLevel::error:
            return spdlog::level::err;
        case LogLevel::off:
            break;
    }
    return spdlog::level::off;
}

spdlog::logger& logger()
{
    static const std::shared_ptr<spdlog::logger> instance = [] {
        auto created = std::make_shared<spdlog::logger>("ndg", std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
        created->set_pattern("%H:%M:%S %^%l%$ %v");
        created->flush_on(spdlog::level::debug);
        return created;
    }();
    return *instance;
}

}  // namespace

void set_log_level(LogLevel level)
{
    logger().set_level(spdlog_level(level));
}

bool log_enabled(LogLevel level)
{
    return level != LogLevel::off && logger().should_log(spdlog_level(level));
}

void log_message(LogLevel level, const std::string& message)
{
    if (level != LogLevel::off) logger().log(spdlog_level(level), message);
}

}  // namespace ndg
