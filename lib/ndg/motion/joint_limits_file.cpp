// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/angles.h"
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/motion/joint_limits.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace ndg {

namespace {

constexpr double largest_swing = 160.0 * radians_per_degree;

class LimitReader {
public:
    JointLimitTable read(const std::string& path)
    {
        const JsonValue root(path);
        table_.path = path;
        root.check_keys({"description", "standard_deviations", "unlisted_degrees", "sources", "joints"});
        deviations_ = root.at("standard_deviations").number(0.0, 10.0);
        unlisted_ = root.at("unlisted_degrees").number(0.0, 90.0) * radians_per_degree;
        for (const auto& [name, value] : root.at("sources").members()) sources_.insert(name);
        for (const auto& [name, value] : root.at("joints").members()) add(name, value);
        std::sort(table_.ranges.begin(), table_.ranges.end(),
                  [](const JointRange& a, const JointRange& b) { return a.joint < b.joint; });
        return table_;
    }

private:
    static int find_joint(const std::string& name)
    {
        const auto& names = standard_skeleton().joint_names;
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? -1 : static_cast<int>(found - names.begin());
    }

    void add(const std::string& name, const JsonValue& value)
    {
        value.check_keys({"base", "long_axis", "cone", "swing", "axes", "levels", "x", "y", "z"});
        if (find_joint(name) >= 0) {
            table_.ranges.push_back(read_range(name, "", value));
            return;
        }
        require_input(find_joint("left_" + name) >= 0, "{}: \"{}\" is not one of our joints", table_.path, name);
        table_.ranges.push_back(read_range(name, "left_", value));
        JointRange right = read_range(name, "right_", value);
        // A mirror image turns the other way about y and z.
        for (const std::size_t axis : {std::size_t(1), std::size_t(2)}) {
            std::swap(right.low[axis], right.high[axis]);
            right.low[axis] *= -1.0;
            right.high[axis] *= -1.0;
        }
        table_.ranges.push_back(right);
    }

    JointRange read_range(const std::string& name, const std::string& side, const JsonValue& value) const
    {
        JointRange range;
        range.joint = find_joint(side + name);
        range.base = standard_skeleton().parents[range.joint];
        require_input(range.base >= 0, "{}: the root \"{}\" can have no range", table_.path, name);
        const std::string base = value.text_or("base", "");
        if (!base.empty()) {
            range.base = find_joint(base) >= 0 ? find_joint(base) : find_joint(side + base);
            bool above = false;
            for (int j = range.joint; j >= 0; j = standard_skeleton().parents[j]) above = above || j == range.base;
            require_input(range.base >= 0 && range.base != range.joint && above,
                          "{}: \"base\" of \"{}\" is \"{}\", not a joint above it", table_.path, name, base);
        }
        const auto is_second = [&](const char* key, const char* first, const char* second) {
            return value.has(key) && value.at(key).choice({first, second}) == 1;
        };
        range.long_axis = value.at("long_axis").choice({"x", "y", "z"});
        range.ellipse = value.has("cone") && !is_second("cone", "ellipse", "box");
        range.swing_after = is_second("swing", "proximal", "distal");
        range.thumb_axes = is_second("axes", "body", "thumb");
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string key(1, static_cast<char>('x' + k));
            range.low[k] = -unlisted_;
            range.high[k] = unlisted_;
            if (!value.has(key)) continue;
            const JsonValue borders = value.at(key);
            borders.check_keys({"-", "+"});
            if (borders.has("-")) range.low[k] = -degrees(borders.at("-"));
            if (borders.has("+")) range.high[k] = degrees(borders.at("+"));
            require_input(range.low[k] < range.high[k] && range.high[k] - range.low[k] < 2.0 * largest_swing,
                          "{}: the range of \"{}\" about {} is {} to {} degrees", table_.path, name, key,
                          range.low[k] / radians_per_degree, range.high[k] / radians_per_degree);
        }
        check_swing(range, name);
        return range;
    }

    void check_swing(const JointRange& range, const std::string& name) const
    {
        double square = 0.0, widest = 0.0;
        for (int k = 0; k < 3; ++k) {
            if (k == range.long_axis) continue;
            square += std::pow(std::max(std::abs(range.low[k]), std::abs(range.high[k])), 2);
            widest = std::max(widest, 0.5 * (range.high[k] - range.low[k]));
        }
        const double reach = range.ellipse ? widest : std::sqrt(square);
        require_input(reach <= largest_swing, "{}: the swing of \"{}\" reaches {} degrees from its middle, at most 160",
                      table_.path, name, reach / radians_per_degree);
    }

    /// One border: published mean, plus deviations, times the share of this joint.
    double degrees(const JsonValue& border) const
    {
        border.check_keys({"motion", "degrees", "sd", "share", "source"});
        std::string sources = border.at("source").text();
        while (!sources.empty()) {
            const std::size_t comma = sources.find(", ");
            const std::string source = sources.substr(0, comma);
            require_input(sources_.count(source) > 0, "{}: source \"{}\" is not among the sources", border.where(),
                          source);
            sources = comma == std::string::npos ? "" : sources.substr(comma + 2);
        }
        const double mean = border.at("degrees").number(-180.0, 200.0);
        const double deviation = border.number_or("sd", 0.0, 0.0, 90.0);
        const double share = border.number_or("share", 1.0, 0.0, 1.0);
        return share * (mean + deviations_ * deviation) * radians_per_degree;
    }

    JointLimitTable table_;
    std::set<std::string> sources_;
    double deviations_ = 0.0, unlisted_ = 0.0;
};

}  // namespace

JointLimitTable read_joint_limits(const std::string& path)
{
    return LimitReader().read(path);
}

}  // namespace ndg
