// SPDX-License-Identifier: Apache-2.0
#include "ndg/bones/bone_motion.h"

#include "ndg/bones/knee.h"
#include "ndg/bones/limbs.h"
#include "ndg/bones/spine.h"
#include "ndg/bones/thorax.h"
#include "ndg/core/error.h"

#include <Eigen/SVD>

#include <array>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace ndg {

namespace {

constexpr std::array<BodySide, 2> sides = {BodySide::left, BodySide::right};

using Bone = BoneList::Bone;

/// What it takes to fit a rigid motion to a bone's linear blend skinning: sums over its vertices x, of weight w to a
/// joint.
struct BlendSums {
    struct Joint {
        double weight = 0.0;
        Eigen::Vector3d first = Eigen::Vector3d::Zero(), offset = Eigen::Vector3d::Zero();  ///< w x, w (x - mean)
        Eigen::Matrix3d second = Eigen::Matrix3d::Zero();                                   ///< w x (x - mean)^T
    };
    std::map<int, Joint> joints;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    double count = 0.0;

    BlendSums(const Eigen::Ref<const Points>& rest, const SkinningWeights& weights, int begin)
        : mean(rest.colwise().mean().transpose()), count(double(rest.rows()))
    {
        for (Eigen::Index v = 0; v < rest.rows(); ++v) {
            const Eigen::Vector3d x = rest.row(v).transpose();
            for (int k = 0; k < max_influences; ++k) {
                const double w = weights.weights(begin + v, k);
                if (w == 0.0) continue;
                Joint& joint = joints[weights.joints(begin + v, k)];
                joint.weight += w;
                joint.first += w * x;
                joint.offset += w * (x - mean);
                joint.second += w * x * (x - mean).transpose();
            }
        }
    }

    Eigen::Isometry3d fit(const std::vector<Eigen::Isometry3d>& motions) const
    {
        Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
        Eigen::Vector3d moved = Eigen::Vector3d::Zero();
        for (const auto& [j, sums] : joints) {
            const Eigen::Isometry3d& motion = motions[j];
            covariance += motion.linear() * sums.second + motion.translation() * sums.offset.transpose();
            moved += (motion.linear() * sums.first + sums.weight * motion.translation()) / count;
        }
        const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
        Eigen::Vector3d sign = Eigen::Vector3d::Ones();
        if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
        Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
        result.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
        result.translation() = moved - result.linear() * mean;
        return result;
    }
};

Eigen::Vector3d nearest_vertex(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& to)
{
    Eigen::Index best = 0;
    (points.rowwise() - to.transpose()).rowwise().squaredNorm().minCoeff(&best);
    return points.row(best).transpose();
}

Eigen::Vector3d farthest_vertex(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& from)
{
    Eigen::Index best = 0;
    (points.rowwise() - from.transpose()).rowwise().squaredNorm().maxCoeff(&best);
    return points.row(best).transpose();
}

}  // namespace

BoneList::BoneList(const Template& body_template)
{
    std::map<std::tuple<BoneKind, BodySide, int, int>, int> known;
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != AnatomyLayer::bone || part.vertex_begin == part.vertex_end) continue;
        Bone bone{name_bone(part, body_template.skeleton),
                  part.side,
                  part.vertex_begin,
                  part.vertex_end,
                  part.triangle_begin,
                  part.triangle_end,
                  num_segments};
        if (bone.name.kind != BoneKind::unknown) {
            const BodySide side = bone.name.kind == BoneKind::joint ? BodySide::middle : bone.side;
            bone.segment = known.try_emplace({bone.name.kind, side, bone.name.number, bone.name.joint}, num_segments)
                               .first->second;
        }
        if (bone.segment == num_segments) ++num_segments;
        bones.push_back(bone);
    }
}

const Bone* BoneList::find(BoneKind kind, BodySide side, int number) const
{
    for (const Bone& bone : bones)
        if (bone.name.kind == kind && bone.side == side && bone.name.number == number) return &bone;
    return nullptr;
}

