// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/landmarks.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"

#include <array>
#include <cmath>
#include <functional>

namespace ndg {
namespace {

/// Height of the navel as a share of stature: waist height (omphalion) 105.6 of 175.6 cm for men, 98.2 of 162.9 cm for
/// women (Gordon et al. 1989, 1988 Anthropometric Survey of U.S. Army Personnel).
constexpr double navel_share = 0.60;

/// The skin with one side turned to +x, so that a definition for the left serves both.
class Side {
public:
    Side(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const RowMatrix>& weights,
         const Eigen::Ref<const Points>& joint_positions, const std::string& prefix)
        : points_(vertices),
          weights_(weights),
          joint_positions_(joint_positions),
          prefix_(prefix),
          sign_(prefix == "right_" ? -1.0 : 1.0),
          stature_(vertices.col(1).maxCoeff() - vertices.col(1).minCoeff())
    {
        points_.col(0) *= sign_;
        joint_positions_.col(0) *= sign_;
    }

    double stature() const { return stature_; }
    /// Length scaled from a body of 1.75 m.
    double scaled(double metres) const { return metres * stature_ / 1.75; }
    Eigen::Vector3d joint(const std::string& name) const
    {
        return joint_positions_.row(standard_skeleton().joint(name)).transpose();
    }
    Eigen::Vector3d own_joint(const std::string& name) const { return joint(prefix_ + name); }

    /// The vertex with the greatest score among those that hang on `joints` (with all joints below them) by more than
    /// half, and that `where` accepts. Joints that start with '*' are of this side.
    Eigen::Vector3d find(const std::string& landmark, const std::vector<std::string>& joints,
                         const std::function<bool(const Eigen::Vector3d&)>& where,
                         const std::function<double(const Eigen::Vector3d&)>& score) const
    {
        const Eigen::VectorXd share = share_of(joints);
        // Rounded, and then by place, so that equal scores give mirrored points on both sides.
        std::array<double, 4> best{};
        Eigen::Index found = -1;
        for (Eigen::Index v = 0; v < points_.rows(); ++v) {
            const Eigen::Vector3d point = points_.row(v).transpose();
            if (share[v] <= 0.5 || !where(point)) continue;
            constexpr double resolution = 1e7;
            const std::array<double, 4> rank{std::round(resolution * score(point)), std::round(resolution * point[2]),
                                             std::round(resolution * point[1]), std::round(resolution * point[0])};
            if (found >= 0 && rank <= best) continue;
            best = rank;
            found = v;
        }
        require_input(found >= 0, "the skin has no place for landmark {}{}", prefix_, landmark);
        return points_.row(found).transpose();
    }

    NamedPoint named(const std::string& landmark, const Eigen::Vector3d& point) const
    {
        return {prefix_ + landmark, {sign_ * point[0], point[1], point[2]}};
    }

private:
    Eigen::VectorXd share_of(const std::vector<std::string>& joints) const
    {
        const Skeleton& skeleton = standard_skeleton();
        std::vector<char> counts(skeleton.num_joints(), 0);
        for (const std::string& name : joints)
            counts[skeleton.joint(name[0] == '*' ? prefix_ + name.substr(1) : name)] = 1;
        Eigen::VectorXd share = Eigen::VectorXd::Zero(weights_.rows());
        for (int j = 0; j < skeleton.num_joints(); ++j)
            if (counts[j]) share += weights_.col(j);
        return share;
    }

