// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/tool.h"

#include "ndg/core/completion.h"
#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/core/option_json.h"
#include "ndg/core/processor.h"
#include "ndg/core/text_file.h"
#include "ndg/core/threads.h"
#include "ndg/core/tool_config.h"
#include "ndg/core/tool_files.h"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <new>
#include <utility>

namespace ndg {
namespace {

namespace fs = std::filesystem;

struct ToolListing {
    std::string flag, text, help;
    bool wanted = false;
};

/// Ends run() early with exit code 0: --help, --version, --print-config and listings.
struct EarlyExit {};

/// One line that a terminal can show, whatever the message holds.
void print_error(const std::string& tool, std::string message)
{
    std::replace(message.begin(), message.end(), '\n', ' ');
    while (!message.empty() && message.back() == ' ') message.pop_back();
    std::fflush(stdout);
    std::fprintf(stderr, "%s: error: %s\n", tool.c_str(), printable(message).c_str());
}

}  // namespace

struct Tool::State {
    std::string name, summary, example;
    OptionList options;
    std::vector<std::vector<std::string>> given;  ///< for each option its words on the command line; empty: not there
    std::vector<ToolInput> inputs;
    std::vector<ToolOutput> outputs;
    std::vector<ToolListing> listings;
    std::uint64_t seed = 1;
    int threads = 0;
    std::string log_level = "info";
    std::string config_path;
    std::string completion;  ///< shell that a script is asked for
    bool force = false, print_config = false, help = false, version = false;
    mutable std::vector<Provenance::Input> hashed_inputs;
    mutable bool hashed = false;

    std::string resolved_config(int indent) const
    {
        nlohmann::json section = nlohmann::json::object();
        for (const Option& option : options.options()) section[option.key()] = to_json(option);
        return nlohmann::json{{name, section}}.dump(indent);
    }