struct BoneMotion::Rules {
    /// A segment that moves with a joint of the skeleton.
    struct WithJoint {
        int segment, joint;
    };
    struct Fitted {
        int segment;
        BlendSums sums;
    };
    struct Disk {
        int segment, number;
        Eigen::Vector3d centre;
    };
    struct Rib {
        int segment, vertebra;
        Strut strut;
    };
    struct Cartilage {
        int segment, rib_segment;
        Strut strut;
    };
    /// Segments of a limb's bones, clavicle and scapula, radius and ulna or shank and patella, and the joints that
    /// lead.
    template <typename Motion>
    struct Pair {
        int first_segment, second_segment, upper_joint, lower_joint;
        Motion motion;
    };

    int num_segments = 0;
    std::vector<WithJoint> with_joints;
    std::vector<Fitted> fitted;
    std::optional<SpineMotion> spine;
    std::array<int, num_vertebrae> vertebra_segments{};
    std::vector<Disk> disks;
    int sternum_segment = -1;
    Eigen::Vector3d sternum_centre = Eigen::Vector3d::Zero();
    std::vector<Rib> ribs;
    std::vector<Cartilage> cartilages;
    std::unique_ptr<RibCage> cage;
    std::vector<Pair<ShoulderMotion>> shoulders;
    std::vector<Pair<ForearmMotion>> forearms;
    std::vector<Pair<KneeMotion>> knees;

    Rules(const BoneList& list, const Template& body_template, const Body& body,
          const Eigen::Ref<const Points>& anatomy_rest);

    void add_spine(const BoneList& list, const Body& body, const Eigen::Ref<const Points>& rest);
    void add_thorax(const BoneList& list, const Eigen::Ref<const Points>& rest);
    void add_limbs(const BoneList& list, const Template& body_template, const Body& body,
                   const Eigen::Ref<const Points>& rest);
};

namespace {

auto rows(const Eigen::Ref<const Points>& points, const Bone& bone)
{
    return points.middleRows(bone.vertex_begin, bone.vertex_end - bone.vertex_begin);
}

/// Rows of several bones, one after the other.
Points joined_rows(const Eigen::Ref<const Points>& points, const std::vector<const Bone*>& bones)
{
    Eigen::Index count = 0;
    for (const Bone* bone : bones) count += bone->vertex_end - bone->vertex_begin;
    Points joined(count, 3);
    count = 0;
    for (const Bone* bone : bones) {
        joined.middleRows(count, bone->vertex_end - bone->vertex_begin) = rows(points, *bone);
        count += bone->vertex_end - bone->vertex_begin;
    }
    return joined;
}

}  // namespace

void BoneMotion::Rules::add_spine(const BoneList& list, const Body& body, const Eigen::Ref<const Points>& rest)
{
    std::vector<Points> vertebrae;
    for (int i = 0; i < num_vertebrae; ++i) {
        const Bone* bone = list.find(BoneKind::vertebra, BodySide::middle, i);
        if (bone == nullptr) return;
        vertebra_segments[std::size_t(i)] = bone->segment;
        vertebrae.push_back(rows(rest, *bone));
    }
    const Eigen::Vector3d head = body.joint_positions.row(standard_skeleton().joint("head")).transpose();
    Points centres;
    const Points levels = spine_levels(vertebrae, head, centres);
    spine.emplace(body.joint_positions, levels, centres);
    for (const Bone& bone : list.bones)
        if (bone.name.kind == BoneKind::disk)
            disks.push_back({bone.segment, bone.name.number, levels.row(bone.name.number).transpose()});
    add_thorax(list, rest);
}

void BoneMotion::Rules::add_thorax(const BoneList& list, const Eigen::Ref<const Points>& rest)
{
    std::vector<const Bone*> sternum;
    for (const Bone& bone : list.bones)
        if (bone.name.kind == BoneKind::sternum) sternum.push_back(&bone);
    if (sternum.empty()) return;
    const Points sternum_points = joined_rows(rest, sternum);
    sternum_segment = sternum.front()->segment;
    sternum_centre = sternum_points.colwise().mean().transpose();
    for (const Bone& bone : list.bones) {
        if (bone.name.kind != BoneKind::rib) continue;
        const int vertebra = thoracic_vertebra(bone.name.number);
        const Bone* carrier = list.find(BoneKind::vertebra, BodySide::middle, vertebra);
        const Eigen::Vector3d head =
            nearest_vertex(rows(rest, bone), rows(rest, *carrier).colwise().mean().transpose());
        const Strut strut{head, farthest_vertex(rows(rest, bone), head), sternum_share(bone.name.number)};
        ribs.push_back({bone.segment, vertebra, strut});
    }
    for (const Bone& bone : list.bones) {
        if (bone.name.kind != BoneKind::cartilage) continue;
        const Bone* rib = list.find(BoneKind::rib, bone.side, bone.name.number);
        if (rib == nullptr) continue;
        Eigen::Vector3d rib_end = Eigen::Vector3d::Zero();
        for (const Rib& known : ribs)
            if (known.segment == rib->segment) rib_end = known.strut.second;
        const Eigen::Vector3d at_rib = nearest_vertex(rows(rest, bone), rib_end);
        cartilages.push_back({bone.segment, rib->segment, {farthest_vertex(rows(rest, bone), at_rib), at_rib, 1.0}});
    }
}

