// SPDX-License-Identifier: Apache-2.0
// Reads motions written by hand.
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/motion/keyframes.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>

namespace ndg {

namespace {

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

    KeyframeMotion read(const JsonValue& root)
    {
        root.check_keys({"format", "licence", "description", "sources", "frame_rate", "duration", "period", "ground",
                         "lift", "stance", "tracks", "poses"});
        root.at("format").choice({format_name});
        motion_.licence = root.at("licence").text();
        require_input(!motion_.licence.empty(), "{}: has no \"licence\"", motion_.path);
        motion_.description = root.text_or("description", "");
        motion_.frame_rate = positive(root.at("frame_rate"), 1000.0);
        motion_.duration = positive(root.at("duration"), 3600.0);
        if (root.has("period")) motion_.period = positive(root.at("period"), motion_.duration);
        if (root.has("ground")) {
            constexpr Ground grounds[] = {Ground::none, Ground::lowest_foot, Ground::both_feet};
            motion_.ground = grounds[root.at("ground").choice({"none", "lowest_foot", "both_feet"})];
        }
        if (root.has("stance")) {
            for (const auto& [name, value] : root.at("stance").members()) {
                for (const Target& target : resolve(name)) {
                    motion_.stance[target.angle] = target.share * value.number() * degree;
                }
            }
        }
        if (root.has("tracks")) {
            for (const auto& [name, keys] : root.at("tracks").members()) read_track(name, keys);
        }
        if (root.has("lift")) read_lift(root.at("lift"));
        if (root.has("poses")) read_poses(root.at("poses"));
        require_input(!motion_.tracks.empty(), "{}: has neither tracks nor poses", motion_.path);
        return motion_;
    }

private:
    double last_time() const { return motion_.period > 0.0 ? motion_.period : motion_.duration; }

    static double positive(const JsonValue& value, double high)
    {
        value.expect(value.number() > 0.0 && value.number() <= high, fmt::format("a number in (0, {}]", high));
        return value.number();
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

    /// A time after `previous`, within the motion.
    double read_time(const JsonValue& value, double previous) const
    {
        const double time = value.number();
        require_input(time > previous, "{}: time {} does not come after {}", value.where(), time, previous);
        // The end of a cycle is the beginning of the next.
        const bool inside = time >= 0.0 && (motion_.period > 0.0 ? time < last_time() : time <= last_time());
        require_input(inside, "{}: time {} lies outside 0 to {}", value.where(), time, last_time());
        return time;
    }

    void read_keys(const JsonValue& keys, const char* expected, double low, std::vector<double>& times,
                   std::vector<double>& values) const
    {
        for (const JsonValue& key : keys.elements()) {
            key.expect(key.is_list() && key.elements().size() == 2, expected);
            const std::vector<JsonValue> pair = key.elements();
            times.push_back(read_time(pair[0], times.empty() ? -1.0 : times.back()));
            values.push_back(pair[1].number(low));
        }
        keys.expect(!times.empty(), "a list of keys");
    }

    void read_track(const std::string& name, const JsonValue& keys)
    {
        std::vector<double> times, values;
        read_keys(keys, "[time, degrees]", std::numeric_limits<double>::lowest(), times, values);
        add_track(name, times, values);
    }

    void read_lift(const JsonValue& keys)
    {
        require_input(motion_.ground != Ground::none,
                      "{}: \"lift\" is a height above the ground, which needs \"ground\"", motion_.path);
        read_keys(keys, "[time, metres]", 0, motion_.lift.times, motion_.lift.values);
    }

    void read_poses(const JsonValue& list)
    {
        std::vector<double> times;
        std::map<int, std::vector<double>> values;  // by angle, in radians
        for (const JsonValue& item : list.elements()) {
            item.check_keys({"time", "angles", "comment"});
            times.push_back(read_time(item.at("time"), times.empty() ? -1.0 : times.back()));
            for (const auto& [name, value] : item.at("angles").members()) {
                for (const Target& target : resolve(name)) {
                    std::vector<double>& track = values[target.angle];
                    require_input(track.size() < times.size(), "{}: angle \"{}\" is given twice", item.where(),
                                  clinical_angle_names()[target.angle]);
                    require_input(!target.opposite, "{}: belongs in a track", value.where());
                    // Poses before that did not name it.
                    track.resize(times.size() - 1, motion_.stance[target.angle]);
                    track.push_back(target.share * value.number() * degree);
                }
            }
            for (auto& [angle, track] : values) track.resize(times.size(), motion_.stance[angle]);
        }
        list.expect(!times.empty(), "a list of poses");
        for (auto& [angle, track] : values) {
            require_input(tracked_.insert(angle).second, "{}: angle \"{}\" has a track and a pose", motion_.path,
                          clinical_angle_names()[angle]);
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
    head.resize(file.gcount());
    return head.find("\"" + format_name + "\"") != std::string::npos;
}

KeyframeMotion read_keyframe_motion(const std::string& path)
{
    return MotionReader(path).read(JsonValue(path));
}

}  // namespace ndg