    std::string help_text() const;
    std::string completion_script(const std::string& command) const;
    void parse(int argc, char** argv);
    /// `command`: the name that the tool was called by.
    void resolve(const std::string& command);
};

std::string Tool::State::help_text() const
{
    std::vector<std::pair<std::string, std::string>> files, choices;
    for (const ToolInput& input : inputs) {
        const bool many = std::holds_alternative<std::vector<std::string>*>(input.paths);
        const std::string shown = input.flag.empty() ? "FILE" : "--" + input.flag + (many ? " FILE..." : " FILE");
        files.emplace_back(shown, input.help + (input.required ? "" : " (optional)"));
    }
    for (const ToolOutput& output : outputs) {
        files.emplace_back("--" + output.flag + " FILE", output.help + (output.required ? "" : " (optional)"));
    }
    for (const Option& option : options.options()) {
        if (option.flag == "seed") continue;  // stands in the common line
        const std::string range = option.range_text(), value = option.value_text();
        choices.emplace_back((option.holds<bool*>() ? "--[no-]" : "--") + option.flag + " " + option.value_name(),
                             fmt::format("{}{} (default {})", option.help, range.empty() ? "" : ", " + range,
                                         value.empty() ? "none" : value));
    }
    for (const ToolListing& listing : listings) choices.emplace_back("--" + listing.flag, listing.help);
    std::size_t width = 0;
    for (const auto& [left, right] : files) width = std::max(width, left.size());
    for (const auto& [left, right] : choices) width = std::max(width, left.size());
    const auto lines = [width](const auto& rows) {
        std::string text;
        for (const auto& [left, right] : rows) text += fmt::format("  {:<{}}  {}\n", left, width, right);
        return text;
    };
    std::string text = fmt::format("{}: {}\n\nExample: {}\n", name, summary, example);
    if (!files.empty()) text += "\nFiles:\n" + lines(files);
    if (!choices.empty()) {
        text += fmt::format("\nParameters (in a config file: keys of \"{}\", in snake_case):\n", name) + lines(choices);
    }
    text += fmt::format(
        "\nCommon: --config FILE, --print-config, --seed INT (default {}), --threads INT (0: all cores), --force,\n"
        "        --log-level debug|info|warning|error|off, --version, --help, --completion bash\n",
        seed);
    return text;
}

std::string Tool::State::completion_script(const std::string& command) const
{
    std::vector<CompletedFlag> flags = completed_flags(options);
    for (const ToolInput& input : inputs)
        if (!input.flag.empty()) flags.push_back({"--" + input.flag, CompletedFlag::Value::file});
    for (const ToolOutput& output : outputs) flags.push_back({"--" + output.flag, CompletedFlag::Value::file});
    for (const ToolListing& listing : listings) flags.push_back({"--" + listing.flag});
    return bash_completion(command, flags);
}

void Tool::State::parse(int argc, char** argv)
{
    auto& list = options.options();
    list.erase(std::remove_if(list.begin(), list.end(), [](const Option& option) { return !option.has_flag; }),
               list.end());
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
    app.add_option("--completion", completion);
    std::vector<std::string> flags = {"help",   "version",   "print-config", "force",
                                      "config", "log-level", "threads",      "completion"};
    given.resize(list.size());
    std::vector<CLI::Option*> registered;
    for (std::size_t i = 0; i < given.size(); ++i) {
        const Option& option = list[i];
        flags.push_back(option.flag);
        const std::string long_name = "--" + option.flag;
        if (option.holds<bool*>()) {
            registered.push_back(app.add_flag(long_name + ",!--no-" + option.flag));
        } else {
            registered.push_back(app.add_option(long_name, given[i]));
            if (!option.holds<std::vector<int>*>()) registered.back()->expected(1);
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
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (list[i].holds<bool*>() && registered[i]->count() > 0) {
            given[i] = {registered[i]->as<bool>() ? "true" : "false"};
        }
    }

    const std::vector<std::string> extras = app.remaining();
    if (!extras.empty() && !help && !version) {
        const std::string& extra = extras.front();
        require_input(extra.rfind("--", 0) == 0, "unexpected argument '{}'", extra);
        const std::string flag = extra.substr(2, extra.find('=') - 2);
        throw InputError(fmt::format("unknown option --{}, did you mean --{}?", flag, nearest_name(flag, flags)));
    }
}

void Tool::State::resolve(const std::string& command)
{
    if (help) {
        std::fputs(help_text().c_str(), stdout);
        throw EarlyExit{};
    }
    if (version) {
        fmt::print("{} {} ({}, for {})\n", name, project_version(), project_commit(), processor_name());
        throw EarlyExit{};
    }
    if (!completion.empty()) {
        require_input(completion == "bash", "--completion: there is one for bash, not for '{}'", completion);
        fmt::print("{}", completion_script(command));
        throw EarlyExit{};
    }
    for (const ToolListing& listing : listings) {
        if (!listing.wanted) continue;
        fmt::print("{}\n", listing.text);
        throw EarlyExit{};
    }
    if (!config_path.empty()) apply_config(config_path, name, options.options(), "seed");
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (!given[i].empty()) set_from_words(options.options()[i], given[i]);
    }
    set_log_level(parse_name<LogLevel>(log_level, "--log-level"));
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
    for (const ToolOutput& output : outputs)
        if (!output.path->empty()) prepare_output(output);
}

Tool::Tool(std::string name, std::string summary, std::string example) : state_(std::make_unique<State>())
{
    state_->name = std::move(name);
    state_->summary = std::move(summary);
    state_->example = std::move(example);
    state_->options.add("seed", state_->seed, "seed of all random choices");
}

Tool::~Tool() = default;

OptionList& Tool::option_list()
{
    return state_->options;
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
            state_->resolve(fs::path(argv[0]).filename().string());
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
        std::vector<Provenance::Input> hashed;
        for (const std::string& path : paths) hashed.push_back({path, sha256_path(path), "", false});
        const std::string& config = state_->config_path;
        if (!config.empty()) hashed.push_back({config, sha256_path(config), "", true});
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
