// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool_config.h"
#include "ndg/core/tool_parameter.h"

#include <CLI/CLI.hpp>

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <limits>
#include <new>
#include <utility>

namespace ndg {
namespace {

namespace fs = std::filesystem;

struct ToolInput {
    std::string flag;  ///< empty: positional
    std::string help;
    std::variant<std::string*, std::vector<std::string>*> paths;
    bool required = true;

    std::string name() const { return flag.empty() ? "FILE" : "--" + flag; }
    std::vector<std::string> list() const
    {
        if (const auto* many = std::get_if<std::vector<std::string>*>(&paths)) return **many;
        const std::string& one = **std::get_if<std::string*>(&paths);
        return one.empty() ? std::vector<std::string>{} : std::vector<std::string>{one};
    }
};

struct ToolOutput {
    std::string flag, help;
    std::string* path = nullptr;
    bool required = true, resumable = false;
};

struct ToolListing {
    std::string flag, text, help;
    bool wanted = false;
};

/// Ends run() early with exit code 0: --help, --version, --print-config and listings.
struct EarlyExit {};

void check_input(const ToolInput& input)
{
    const std::vector<std::string> paths = input.list();
    require_input(!input.required || !paths.empty(), "{} is missing", input.name());
    for (const std::string& path : paths) {
        require_input(!path.empty(), "{}: a file name is empty", input.name());
        std::error_code error;
        require_input(fs::exists(path, error), "{}: {} does not exist", input.name(), path);
        require_input(::access(path.c_str(), R_OK) == 0, "{}: {} cannot be read", input.name(), path);
    }
}

void check_output(const ToolOutput& output, bool force)
{
    require_input(!output.required || !output.path->empty(), "--{} is missing", output.flag);
    if (output.path->empty()) return;
    std::error_code error;
    const fs::path path(*output.path);
    require_input(path.has_filename() && !fs::is_directory(path, error), "--{}: {} is a folder, expected a file",
                  output.flag, *output.path);
    require_input(force || output.resumable || !fs::exists(path, error),
                  "--{}: {} exists already, give --force to overwrite it", output.flag, *output.path);
}

void check_differs(const ToolOutput& output, const ToolInput& input)
{
    std::error_code error;
    for (const std::string& path : input.list()) {
        require_input(!fs::equivalent(path, *output.path, error), "--{}: {} is also the input {}", output.flag,
                      *output.path, input.name());
    }
}

/// One line, whatever the message holds.
void print_error(const std::string& tool, std::string message)
{
    std::replace(message.begin(), message.end(), '\n', ' ');
    while (!message.empty() && message.back() == ' ') message.pop_back();
    std::fflush(stdout);
    std::fprintf(stderr, "%s: error: %s\n", tool.c_str(), message.c_str());
}

}  // namespace

struct Tool::State {
    std::string name, summary, example;
    std::vector<ToolParameter> parameters;
    std::vector<ToolInput> inputs;
    std::vector<ToolOutput> outputs;
    std::vector<ToolListing> listings;
    std::uint64_t seed = 1;
    int threads = 0;
    std::string log_level = "info";
    std::string config_path;
    bool force = false, print_config = false, help = false, version = false;
    mutable std::vector<Provenance::Input> hashed_inputs;
    mutable bool hashed = false;

    ToolParameter& add(const std::string& flag, const std::string& help_text)
    {
        ToolParameter parameter;
        parameter.flag = flag;
        parameter.help = help_text;
        return parameters.emplace_back(std::move(parameter));
    }

    std::string resolved_config(int indent) const
    {
        nlohmann::json section = nlohmann::json::object();
        for (const ToolParameter& parameter : parameters) section[parameter.key()] = parameter.to_json();
        return nlohmann::json{{name, section}}.dump(indent);
    }

