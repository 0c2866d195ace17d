// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/motion/joint_limits.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

using nlohmann::json;

constexpr double radians_per_degree = M_PI / 180.0;
constexpr double largest_swing = 160.0 * radians_per_degree;

class LimitReader {
public:
    explicit LimitReader(const std::string& path) { table_.path = path; }

    JointLimitTable read(const json& root)
    {
        check_keys(root, {"description", "standard_deviations", "unlisted_degrees", "sources", "joints"}, "the file");
        deviations_ = number(root, "standard_deviations", "the file", 0.0, 10.0);
        unlisted_ = number(root, "unlisted_degrees", "the file", 0.0, 90.0) * radians_per_degree;
        require_input(root.contains("sources") && root["sources"].is_object(), "{}: has no object \"sources\"",
                      table_.path);
        require_input(root.contains("joints") && root["joints"].is_object(), "{}: has no object \"joints\"",
                      table_.path);
        sources_ = root["sources"];
        for (const auto& [name, value] : root["joints"].items()) add(name, value);
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

    void add(const std::string& name, const json& value)
    {
        check_keys(value, {"base", "long_axis", "cone", "swing", "axes", "levels", "x", "y", "z"}, name);
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

    JointRange read_range(const std::string& name, const std::string& side, const json& value) const
    {
        JointRange range;
        range.joint = find_joint(side + name);
        range.base = standard_skeleton().parents[range.joint];
        require_input(range.base >= 0, "{}: the root \"{}\" can have no range", table_.path, name);
        const std::string base = choice(value, "base", name, {});
        if (!base.empty()) {
            range.base = find_joint(base) >= 0 ? find_joint(base) : find_joint(side + base);
            bool above = false;
            for (int j = range.joint; j >= 0; j = standard_skeleton().parents[j]) above = above || j == range.base;
            require_input(range.base >= 0 && range.base != range.joint && above,
                          "{}: \"base\" of \"{}\" is \"{}\", not a joint above it", table_.path, name, base);
        }
        const std::string axis = choice(value, "long_axis", name, {"x", "y", "z"});
        require_input(!axis.empty(), "{}: \"{}\" has no \"long_axis\"", table_.path, name);
        range.long_axis = axis[0] - 'x';
        range.ellipse = choice(value, "cone", name, {"ellipse", "box"}) == "ellipse";
        range.swing_after = choice(value, "swing", name, {"proximal", "distal"}) == "distal";
        range.thumb_axes = choice(value, "axes", name, {"body", "thumb"}) == "thumb";
        for (std::size_t k = 0; k < 3; ++k) {
            const std::string key(1, static_cast<char>('x' + k));
            range.low[k] = -unlisted_;
            range.high[k] = unlisted_;
            if (!value.contains(key)) continue;
            check_keys(value[key], {"-", "+"}, name);
            if (value[key].contains("-")) range.low[k] = -degrees(value[key]["-"], name);
            if (value[key].contains("+")) range.high[k] = degrees(value[key]["+"], name);
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
    double degrees(const json& border, const std::string& name) const
    {
        check_keys(border, {"motion", "degrees", "sd", "share", "source"}, name);
        require_input(border.contains("source") && border["source"].is_string(), "{}: a border of \"{}\" has no source",
                      table_.path, name);
        std::string sources = border["source"].get<std::string>();
        while (!sources.empty()) {
            const std::size_t comma = sources.find(", ");
            const std::string source = sources.substr(0, comma);
            require_input(sources_.contains(source), "{}: source \"{}\" of \"{}\" is not among the sources",
                          table_.path, source, name);
            sources = comma == std::string::npos ? "" : sources.substr(comma + 2);
        }
        const double mean = number(border, "degrees", name, -180.0, 200.0);
        const double deviation = border.contains("sd") ? number(border, "sd", name, 0.0, 90.0) : 0.0;
        const double share = border.contains("share") ? number(border, "share", name, 0.0, 1.0) : 1.0;
        return share * (mean + deviations_ * deviation) * radians_per_degree;
    }

    double number(const json& object, const char* key, const std::string& where, double low, double high) const
    {
        require_input(object.contains(key) && object[key].is_number() && object[key] >= low && object[key] <= high,
                      "{}: \"{}\" of \"{}\" is {}, not a number of {} to {}", table_.path, key, where,
                      object.contains(key) ? object[key].dump() : "missing", low, high);
        return object[key].get<double>();
    }

    /// Text of `object`, "" where it is missing; `allowed` empty: any.
    std::string choice(const json& object, const char* key, const std::string& where,
                       const std::vector<std::string>& allowed) const
    {
        if (!object.contains(key)) return "";
        const json& value = object[key];
        require_input(value.is_string() && (allowed.empty() || std::find(allowed.begin(), allowed.end(),
                                                                         value.get<std::string>()) != allowed.end()),
                      "{}: \"{}\" of \"{}\" is {}, not {}", table_.path, key, where, value.dump(),
                      allowed.empty() ? "text" : fmt::format("one of {}", fmt::join(allowed, ", ")));
        return value.get<std::string>();
    }

    void check_keys(const json& object, const std::vector<std::string>& known, const std::string& where) const
    {
        require_input(object.is_object(), "{}: {} is not a JSON object", table_.path, where);
        for (const auto& item : object.items()) {
            require_input(std::find(known.begin(), known.end(), item.key()) != known.end(),
                          "{}: unknown key \"{}\" in {}", table_.path, item.key(), where);
        }
    }

    JointLimitTable table_;
    json sources_;
    double deviations_ = 0.0, unlisted_ = 0.0;
};

}  // namespace

JointLimitTable read_joint_limits(const std::string& path)
{
    json root;
    try {
        root = json::parse(read_file(path));
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: is not valid JSON: {}", path, error.what()));
    }
    return LimitReader(path).read(root);
}

}  // namespace ndg
