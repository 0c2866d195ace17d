// SPDX-License-Identifier: Apache-2.0
// Reads motions written by hand.
#include "ndg/core/error.h"
#include "ndg/motion/keyframes.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>

namespace ndg {

namespace {

using nlohmann::json;

constexpr double degree = M_PI / 180.0;
const std::string format_name = "ndg-keyframes";

/// One clinical angle behind a name of the file.
struct Target {
    int angle;
    double share;   ///< of the written value
    bool opposite;  ///< half a period later
};

class MotionReader {
public:
    explicit MotionReader(const std::string& path)
    {
        motion_.path = path;
        motion_.name = std::filesystem::path(path).stem().string();
        motion_.stance.assign(clinical_angle_names().size(), 0.0);
    }

    KeyframeMotion read(const json& root)
    {
        check_keys(root,
                   {"format", "licence", "description", "sources", "frame_rate", "duration", "period", "ground",
                    "stance", "tracks", "poses"},
                   "the motion");
        require_input(root.contains("format") && root["format"] == format_name, "{}: \"format\" is not \"{}\"",
                      motion_.path, format_name);
        motion_.licence = text(root, "licence");
        require_input(!motion_.licence.empty(), "{}: has no \"licence\"", motion_.path);
        motion_.description = text(root, "description");
        motion_.frame_rate = positive(root, "frame_rate", 1000.0);
        motion_.duration = positive(root, "duration", 3600.0);
        if (root.contains("period")) {
            motion_.period = positive(root, "period", motion_.duration);
        }
        read_ground(root);
        if (root.contains("stance")) {
            for (const auto& [name, value] : object(root, "stance").items()) {
                for (const Target& target : resolve(name)) {
                    motion_.stance[std::size_t(target.angle)] = target.share * number(value, name) * degree;
                }
            }
        }
        if (root.contains("tracks")) {
            for (const auto& [name, keys] : object(root, "tracks").items()) read_track(name, keys);
        }
        if (root.contains("poses")) read_poses(root["poses"]);
        require_input(!motion_.tracks.empty(), "{}: has neither tracks nor poses", motion_.path);
        return motion_;
    }

private:
    double last_time() const { return motion_.period > 0.0 ? motion_.period : motion_.duration; }

    void check_keys(const json& value, const std::vector<std::string>& known, const std::string& where) const
    {
        require_input(value.is_object(), "{}: {} is not a JSON object", motion_.path, where);
        for (const auto& item : value.items()) {
            require_input(std::find(known.begin(), known.end(), item.key()) != known.end(),
                          "{}: unknown key \"{}\" in {}", motion_.path, item.key(), where);
        }
    }

    const json& object(const json& root, const char* key) const
    {
        require_input(root[key].is_object(), "{}: \"{}\" is not a JSON object", motion_.path, key);
        return root[key];
    }

    std::string text(const json& root, const char* key) const
    {
        if (!root.contains(key)) return "";
        require_input(root[key].is_string(), "{}: \"{}\" is {}, not text", motion_.path, key, root[key].dump());
        return root[key].get<std::string>();
    }

    double number(const json& value, const std::string& where) const
    {
        require_input(value.is_number() && std::isfinite(value.get<double>()), "{}: \"{}\" has the value {}, no number",
                      motion_.path, where, value.dump());
        return value.get<double>();
    }

    double positive(const json& root, const char* key, double high) const
    {
        require_input(root.contains(key), "{}: has no \"{}\"", motion_.path, key);
        const double value = number(root[key], key);
        require_input(value > 0.0 && value <= high, "{}: \"{}\" is {}, not in (0, {}]", motion_.path, key, value, high);
        return value;
    }

    void read_ground(const json& root)
    {
        if (!root.contains("ground")) return;
        const std::map<std::string, Ground> names = {
            {"none", Ground::none}, {"lowest_foot", Ground::lowest_foot}, {"both_feet", Ground::both_feet}};
        const auto found = names.find(text(root, "ground"));
        require_input(found != names.end(), "{}: \"ground\" is {}, not none, lowest_foot or both_feet", motion_.path,
                      root["ground"].dump());
        motion_.ground = found->second;
    }

    /// Angles of one side or of the middle that a name stands for.
    std::vector<Target> resolve_side(const std::string& name, const std::string& written, bool opposite) const
    {
        std::vector<Target> targets;
        const auto add = [&](const std::string& angle_name, double share) {
            const int angle = find_clinical_angle(angle_name);
            require_input(angle >= 0, "{}: unknown angle \"{}\"", motion_.path, written);
            targets.push_back({angle, share, opposite});
        };
        for (const std::string side : {"left_", "right_"}) {
            if (name == side + "fingers.curl") {
                // Of a fist the middle joints bend most, the end joints least (AAOS 1965: 90, 100 and 70 degrees).
                for (const char* finger : {"index", "middle", "ring", "pinky"}) {
                    add(side + finger + "_1.flexion", 0.9);
                    add(side + finger + "_2.flexion", 1.0);
                    add(side + finger + "_3.flexion", 0.7);
                }
                return targets;
            }
            if (name == side + "fingers.spread") {
                add(side + "index_1.spread", 1.0);
                add(side + "ring_1.spread", -0.6);
                add(side + "pinky_1.spread", -1.2);
                return targets;
            }
        }
        add(name, 1.0);
        return targets;
    }