    std::string help_text() const;
    void parse(int argc, char** argv);
    void resolve();
};

std::string Tool::State::help_text() const
{
    std::vector<std::pair<std::string, std::string>> files, options;
    for (const ToolInput& input : inputs) {
        const bool many = std::holds_alternative<std::vector<std::string>*>(input.paths);
        const std::string shown = input.flag.empty() ? "FILE" : "--" + input.flag + (many ? " FILE..." : " FILE");
        files.emplace_back(shown, input.help + (input.required ? "" : " (optional)"));
    }
    for (const ToolOutput& output : outputs) {
        files.emplace_back("--" + output.flag + " FILE", output.help + (output.required ? "" : " (optional)"));
    }
    for (const ToolParameter& parameter : parameters) {
        if (parameter.flag == "seed") continue;  // stands in the common line
        const std::string range = parameter.range_text();
        options.emplace_back((parameter.is_flag() ? "--[no-]" : "--") + parameter.flag + " " + parameter.value_name(),
                             fmt::format("{}{} (default {})", parameter.help, range.empty() ? "" : ", " + range,
                                         parameter.value_text().empty() ? "none" : parameter.value_text()));
    }
    for (const ToolListing& listing : listings) options.emplace_back("--" + listing.flag, listing.help);
    std::size_t width = 0;
    for (const auto& [left, right] : files) width = std::max(width, left.size());
    for (const auto& [left, right] : options) width = std::max(width, left.size());
    const auto lines = [width](const auto& rows) {
        std::string text;
        for (const auto& [left, right] : rows) text += fmt::format("  {:<{}}  {}\n", left, width, right);
        return text;
    };
    std::string text = fmt::format("{}: {}\n\nExample: {}\n", name, summary, example);
    if (!files.empty()) text += "\nFiles:\n" + lines(files);
    if (!options.empty()) {
        text += fmt::format("\nParameters (in a config file: keys of \"{}\", in snake_case):\n", name) + lines(options);
    }
    text += fmt::format(
        "\nCommon: --config FILE, --print-config, --seed INT (default {}), --threads INT (0: all cores), --force,\n"
        "        --log-level debug|info|warning|error|off, --version, --help\n",
        seed);
    return text;
}

void Tool::State::parse(int argc, char** argv)
{
    CLI::App app(summary, name);
    app.set_help_flag();
    app.allow_extras();
    app.add_flag("-h,--help", help);
    app.add_flag("--version", version);
    app.add_flag("--print-config", print_config);
    app.add_flag("--force", force);
    app.add_option("--config", config_path);
    app.add_option("--log-level", log_level);
    app.add_option("--threads", threads);
    std::vector<std::string> flags = {"help", "version", "print-config", "force", "config", "log-level", "threads"};
    std::vector<CLI::Option*> options;
    for (ToolParameter& parameter : parameters) {
        flags.push_back(parameter.flag);
        const std::string long_name = "--" + parameter.flag;
        if (parameter.is_flag()) {
            options.push_back(app.add_flag(long_name + ",!--no-" + parameter.flag, parameter.flag_value));
        } else {
            options.push_back(app.add_option(long_name, parameter.words));
            if (!parameter.is_list()) options.back()->expected(1);
        }
    }
    for (ToolInput& input : inputs) {
        flags.push_back(input.flag);
        const std::string long_name = input.flag.empty() ? "file" : "--" + input.flag;
        std::visit([&](auto* paths) { app.add_option(long_name, *paths); }, input.paths);
    }
    for (ToolOutput& output : outputs) {
        flags.push_back(output.flag);
        app.add_option("--" + output.flag, *output.path);
    }
    for (ToolListing& listing : listings) {
        flags.push_back(listing.flag);
        app.add_flag("--" + listing.flag, listing.wanted);
    }
    app.parse(argc, argv);
    for (std::size_t i = 0; i < parameters.size(); ++i) parameters[i].given = options[i]->count() > 0;

    const std::vector<std::string> extras = app.remaining();
    if (!extras.empty() && !help && !version) {
        const std::string& extra = extras.front();
        require_input(extra.rfind("--", 0) == 0, "unexpected argument '{}'", extra);
        const std::string flag = extra.substr(2, extra.find('=') - 2);
        throw InputError(fmt::format("unknown option --{}, did you mean --{}?", flag, nearest_name(flag, flags)));
    }
}

void Tool::State::resolve()
{
    if (help) {
        std::fputs(help_text().c_str(), stdout);
        throw EarlyExit{};
    }
    if (version) {
        fmt::print("{} {} ({})\n", name, project_version(), project_commit());
        throw EarlyExit{};
    }
    for (const ToolListing& listing : listings) {
        if (!listing.wanted) continue;
        fmt::print("{}\n", listing.text);
        throw EarlyExit{};
    }
    if (!config_path.empty()) apply_config(config_path, name, parameters, "seed");
    for (ToolParameter& parameter : parameters) {
        if (parameter.given) parameter.take_words();
    }
    set_log_level(parse_log_level(log_level));
    if (print_config) {
        fmt::print("{}\n", resolved_config(2));
        throw EarlyExit{};
    }
    set_num_threads(threads);
    for (const ToolInput& input : inputs) check_input(input);
    for (const ToolOutput& output : outputs) check_output(output, force);
    for (const ToolOutput& output : outputs) {
        for (const ToolInput& input : inputs) check_differs(output, input);
    }
    for (const ToolOutput& output : outputs) {
        const fs::path folder = fs::path(*output.path).parent_path();
        std::error_code error;
        if (!folder.empty()) fs::create_directories(folder, error);
        require_input(!error, "--{}: cannot make folder {}: {}", output.flag, folder.string(), error.message());
    }
}

Tool::Tool(std::string name, std::string summary, std::string example) : state_(std::make_unique<State>())
{
    state_->name = std::move(name);
    state_->summary = std::move(summary);
    state_->example = std::move(example);
    state_->add("seed", "seed of all random choices").value = &state_->seed;
}

Tool::~Tool() = default;

void Tool::parameter(const std::string& flag, double& value, const std::string& help, double low, double high)
{
    ToolParameter& added = state_->add(flag, help);
    added.value = &value;
    added.low = low;
    added.high = high;
}

void Tool::parameter(const std::string& flag, int& value, const std::string& help, int low, int high)
{
    ToolParameter& added = state_->add(flag, help);
    added.value = &value;
    added.low = low;
    added.high = high;
}

void Tool::parameter(const std::string& flag, bool& value, const std::string& help)
{
    state_->add(flag, help).value = &value;
}

void Tool::parameter(const std::string& flag, std::vector<int>& value, const std::string& help)
{
    state_->add(flag, help).value = &value;
}

void Tool::parameter(const std::string& flag, std::string& value, const std::string& help,
                     const std::vector<std::string>& choices)
{
    ToolParameter& added = state_->add(flag, help);
    added.value = &value;
    added.choices = choices;
}

void Tool::input(const std::string& flag, std::string& path, const std::string& help, bool required)
{
    state_->inputs.push_back({flag, help, &path, required});
}

void Tool::input(const std::string& flag, std::vector<std::string>& paths, const std::string& help, bool required)
{
    state_->inputs.push_back({flag, help, &paths, required});
}

void Tool::positional_input(std::string& path, const std::string& help)
{
    input("", path, help, true);
}

void Tool::output(const std::string& flag, std::string& path, const std::string& help, bool required, bool resumable)
{
    state_->outputs.push_back({flag, help, &path, required, resumable});
}

void Tool::listing(const std::string& flag, std::string text, const std::string& help)
{
    state_->listings.push_back({flag, std::move(text), help});
}

int Tool::run(int argc, char** argv, const std::function<void()>& body)
{
    const std::string& name = state_->name;
    try {
        state_->parse(argc, argv);
        try {
            state_->resolve();
            body();
        } catch (const EarlyExit&) {
        }
        // A full disk or a closed pipe shows up only here.
        require(std::fflush(stdout) == 0 && std::ferror(stdout) == 0, "cannot write the result to stdout");
        return exit_done;
    } catch (const CLI::ParseError& error) {
        print_error(name, error.what());
        return exit_bad_input;
    } catch (const InputError& error) {
        print_error(name, error.what());
        return exit_bad_input;
    } catch (const QualityError& error) {
        print_error(name, error.what());
        return exit_quality_gate;
    } catch (const Interrupted& error) {
        print_error(name, error.what());
        return exit_interrupted;
    } catch (const std::bad_alloc&) {
        print_error(name, "out of memory");
    } catch (const std::exception& error) {
        print_error(name, error.what());
    } catch (...) {
        print_error(name, "unknown failure");
    }
    return exit_failed;
}

std::uint64_t Tool::seed() const
{
    return state_->seed;
}

bool Tool::force() const
{
    return state_->force;
}

Provenance Tool::provenance(const std::string& licences) const
{
    if (!state_->hashed) {
        std::vector<std::string> paths;
        for (const ToolInput& input : state_->inputs) {
            for (const std::string& path : input.list()) paths.push_back(path);
        }
        if (!state_->config_path.empty()) paths.push_back(state_->config_path);
        std::vector<Provenance::Input> hashed;
        for (const std::string& path : paths) hashed.push_back({path, sha256_path(path), ""});
        state_->hashed_inputs = std::move(hashed);
        state_->hashed = true;
    }
    Provenance provenance;
    provenance.tool = state_->name;
    provenance.config_json = state_->resolved_config(-1);
    provenance.inputs = state_->hashed_inputs;
    provenance.licences = licences;
    return provenance;
}

}  // namespace ndg