    Points points_;
    const Eigen::Ref<const RowMatrix>& weights_;
    Points joint_positions_;
    std::string prefix_;
    double sign_, stature_;
};

/// A joint and everything below it.
std::vector<std::string> with_children(const std::string& joint)
{
    const Skeleton& skeleton = standard_skeleton();
    std::vector<std::string> names;
    std::vector<char> below(skeleton.num_joints(), 0);
    for (int j = skeleton.joint(joint); j < skeleton.num_joints(); ++j) {
        const int parent = skeleton.parents[j];
        if (j != skeleton.joint(joint) && (parent < 0 || !below[parent])) continue;
        below[j] = 1;
        names.push_back(skeleton.joint_names[j]);
    }
    return names;
}

void add_midline(const Side& body, std::vector<NamedPoint>& landmarks)
{
    using Point = Eigen::Vector3d;
    const double strip = body.scaled(0.015);  // half its width
    const auto near_midline = [&](const Point& p) { return std::abs(p[0]) < strip; };
    const std::vector<std::string> head = with_children("head");
    std::vector<std::string> trunk = {"pelvis",  "spine_1", "spine_2",       "spine_3",        "spine_4",
                                      "spine_5", "neck_1",  "left_clavicle", "right_clavicle", "neck_2"};
    const auto add = [&](const std::string& name, const Point& point) {
        landmarks.push_back({name, {0.0, point[1], point[2]}});
        return point;
    };
    const double eye_level = 0.5 * (body.joint("left_eye")[1] + body.joint("right_eye")[1]);
    const Point vertex =
        add("vertex", body.find(
                          "vertex", head, [](const Point&) { return true; }, [](const Point& p) { return p[1]; }));
    const double face = vertex[1] - eye_level;
    // The brow ridge: foremost between the eyes' level and a third of the way to the vertex.
    add("glabella", body.find(
                        "glabella", head,
                        [&](const Point& p) {
                            return near_midline(p) && p[1] > eye_level + 0.1 * face && p[1] < eye_level + 0.35 * face;
                        },
                        [](const Point& p) { return p[2] - std::abs(p[0]); }));
    const Point nose =
        add("nasal_tip", body.find(
                             "nasal_tip", head, [&](const Point& p) { return near_midline(p) && p[1] < eye_level; },
                             [](const Point& p) { return p[2]; }));
    // The chin's foremost and lowest point, seen from 45 degrees below.
    add("chin", body.find(
                    "chin", head, [&](const Point& p) { return near_midline(p) && p[1] < nose[1] - 0.25 * face; },
                    [](const Point& p) { return p[2] - p[1]; }));
    add("opisthocranion", body.find("opisthocranion", head, near_midline, [](const Point& p) { return -p[2]; }));
    // Spinous process of C7, at the root of the neck; the neck's lowest joint lies before it.
    const Point neck = body.joint("neck_1");
    add("cervicale", body.find(
                         "cervicale", trunk, [&](const Point& p) { return near_midline(p) && p[2] < neck[2]; },
                         [&](const Point& p) { return -std::abs(p[1] - neck[1]) - std::abs(p[0]); }));
    // Jugular notch, between the inner ends of the clavicles.
    const Point clavicle = 0.5 * (body.joint("left_clavicle") + body.joint("right_clavicle"));
    add("suprasternale",
        body.find(
            "suprasternale", trunk, [&](const Point& p) { return near_midline(p) && p[2] > clavicle[2]; },
            [&](const Point& p) { return -std::abs(p[1] - clavicle[1]) - std::abs(p[0]); }));
    const double floor = vertex[1] - body.stature();
    const Point pelvis = body.joint("pelvis");
    add("navel",
        body.find(
            "navel", trunk, [&](const Point& p) { return near_midline(p) && p[2] > pelvis[2]; },
            [&](const Point& p) { return -std::abs(p[1] - floor - navel_share * body.stature()) - std::abs(p[0]); }));
    trunk.insert(trunk.end(), {"left_thigh", "right_thigh"});
    const double knee = body.joint("left_shin")[1], hip = body.joint("left_thigh")[1];
    add("crotch", body.find(
                      "crotch", trunk,
                      [&](const Point& p) { return std::abs(p[0]) < 0.5 * strip && p[1] > 0.4 * knee + 0.6 * hip; },
                      [](const Point& p) { return -p[1] - std::abs(p[0]); }));
}

void add_arm(const Side& side, std::vector<NamedPoint>& landmarks)
{
    using Point = Eigen::Vector3d;
    const Point shoulder = side.own_joint("upper_arm"), elbow = side.own_joint("forearm"),
                wrist = side.own_joint("hand");
    const auto within = [](const Point& centre, double radius) {
        return [centre, radius](const Point& p) { return (p - centre).norm() < radius; };
    };
    const auto add = [&](const std::string& name, const Point& point) { landmarks.push_back(side.named(name, point)); };
    // The shoulder's corner, seen from 45 degrees above the side.
    add("acromion", side.find("acromion", {"*clavicle", "*upper_arm", "spine_5", "spine_4"},
                              within(shoulder, side.scaled(0.11)), [](const Point& p) { return p[0] + p[1]; }));
    // Rearmost point of the elbow, square to the arm.
    const Point arm = (wrist - shoulder).normalized();
    const Point backward = (-Point::UnitZ() + arm[2] * arm).normalized();
    add("olecranon", side.find("olecranon", {"*upper_arm", "*forearm", "*forearm_twist"},
                               within(elbow, side.scaled(0.07)), [&](const Point& p) { return backward.dot(p); }));
    // Thumb side and little finger's side of the wrist, square to the forearm.
    const Point forearm = (wrist - elbow).normalized();
    const Point across = side.own_joint("index_1") - side.own_joint("pinky_1");
    const Point radial = (across - across.dot(forearm) * forearm).normalized();
    const auto at_wrist = [&](const Point& p) { return std::abs((p - wrist).dot(forearm)) < side.scaled(0.02); };
    std::vector<std::string> hand = with_children(side.named("hand", wrist).name);
    std::vector<std::string> wrist_parts = {"*forearm", "*forearm_twist"};
    wrist_parts.insert(wrist_parts.end(), hand.begin(), hand.end());
    add("wrist_radial",
        side.find("wrist_radial", wrist_parts, at_wrist, [&](const Point& p) { return radial.dot(p); }));
    add("wrist_ulnar", side.find("wrist_ulnar", wrist_parts, at_wrist, [&](const Point& p) { return -radial.dot(p); }));
    const Point finger = (side.own_joint("middle_3") - side.own_joint("middle_1")).normalized();
    add("fingertip", side.find(
                         "fingertip", {"*middle_1", "*middle_2", "*middle_3"}, [](const Point&) { return true; },
                         [&](const Point& p) { return finger.dot(p); }));
}

void add_leg(const Side& side, std::vector<NamedPoint>& landmarks)
{
    using Point = Eigen::Vector3d;
    const Point hip = side.own_joint("thigh"), knee = side.own_joint("shin"), ankle = side.own_joint("foot"),
                ball = side.own_joint("toes");
    const auto level = [&](double height, double half_width) {
        const double low = height - side.scaled(half_width), high = height + side.scaled(half_width);
        return [low, high](const Point& p) { return p[0] > 0.0 && p[1] > low && p[1] < high; };
    };
    const auto add = [&](const std::string& name, const Point& point) { landmarks.push_back(side.named(name, point)); };
    const std::vector<std::string> hips = {"pelvis", "spine_1", "*thigh"};
    add("trochanterion", side.find("trochanterion", hips, level(hip[1], 0.03), [](const Point& p) { return p[0]; }));
    add("buttock", side.find("buttock", hips, level(hip[1], 0.1), [](const Point& p) { return -p[2]; }));
    add("patella",
        side.find("patella", {"*thigh", "*shin"}, level(knee[1], 0.03), [](const Point& p) { return p[2]; }));
    const auto at_ankle = [&](const Point& p) {
        return (p - ankle).cwiseAbs().tail<2>().maxCoeff() < side.scaled(0.015);
    };
    const std::vector<std::string> foot = {"*shin", "*foot", "*toes"};
    Point along = ball - ankle;
    along[1] = 0.0;
    along.normalize();
    const Point across = Point::UnitY().cross(along);  // to the outer side of a left foot that points to +z
    add("malleolus_lateral",
        side.find("malleolus_lateral", foot, at_ankle, [&](const Point& p) { return across.dot(p); }));
    add("malleolus_medial",
        side.find("malleolus_medial", foot, at_ankle, [&](const Point& p) { return -across.dot(p); }));
    const auto at_ball = [&](const Point& p) { return std::abs(along.dot(p - ball)) < side.scaled(0.025); };
    add("metatarsal_1", side.find("metatarsal_1", foot, at_ball, [&](const Point& p) { return -across.dot(p); }));
    add("metatarsal_5", side.find("metatarsal_5", foot, at_ball, [&](const Point& p) { return across.dot(p); }));
    const auto low = [&](const Point& p) { return p[1] < ankle[1]; };
    add("heel", side.find("heel", foot, low, [&](const Point& p) { return -along.dot(p); }));
    add("toe_tip", side.find("toe_tip", foot, low, [&](const Point& p) { return along.dot(p); }));
}

}  // namespace

std::vector<NamedPoint> skin_landmarks(const Eigen::Ref<const Points>& vertices,
                                       const Eigen::Ref<const RowMatrix>& weights,
                                       const Eigen::Ref<const Points>& joint_positions)
{
    std::vector<NamedPoint> landmarks;
    add_midline(Side(vertices, weights, joint_positions, ""), landmarks);
    for (const std::string prefix : {"left_", "right_"}) {
        const Side side(vertices, weights, joint_positions, prefix);
        using Point = Eigen::Vector3d;
        landmarks.push_back(side.named("ear", side.find(
                                                  "ear", {"head", "jaw"}, [](const Point&) { return true; },
                                                  [](const Point& p) { return p[0]; })));
        // Foremost point of one side of the chest, between the lowest ribs and the armpit.
        const double top = side.own_joint("upper_arm")[1], bottom = side.joint("spine_3")[1];
        landmarks.push_back(side.named(
            "nipple", side.find(
                          "nipple", {"spine_2", "spine_3", "spine_4", "spine_5", "*clavicle", "*upper_arm"},
                          [&](const Point& p) { return p[0] > side.scaled(0.05) && p[1] > bottom && p[1] < top; },
                          [](const Point& p) { return p[2]; })));
        add_arm(side, landmarks);
        add_leg(side, landmarks);
    }
    return landmarks;
}

}  // namespace ndg
