// SPDX-License-Identifier: Apache-2.0
// What the names of a skeleton's joints say.
#pragma once

#include <string>
#include <vector>

namespace ndg {

enum class Side { none, left, right };

/// A name taken apart: "mixamorig:LeftForeArm" is left, {"fore", "arm"}; "lShldr" is left, {"shldr"} where the skeleton
/// has "rShldr" too.
struct JointName {
    Side side = Side::none;
    std::vector<std::string> words;  ///< lower case, without namespace, side and numbers
    std::vector<int> numbers;
    std::string joined;              ///< the words without a gap
    std::vector<std::string> parts;  ///< words and numbers (without leading zeros) in their order

    /// Whether the joined words contain `word`.
    bool has(const std::string& word) const { return joined.find(word) != std::string::npos; }
};

/// One of each name. A single letter l or r counts as a side where the other side's name exists.
std::vector<JointName> parse_joint_names(const std::vector<std::string>& names);

/// One key of each name that is the same however a program spells it: "mixamorig:LeftForeArm",
/// "mixamorig1_LeftForeArm", "LeftForeArm", "DEF-forearm.L" and "forearm_l" have one key in common. What four of five
/// names begin with (a prefix of the rig) does not count, nor do separators, case, and zeros before numbers.
std::vector<std::string> joint_name_keys(const std::vector<std::string>& names);

}  // namespace ndg
