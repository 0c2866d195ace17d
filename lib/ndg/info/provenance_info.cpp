// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/info/describers.h"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace ndg {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

json parse(const FileQuestion& file, const char* item, const std::string& text)
{
    json value = json::parse(text, nullptr, false);
    require_input(!value.is_discarded(), "{}: {} is no JSON", file.path, item);
    return value;
}

/// Where an input lies now: at its path as it was given, or beside the file. Empty: not found.
std::string find_input(const FileQuestion& file, const std::string& path)
{
    std::error_code error;
    for (const fs::path& place : {fs::path(path), fs::path(file.path).parent_path() / fs::path(path).filename()})
        if (fs::exists(place, error)) return place.string();
    return "";
}

}  // namespace

void add_provenance(const FileQuestion& file, const std::string& created_by, const std::string& config,
                    const std::string& inputs, const std::string& licences, FileReport& report)
{
    try {
        const json tool = parse(file, "created_by", created_by);
        report.add("written by", "{} {} (commit {})", tool.at("tool").get<std::string>(),
                   tool.at("version").get<std::string>(), tool.at("commit").get<std::string>());
        std::vector<std::string> options;
        const json sections = parse(file, "config", config);
        for (const auto& [section, values] : sections.items())
            for (const auto& [key, value] : values.items()) options.push_back(fmt::format("{} {}", key, value.dump()));
        if (!options.empty()) report.add("options", "{}", fmt::join(options, ", "));
        std::string lines;
        const json list = parse(file, "inputs", inputs);
        for (const json& input : list) {
            const auto path = input.at("path").get<std::string>(), hash = input.at("sha256").get<std::string>();
            std::string state;
            if (file.check) {
                const std::string found = find_input(file, path);
                const bool same = !found.empty() && sha256_path(found) == hash;
                state = found.empty() ? ", not found" : same ? ", the same now" : ", ANOTHER now";
                if (!found.empty() && !same)
                    report.add_failure(fmt::format("{}: its input {} is another file now", file.path, found));
            }
            lines += fmt::format("{} (sha256 {}...{})\n", path, hash.substr(0, 12), state);
        }
        if (!lines.empty()) report.add("made of", lines);
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: what it says of its origin is damaged ({})", file.path, error.what()));
    }
    report.add("licences", licences.empty() ? "of no data but the project's own" : licences);
}

}  // namespace ndg
