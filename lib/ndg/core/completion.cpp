// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/completion.h"

#include "ndg/core/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace ndg {

std::vector<CompletedFlag> completed_flags(const OptionList& list)
{
    using Value = CompletedFlag::Value;
    std::vector<CompletedFlag> flags = {{"--help"},
                                        {"--version"},
                                        {"--print-config"},
                                        {"--force"},
                                        {"--config", Value::file},
                                        {"--threads", Value::any},
                                        {"--log-level", Value::choice, names<LogLevel>()},
                                        {"--completion", Value::choice, {"bash"}}};
    for (const Option& option : list.options()) {
        if (option.holds<bool*>()) {
            flags.push_back({"--" + option.flag});
            flags.push_back({"--no-" + option.flag});
        } else {
            flags.push_back({"--" + option.flag, option.choices.empty() ? Value::any : Value::choice, option.choices});
        }
    }
    return flags;
}

std::string bash_completion(const std::string& command, const std::vector<CompletedFlag>& flags)
{
    std::string names, cases;
    std::vector<std::string> any;
    std::map<std::string, std::string> flags_of_choices;
    for (const CompletedFlag& flag : flags) {
        names += (names.empty() ? "" : " ") + flag.name;
        if (flag.value == CompletedFlag::Value::any) any.push_back(flag.name);
        if (flag.value != CompletedFlag::Value::choice) continue;
        std::string& alike = flags_of_choices[fmt::format("{}", fmt::join(flag.choices, " "))];
        alike += (alike.empty() ? "" : " | ") + flag.name;
    }
    for (const auto& [choices, alike] : flags_of_choices)
        cases += fmt::format("        {}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n", alike, choices);
    // Numbers and free text: nothing is offered, rather than file names.
    if (!any.empty()) cases += fmt::format("        {}) return ;;\n", fmt::join(any, " | "));
    std::string function = "_" + command;
    std::replace(function.begin(), function.end(), '-', '_');
    // Bash takes "--flag=value" for three words. File names may hold spaces: one a line.
    return fmt::format(R"(# Completion of {0} for bash, as its own --completion bash prints it.
{1}()
{{
    local word=${{COMP_WORDS[COMP_CWORD]}} last=${{COMP_WORDS[COMP_CWORD - 1]}}
    if [[ $word == = ]]; then
        word=
    elif [[ $last == = ]]; then
        last=${{COMP_WORDS[COMP_CWORD - 2]}}
    fi
    COMPREPLY=()
    case $last in
{2}    esac
    if [[ $word == -* ]]; then
        COMPREPLY=($(compgen -W '{3}' -- "$word"))
    else
        compopt -o filenames 2> /dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$word")
    fi
}}
complete -F {1} {0}
)",
                       command, function, cases, names);
}

}  // namespace ndg
