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
    std::string joined;  ///< the words without a gap

    /// Whether the joined words contain `word`.
    bool has(const std::string& word) const { return joined.find(word) != std::string::npos; }
};

/// One of each name. A single letter l or r counts as a side where the other side's name exists.
std::vector<JointName> parse_joint_names(const std::vector<std::string>& names);

}  // namespace ndg