void BoneMotion::Rules::add_limbs(const BoneList& list, const Template& body_template, const Body& body,
                                  const Eigen::Ref<const Points>& rest)
{
    const Skeleton& skeleton = standard_skeleton();
    const auto at = [&](int joint) -> Eigen::Vector3d { return body.joint_positions.row(joint).transpose(); };
    std::vector<const Bone*> upper_ribs;
    for (const Bone& bone : list.bones)
        if (bone.name.kind == BoneKind::rib && bone.name.number >= 2 && bone.name.number <= 8)
            upper_ribs.push_back(&bone);
    if (!upper_ribs.empty()) cage = std::make_unique<RibCage>(joined_rows(rest, upper_ribs));
    for (const BodySide side : sides) {
        const std::string prefix = side == BodySide::left ? "left_" : "right_";
        const auto joint = [&](const char* name) { return skeleton.joint(prefix + name); };
        const Bone* clavicle = list.find(BoneKind::clavicle, side);
        const Bone* scapula = list.find(BoneKind::scapula, side);
        const int upper_arm = joint("upper_arm"), forearm = joint("forearm"), hand = joint("hand");
        if (clavicle != nullptr && scapula != nullptr && cage != nullptr && sternum_segment >= 0) {
            shoulders.push_back({clavicle->segment, scapula->segment, joint("clavicle"), upper_arm,
                                 ShoulderMotion(at(upper_arm), at(forearm), at(joint("clavicle")),
                                                rows(rest, *clavicle), rows(rest, *scapula), *cage)});
        }
        const Bone* radius = list.find(BoneKind::radius, side);
        const Bone* ulna = list.find(BoneKind::ulna, side);
        if (radius != nullptr && ulna != nullptr) {
            forearms.push_back({radius->segment, ulna->segment, forearm, hand,
                                ForearmMotion(at(forearm), at(hand), rows(rest, *radius), rows(rest, *ulna))});
        }
        const Bone* femur = nullptr;
        for (const Bone& bone : list.bones)
            if (bone.name.kind == BoneKind::joint && bone.name.joint == joint("thigh")) femur = &bone;
        const Bone* patella = list.find(BoneKind::patella, side);
        std::vector<const Bone*> shank;
        for (const Bone& bone : list.bones)
            if (bone.name.kind == BoneKind::shank && bone.side == side) shank.push_back(&bone);
        if (femur != nullptr && patella != nullptr && !shank.empty()) {
            const Triangles triangles =
                body_template.anatomy_triangles
                    .middleRows(femur->triangle_begin, femur->triangle_end - femur->triangle_begin)
                    .array() -
                femur->vertex_begin;
            knees.push_back({shank.front()->segment, patella->segment, joint("thigh"), joint("shin"),
                             KneeMotion(at(joint("thigh")), at(joint("shin")), rows(rest, *femur), triangles,
                                        joined_rows(rest, shank), rows(rest, *patella))});
        }
    }
}

