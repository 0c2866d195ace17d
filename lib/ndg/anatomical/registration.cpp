// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/registration.h"

#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <map>

namespace ndg {
namespace {

using Eigen::Vector3d;
using Map = std::function<Vector3d(const Vector3d&)>;

/// A muscle follows a group of bones it comes this close to, m.
constexpr double attachment_distance = 0.010;
/// Softens the inverse distance at the bone, m.
constexpr double blend_distance = 0.004;
constexpr int blend_smoothing_steps = 8;

constexpr double far_away = 1e3;

/// Bones that move as one.
struct Group {
    TriangleTree tree;
    Eigen::AlignedBox3d box;
    const Map* map;
    bool in_hand;
};

Eigen::AlignedBox3d bounding_box(const Points& vertices)
{
    return {vertices.colwise().minCoeff().transpose(), vertices.colwise().maxCoeff().transpose()};
}

bool contains(const std::string& text, const std::string& word)
{
    return text.find(word) != std::string::npos;
}

bool contains_any(const std::string& text, const std::vector<std::string>& words)
{
    return std::any_of(words.begin(), words.end(), [&](const std::string& word) { return contains(text, word); });
}

std::string lower(std::string text)
{
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

/// Joint of a thoracic level: what turns about the disk below that vertebra (anatomy_joints.h).
std::string thoracic_joint(const std::string& name)
{
    if (contains_any(name, {"twelfth", "eleventh", "tenth"})) return "spine_3";
    if (contains_any(name, {"ninth", "eighth"})) return "spine_4";
    return "spine_5";
}

std::string spine_joint(const std::string& name)
{
    if (contains(name, "thoracic")) return thoracic_joint(name);
    if (contains(name, "lumbar")) {
        if (contains(name, "fifth")) return "pelvis";
        return contains_any(name, {"first", "second"}) ? "spine_2" : "spine_1";
    }
    if (contains(name, "cervical")) return contains_any(name, {"fifth", "sixth", "seventh"}) ? "neck_1" : "neck_2";
    return "neck_2";  // atlas, axis and the disk between axis and third vertebra
}

BoneGroup hand_group(const std::string& name, const std::string& side)
{
    for (const auto& [finger, ordinal, words] : finger_names) {
        const std::string prefix = side + "_" + finger + "_";
        const bool is_thumb = std::string(finger) == "thumb";
        if (contains(name, "metacarpal") && contains(name, ordinal))
            return {prefix + "0", is_thumb ? prefix + "1" : side + "_hand"};
        if (!contains(name, "phalanx") || !contains(name, words)) continue;
        const int number = contains(name, "proximal") ? 1 : contains(name, "middle phalanx") || is_thumb ? 2 : 3;
        return {prefix + std::to_string(number), prefix + std::to_string(is_thumb ? number + 1 : number)};
    }
    return {side + "_carpus", side + "_hand"};
}

BoneGroup limb_group(const std::string& name, const std::string& side)
{
    const auto on_side = [&](const char* group, const char* joint) {
        return BoneGroup{side + "_" + group, side + "_" + joint};
    };
    if (contains(name, "sesamoid")) return on_side("foot", "toes");
    const std::array<const char*, 5> toes = {"big toe", "second toe", "third toe", "fourth toe", "little toe"};
    for (std::size_t k = 0; k < toes.size(); ++k)
        if (contains(name, toes[k])) return {side + "_toe_" + std::to_string(k + 1), side + "_toes"};
    if (contains_any(name, {"metatarsal", "calcaneus", "talus", "navicular", "cuboid", "cuneiform"}))
        return on_side("foot", "foot");
    if (contains_any(name, {"metacarpal", "phalanx"})) return hand_group(name, side);
    if (contains_any(name,
                     {"capitate", "hamate", "lunate", "pisiform", "scaphoid", "trapezi", "trapezoid", "triquetral"}))
        return on_side("carpus", "hand");
    if (contains(name, "clavicle")) return on_side("clavicle", "clavicle");
    if (contains(name, "scapula")) return on_side("scapula", "clavicle");
    if (contains(name, "humerus")) return on_side("upper_arm", "upper_arm");
    if (contains(name, "ulna")) return on_side("ulna", "forearm");
    if (contains(name, "radius")) return on_side("radius", "forearm_twist");
    if (contains_any(name, {"femur", "patella"})) return on_side("thigh", "thigh");
    if (contains_any(name, {"tibia", "fibula"})) return on_side("shin", "shin");
    return {};
}

/// For each vertex of a muscle the shares of the groups, N x G.
RowMatrix blend_weights(const AnatomyMesh& muscle, const std::vector<Group>& groups)
{
    const Eigen::Index num_vertices = muscle.vertices.rows();
    const auto num_groups = static_cast<Eigen::Index>(groups.size());
    const Eigen::AlignedBox3d box = bounding_box(muscle.vertices);
    double search = attachment_distance;
    const auto in_reach = [&](const Group& group) { return group.box.exteriorDistance(box) <= search; };
    while (std::none_of(groups.begin(), groups.end(), in_reach)) search *= 2.0;
    RowMatrix weights = RowMatrix::Constant(num_vertices, num_groups, far_away);
    for (Eigen::Index g = 0; g < num_groups; ++g) {
        if (!in_reach(groups[std::size_t(g)])) continue;
        for (Eigen::Index v = 0; v < num_vertices; ++v)
            weights(v, g) = groups[std::size_t(g)].tree.closest(muscle.vertices.row(v).transpose()).distance;
    }
    const Eigen::RowVectorXd nearest = weights.colwise().minCoeff();
    const double reach = std::max(attachment_distance, nearest.minCoeff());
    for (Eigen::Index g = 0; g < num_groups; ++g) {
        if (nearest[g] > reach)
            weights.col(g).setZero();
        else
            weights.col(g) = (weights.col(g).array() + blend_distance).pow(-3.0);
    }
    const Eigen::VectorXd sums = weights.rowwise().sum();
    weights.array().colwise() /= sums.array();
    const auto neighbours = vertex_neighbours(muscle.triangles, int(num_vertices));
    for (int step = 0; step < blend_smoothing_steps; ++step) {
        const RowMatrix old = weights;
        for (Eigen::Index v = 0; v < num_vertices; ++v) {
            Eigen::RowVectorXd mean = Eigen::RowVectorXd::Zero(num_groups);
            for (const int n : neighbours[std::size_t(v)]) mean += old.row(n);
            weights.row(v) = 0.5 * old.row(v) + 0.5 * mean / double(neighbours[std::size_t(v)].size());
        }
    }
    return weights;
}

/// All bones of a group as one mesh, and where they go.
Group make_group(const std::vector<AnatomyMesh>& parts, const std::vector<std::size_t>& members,
                 const std::string& name, const Map& map)
{
    std::vector<const TriangleMesh*> bones;
    for (const std::size_t i : members) bones.push_back(&parts[i]);
    const TriangleMesh joined = join_meshes(bones);
    return {TriangleTree(joined.vertices, joined.triangles), bounding_box(joined.vertices), &map,
            contains_any(name, {"carpus", "thumb", "index", "middle", "ring", "pinky"})};
}

/// Group whose map carries a joint: the bone the joint's centre was found on.
std::string group_of_joint(const std::string& joint)
{
    if (joint == "jaw") return "head";
    for (const std::string side : {"left_", "right_"}) {
        if (joint.rfind(side, 0) != 0) continue;
        const std::string name = joint.substr(side.size());
        if (name == "clavicle") return side + "clavicle";
        if (name == "upper_arm") return side + "upper_arm";
        if (name == "forearm") return side + "upper_arm";
        if (name == "hand") return side + "radius";
        if (name == "thigh") return side + "thigh";
        if (name == "shin") return side + "thigh";
        if (name == "foot" || name == "toes") return side + "foot";
        if (name == "thumb_1") return side + "thumb_0";
        const char last = name.back();
        if (last < '1' || last > '3') return "";
        const int number = last - '0';
        return side + name.substr(0, name.size() - 1) +
               std::to_string(name.rfind("thumb", 0) == 0 ? number - 2 : number - 1);
    }
    return "trunk";
}

Points bone_joints(const BonePoints& points, const std::map<std::string, Map>& maps, const AnatomyTarget& target)
{
    const Skeleton& skeleton = standard_skeleton();
    Points joints = target.joints;
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[std::size_t(j)];
        const auto point = points.find(name);
        if (point != points.end()) joints.row(j) = maps.at(group_of_joint(name))(point->second).transpose();
    }
    return symmetric_joints(std::move(joints));
}

}  // namespace

BoneGroup bone_group(const AnatomyMesh& bone)
{
    const std::string name = lower(bone.name);
    if (contains_any(name, {"vertebra", "atlas", "axis"})) return {"trunk", spine_joint(name)};
    if (contains_any(name, {"sacrum", "hip bone"})) return {"trunk", "pelvis"};
    if (contains_any(name, {" rib", "costal"})) return {"trunk", thoracic_joint(name)};
    if (contains_any(name, {"manubrium", "sternum"})) return {"trunk", "spine_5"};
    if (name == "hyoid bone") return {"trunk", "neck_2"};
    if (name == "mandible") return {"head", "jaw"};
    if (bone.side != BodySide::middle) {
        const BoneGroup group = limb_group(name, to_name(bone.side));
        if (!group.group.empty()) return group;
    }
    const bool skull = contains_any(name, {"ethmoid", "frontal", "nasal", "lacrimal", "maxilla", "occipital",
                                           "palatine", "parietal", "sphenoid", "temporal", "vomer", "zygomatic"});
    require(skull, "the bone '{}' belongs to no known group", bone.name);
    return {"head", "head"};
}

Points register_anatomy(std::vector<AnatomyMesh>& parts, const AnatomyTarget& target)
{
    const BonePoints points = bone_points(parts);
    const AxialMap trunk(parts, points, target);
    std::map<std::string, Map> maps = {{"trunk", [&](const Vector3d& x) { return trunk.trunk(x); }},
                                       {"head", [&](const Vector3d& x) { return trunk.head(x); }}};
    for (const auto& [name, transform] : limb_transforms(parts, points, trunk, target)) {
        const Eigen::Affine3d affine = transform;
        maps[name] = [affine](const Vector3d& x) { return Vector3d(affine * x); };
    }

    std::map<std::string, std::vector<std::size_t>> members;
    std::vector<std::string> group_of(parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
        if (parts[i].layer != AnatomyLayer::bone) continue;
        const BoneGroup group = bone_group(parts[i]);
        parts[i].joint = group.joint;
        group_of[i] = group.group;
        members[group.group].push_back(i);
    }
    std::vector<Group> groups;
    for (const auto& [name, bones] : members) groups.push_back(make_group(parts, bones, name, maps.at(name)));
#pragma omp parallel for schedule(dynamic, 1)
    for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(parts.size()); ++i) {
        AnatomyMesh& part = parts[std::size_t(i)];
        if (part.layer == AnatomyLayer::bone) {
            const Map& map = maps.at(group_of[std::size_t(i)]);
            for (Eigen::Index v = 0; v < part.vertices.rows(); ++v)
                part.vertices.row(v) = map(part.vertices.row(v).transpose()).transpose();
            continue;
        }
        const RowMatrix weights = blend_weights(part, groups);
        for (Eigen::Index v = 0; v < part.vertices.rows(); ++v) {
            const Vector3d source = part.vertices.row(v).transpose();
            Vector3d moved = Vector3d::Zero();
            for (Eigen::Index g = 0; g < weights.cols(); ++g)
                if (weights(v, g) > 0.0) moved += weights(v, g) * (*groups[std::size_t(g)].map)(source);
            part.vertices.row(v) = moved.transpose();
        }
        double hand_share = 0.0;
        for (std::size_t g = 0; g < groups.size(); ++g)
            if (groups[g].in_hand) hand_share += weights.col(Eigen::Index(g)).mean();
        if (part.side != BodySide::middle && hand_share > 0.98) part.joint = to_name(part.side) + "_hand";
    }

