// SPDX-License-Identifier: Apache-2.0
#include "ndg/retarget/joint_map_names.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <set>

namespace ndg {

namespace {

bool is_upper(char c)
{
    return std::isupper(static_cast<unsigned char>(c)) != 0;
}
bool is_digit(char c)
{
    return std::isdigit(static_cast<unsigned char>(c)) != 0;
}

/// Words and numbers between separators, at changes of case and around digits.
std::vector<std::string> split(const std::string& name)
{
    std::vector<std::string> parts;
    std::string part;
    const auto flush = [&] {
        if (!part.empty()) parts.push_back(part);
        part.clear();
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const char c = name[i];
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) {
            flush();
            continue;
        }
        if (!part.empty()) {
            const char last = part.back();
            const bool next_lower = i + 1 < name.size() && std::islower(static_cast<unsigned char>(name[i + 1])) != 0;
            if (is_digit(c) != is_digit(last) || (is_upper(c) && (!is_upper(last) || next_lower))) flush();
        }
        part += c;
    }
    flush();
    for (std::string& word : parts) {
        for (char& c : word) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return parts;
}

std::string without_namespace(const std::string& name)
{
    const std::size_t colon = name.rfind(':');
    return colon == std::string::npos ? name : name.substr(colon + 1);
}

std::string without_zeros(const std::string& number)
{
    const std::size_t first = number.find_first_not_of('0');
    return first == std::string::npos ? "0" : number.substr(first);
}

/// The name of the other side if the letter at `i` stands for a side.
std::string other_side(std::string name, std::size_t i)
{
    const std::string from = "lrLR", to = "rlRL";
    const std::size_t k = from.find(name[i]);
    if (k == std::string::npos) return "";
    name[i] = to[k];
    return name;
}

/// Position of a letter that alone tells a name from another one of the skeleton; npos where there is none. Letters at
/// the ends and beside separators come first: "lradius" of "rradius", "thigh_l" of "thigh_r", "CC_Base_L_Hand".
std::size_t side_letter(const std::string& name, const std::set<std::string>& names)
{
    const auto separated = [&](std::size_t i) {
        return i >= name.size() || std::isalnum(static_cast<unsigned char>(name[i])) == 0;
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const bool alone = (i == 0 || separated(i - 1)) && separated(i + 1);
        if (alone && !other_side(name, i).empty() && names.count(other_side(name, i)) > 0) return i;
    }
    for (const std::size_t i : {std::size_t(0), name.size() - 1}) {
        if (name.size() > 1 && !other_side(name, i).empty() && names.count(other_side(name, i)) > 0) return i;
    }
    return std::string::npos;
}

}  // namespace

std::vector<JointName> parse_joint_names(const std::vector<std::string>& names)
{
    std::set<std::string> known;
    for (const std::string& name : names) known.insert(without_namespace(name));
    std::vector<JointName> result;
    for (const std::string& full : names) {
        std::string name = without_namespace(full);
        JointName parsed;
        const std::vector<std::string> whole = split(name);
        for (const std::string& word : whole) {
            if (word == "left") parsed.side = Side::left;
            if (word == "right") parsed.side = Side::right;
        }
        if (parsed.side == Side::none) {
            const std::size_t letter = side_letter(name, known);
            if (letter != std::string::npos) {
                parsed.side = std::tolower(static_cast<unsigned char>(name[letter])) == 'l' ? Side::left : Side::right;
                name[letter] = ' ';
            }
        }
        for (const std::string& word : split(name)) {
            if (word == "left" || word == "right") continue;
            parsed.parts.push_back(is_digit(word[0]) ? without_zeros(word) : word);
            if (is_digit(word[0])) {
                parsed.numbers.push_back(word.size() < 6 ? std::stoi(word) : 0);
            } else {
                parsed.words.push_back(word);
                parsed.joined += word;
            }
        }
        result.push_back(parsed);
    }
    return result;
}

std::vector<std::string> joint_name_keys(const std::vector<std::string>& names)
{
    constexpr double most = 0.8;
    std::vector<JointName> parsed = parse_joint_names(names);
    // A word must be left: what has numbers alone has no name.
    const auto has_prefix = [](const JointName& name) {
        return name.parts.size() > 1 && std::any_of(name.parts.begin() + 1, name.parts.end(),
                                                    [](const std::string& part) { return !is_digit(part[0]); });
    };
    while (true) {
        std::map<std::string, int> first;
        for (const JointName& name : parsed) {
            if (has_prefix(name)) ++first[name.parts.front()];
        }
        const auto common = std::max_element(first.begin(), first.end(),
                                             [](const auto& a, const auto& b) { return a.second < b.second; });
        if (common == first.end() || common->second < most * static_cast<double>(parsed.size())) break;
        const std::string prefix = common->first;
        for (JointName& name : parsed) {
            if (has_prefix(name) && name.parts.front() == prefix) name.parts.erase(name.parts.begin());
        }
    }
    std::vector<std::string> keys;
    for (const JointName& name : parsed) {
        std::string key = name.side == Side::none ? "" : name.side == Side::left ? "l " : "r ";
        for (std::size_t k = 0; k < name.parts.size(); ++k) {
            // Two numbers side by side would read as another one.
            const bool numbers = k > 0 && is_digit(name.parts[k][0]) && is_digit(name.parts[k - 1][0]);
            key += (numbers ? " " : "") + name.parts[k];
        }
        keys.push_back(key);
    }
    return keys;
}

}  // namespace ndg