BoneMotion::Rules::Rules(const BoneList& list, const Template& body_template, const Body& body,
                         const Eigen::Ref<const Points>& anatomy_rest)
    : num_segments(list.num_segments)
{
    require(anatomy_rest.rows() == body_template.anatomy_vertices.rows(),
            "{} anatomy vertices at rest, the template has {}", anatomy_rest.rows(),
            body_template.anatomy_vertices.rows());
    if (body_template.skeleton.joint_names == standard_skeleton().joint_names) {
        add_spine(list, body, anatomy_rest);
        add_limbs(list, body_template, body, anatomy_rest);
    }
    std::vector<char> ruled(list.num_segments, 0);
    if (spine)
        for (const int segment : vertebra_segments) ruled[segment] = 1;
    for (const Disk& disk : disks) ruled[disk.segment] = 1;
    if (sternum_segment >= 0) ruled[sternum_segment] = 1;
    for (const Rib& rib : ribs) ruled[rib.segment] = 1;
    for (const Cartilage& cartilage : cartilages) ruled[cartilage.segment] = 1;
    const auto mark = [&](const auto& pairs) {
        for (const auto& pair : pairs) ruled[pair.first_segment] = ruled[pair.second_segment] = 1;
    };
    mark(shoulders);
    mark(forearms);
    mark(knees);
    for (const Bone& bone : list.bones) {
        if (ruled[bone.segment]) continue;
        ruled[bone.segment] = 1;
        if (bone.name.kind == BoneKind::joint)
            with_joints.push_back({bone.segment, bone.name.joint});
        else
            fitted.push_back(
                {bone.segment, BlendSums(rows(anatomy_rest, bone), body_template.anatomy_weights, bone.vertex_begin)});
    }
}

BoneMotion::BoneMotion(const BoneList& list, const Template& body_template, const Body& body,
                       const Eigen::Ref<const Points>& anatomy_rest)
    : rules_(std::make_unique<Rules>(list, body_template, body, anatomy_rest))
{
}
BoneMotion::~BoneMotion() = default;
BoneMotion::BoneMotion(BoneMotion&&) noexcept = default;

std::vector<Eigen::Isometry3d> BoneMotion::segments(const std::vector<Eigen::Isometry3d>& joints) const
{
    const Rules& rules = *rules_;
    std::vector<Eigen::Isometry3d> motions(rules.num_segments, Eigen::Isometry3d::Identity());
    for (const auto& one : rules.with_joints) motions[one.segment] = joints[one.joint];
    for (const auto& one : rules.fitted) motions[one.segment] = one.sums.fit(joints);
    if (rules.spine) {
        const auto vertebrae = rules.spine->vertebrae(joints);
        for (int i = 0; i < num_vertebrae; ++i)
            motions[rules.vertebra_segments[std::size_t(i)]] = vertebrae[std::size_t(i)];
        for (const auto& disk : rules.disks) {
            const Eigen::Isometry3d& above = vertebrae[std::size_t(disk.number)];
            const Eigen::Isometry3d& below =
                disk.number > 0 ? vertebrae[std::size_t(disk.number - 1)] : joints[standard_skeleton().joint("pelvis")];
            Eigen::Isometry3d& motion = motions[disk.segment];
            motion.linear() =
                Eigen::Quaterniond(below.linear()).slerp(0.5, Eigen::Quaterniond(above.linear())).matrix();
            motion.translation() = 0.5 * (below * disk.centre + above * disk.centre) - motion.linear() * disk.centre;
        }
        if (rules.sternum_segment >= 0) {
            const Eigen::Isometry3d sternum = sternum_motion(vertebrae, rules.sternum_centre);
            motions[rules.sternum_segment] = sternum;
            for (const auto& rib : rules.ribs)
                motions[rib.segment] = strut_motion(rib.strut, vertebrae[std::size_t(rib.vertebra)], sternum);
            for (const auto& one : rules.cartilages)
                motions[one.segment] = strut_motion(one.strut, sternum, motions[one.rib_segment]);
        }
    }
    for (const auto& shoulder : rules.shoulders) {
        const auto bones = shoulder.motion.bones(motions[rules.sternum_segment], joints[shoulder.upper_joint],
                                                 joints[shoulder.lower_joint]);
        motions[shoulder.first_segment] = bones.clavicle;
        motions[shoulder.second_segment] = bones.scapula;
    }
    for (const auto& arm : rules.forearms) {
        const auto bones = arm.motion.bones(joints[arm.upper_joint], joints[arm.lower_joint]);
        motions[arm.first_segment] = bones.radius;
        motions[arm.second_segment] = bones.ulna;
    }
    for (const auto& knee : rules.knees) {
        const auto bones = knee.motion.bones(joints[knee.upper_joint], joints[knee.lower_joint]);
        motions[knee.first_segment] = bones.shank;
        motions[knee.second_segment] = bones.patella;
    }
    return motions;
}

}  // namespace ndg