    std::vector<Target> resolve(const std::string& name) const
    {
        for (const std::string prefix : {"both_", "alternating_"}) {
            if (name.rfind(prefix, 0) != 0) continue;
            const std::string rest = name.substr(prefix.size());
            const bool alternating = prefix == "alternating_";
            require_input(!alternating || motion_.period > 0.0, "{}: \"{}\" needs a \"period\"", motion_.path, name);
            std::vector<Target> targets = resolve_side("left_" + rest, name, false);
            for (const Target& target : resolve_side("right_" + rest, name, alternating)) targets.push_back(target);
            return targets;
        }
        return resolve_side(name, name, false);
    }

    void add_track(const std::string& name, const std::vector<double>& times, const std::vector<double>& degrees)
    {
        for (const Target& target : resolve(name)) {
            require_input(tracked_.insert(target.angle).second, "{}: angle \"{}\" has two tracks", motion_.path,
                          clinical_angle_names()[std::size_t(target.angle)]);
            std::vector<std::pair<double, double>> keys;
            for (std::size_t k = 0; k < times.size(); ++k) {
                double time = times[k];
                if (target.opposite) time = std::fmod(time + 0.5 * motion_.period, motion_.period);
                keys.emplace_back(time, target.share * degrees[k] * degree);
            }
            std::sort(keys.begin(), keys.end());
            KeyframeTrack track;
            track.angle = target.angle;
            for (const auto& [time, value] : keys) {
                track.times.push_back(time);
                track.values.push_back(value);
            }
            motion_.tracks.push_back(std::move(track));
        }
    }

    void check_time(double time, double previous, const std::string& where) const
    {
        require_input(time > previous, "{}: {}: time {} does not come after {}", motion_.path, where, time, previous);
        // The end of a cycle is the beginning of the next.
        const bool inside = time >= 0.0 && (motion_.period > 0.0 ? time < last_time() : time <= last_time());
        require_input(inside, "{}: {}: time {} lies outside 0 to {}", motion_.path, where, time, last_time());
    }

    void read_track(const std::string& name, const json& keys)
    {
        require_input(keys.is_array() && !keys.empty(), "{}: track \"{}\" is no list of keys", motion_.path, name);
        std::vector<double> times, values;
        for (const json& key : keys) {
            require_input(key.is_array() && key.size() == 2, "{}: track \"{}\" has the key {}, not [time, degrees]",
                          motion_.path, name, key.dump());
            const double time = number(key[0], name);
            check_time(time, times.empty() ? -1.0 : times.back(), fmt::format("track \"{}\"", name));
            times.push_back(time);
            values.push_back(number(key[1], name));
        }
        add_track(name, times, values);
    }

    void read_poses(const json& list)
    {
        require_input(list.is_array() && !list.empty(), "{}: \"poses\" is no list", motion_.path);
        std::vector<double> times;
        std::map<int, std::vector<double>> values;  // by angle, in radians
        for (const json& item : list) {
            check_keys(item, {"time", "angles", "comment"}, "a pose");
            require_input(item.contains("time") && item.contains("angles"), "{}: a pose lacks \"time\" or \"angles\"",
                          motion_.path);
            const double time = number(item["time"], "time");
            check_time(time, times.empty() ? -1.0 : times.back(), "pose");
            times.push_back(time);
            for (const auto& [name, value] : object(item, "angles").items()) {
                for (const Target& target : resolve(name)) {
                    std::vector<double>& track = values[target.angle];
                    require_input(track.size() < times.size(), "{}: pose at {} s: angle \"{}\" is given twice",
                                  motion_.path, time, clinical_angle_names()[std::size_t(target.angle)]);
                    require_input(!target.opposite, "{}: pose at {} s: \"{}\" belongs in a track", motion_.path, time,
                                  name);
                    // Poses before that did not name it.
                    track.resize(times.size() - 1, motion_.stance[std::size_t(target.angle)]);
                    track.push_back(target.share * number(value, name) * degree);
                }
            }
            for (auto& [angle, track] : values) track.resize(times.size(), motion_.stance[std::size_t(angle)]);
        }
        for (auto& [angle, track] : values) {
            require_input(tracked_.insert(angle).second, "{}: angle \"{}\" has a track and a pose", motion_.path,
                          clinical_angle_names()[std::size_t(angle)]);
            motion_.tracks.push_back({angle, times, track});
        }
    }

    KeyframeMotion motion_;
    std::set<int> tracked_;
};

}  // namespace

bool is_keyframe_motion(const std::string& path)
{
    if (std::filesystem::path(path).extension() != ".json") return false;
    std::ifstream file(path, std::ios::binary);
    std::string head(1024, '\0');
    file.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(file.gcount()));
    return head.find("\"" + format_name + "\"") != std::string::npos;
}

KeyframeMotion read_keyframe_motion(const std::string& path)
{
    std::ifstream file(path);
    require_input(file.good(), "{}: cannot be read", path);
    json root;
    try {
        root = json::parse(file);
    } catch (const json::exception& error) {
        throw InputError(fmt::format("{}: is not valid JSON: {}", path, error.what()));
    }
    return MotionReader(path).read(root);
}

}  // namespace ndg
