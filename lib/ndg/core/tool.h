// SPDX-License-Identifier: Apache-2.0
// The frame of every executable: command line, JSON config, provenance, and exceptions to exit codes.
#pragma once

#include "ndg/core/options.h"
#include "ndg/core/provenance.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// One executable. Options are registered once and are then a command-line flag (--target-edge-length), a key of
/// the tool's section in the JSON config ({"make-template": {"target_edge_length": 0.03}}), a line of --help and an
/// entry of the stored config. The command line beats the file, the file beats the default. Unknown keys and sections
/// are errors that name the nearest known one. Every tool has --config, --print-config, --seed (also a key of the
/// section or the file's top level), --threads, --log-level, --force, --version, --help, --completion (completion.h).
/// Sections of other tools and a text "description" may stand in the same file. A bool has --flag and --no-flag.
class Tool {
public:
    /// `summary`: one sentence; `example`: one full command line, shown by --help.
    Tool(std::string name, std::string summary, std::string example);
    ~Tool();

    /// Everything that can be chosen in an options struct, as its describe() says (options.h).
    template <typename Options>
    void options(Options& options)
    {
        describe(option_list(), options);
    }
    /// A choice of the tool alone: flag, value, help and range or choices, as OptionList::add takes them.
    template <typename Value, typename... Range>
    void parameter(const std::string& flag, Value& value, const std::string& help, const Range&... range)
    {
        option_list().add(flag, value, help, range...);
    }
    void parameter(const std::string& flag, std::string& value, const std::string& help,
                   const std::vector<std::string>& choices = {})
    {
        option_list().add(flag, value, help, choices);
    }

    /// Existing files or folders the tool reads; hashed into the provenance. Command line only.
    void input(const std::string& flag, std::string& path, const std::string& help, bool required = true);
    void input(const std::string& flag, std::vector<std::string>& paths, const std::string& help, bool required = true);
    /// The same for one required file given without a flag; at most one a tool.
    void positional_input(std::string& path, const std::string& help);
    /// A file the tool writes. If it exists already, run() stops with an InputError unless --force is given or
    /// `resumable` is true. Command line only.
    void output(const std::string& flag, std::string& path, const std::string& help, bool required = true,
                bool resumable = false);
    /// --FLAG prints `text` and ends, like --help, whatever else is missing. Command line only.
    void listing(const std::string& flag, std::string text, const std::string& help);

    /// Parses, merges the config, runs `body`, maps exceptions to exit codes (one line on stderr, no trace).
    int run(int argc, char** argv, const std::function<void()>& body);

    std::uint64_t seed() const;
    bool force() const;
    /// Tool name, resolved config and hashed inputs; `licences` names data the tool itself brings in.
    Provenance provenance(const std::string& licences = "") const;

private:
    OptionList& option_list();

    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