    return bone_joints(points, maps, target);
}

Points symmetric_joints(Points joint_positions)
{
    const Skeleton& skeleton = standard_skeleton();
    const Eigen::RowVector3d flip(-1, 1, 1);
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const std::string& name = skeleton.joint_names[std::size_t(j)];
        if (name.rfind("right_", 0) == 0) continue;
        if (name.rfind("left_", 0) != 0) {
            joint_positions(j, 0) = 0.0;
            continue;
        }
        const int other = skeleton.joint("right_" + name.substr(5));
        joint_positions.row(j) = 0.5 * (joint_positions.row(j) + joint_positions.row(other).cwiseProduct(flip)).eval();
        joint_positions.row(other) = joint_positions.row(j).cwiseProduct(flip);
    }
    for (const std::string side : {"left", "right"})
        joint_positions.row(skeleton.joint(side + "_forearm_twist")) =
            0.5 * (joint_positions.row(skeleton.joint(side + "_forearm")) +
                   joint_positions.row(skeleton.joint(side + "_hand")));
    return joint_positions;
}

std::vector<std::string> bone_joint_names()
{
    std::vector<std::string> names;
    for (const std::string& name : standard_skeleton().joint_names)
        if (name != "left_eye" && name != "right_eye") names.push_back(name);
    return names;
}

}  // namespace ndg
