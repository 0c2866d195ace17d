// SPDX-License-Identifier: Apache-2.0
#include "ndg/anatomical/skin_fit.h"

#include "ndg/body/skeleton.h"
#include "ndg/body_source/displacement_field.h"
#include "ndg/body_source/skin_depth.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <string>

namespace ndg {
namespace {

/// Fat over the muscles of a region, and how far muscles are drawn out at most, m.
struct RegionFat {
    const char* joint;  ///< prefix of the joint's name without its side
    double male, female, most_pull;
};
constexpr std::array<RegionFat, 12> region_fat = {{{"pelvis", 0.016, 0.022, 0.010},
                                                   {"spine", 0.009, 0.012, 0.006},
                                                   {"neck", 0.005, 0.006, 0.003},
                                                   {"clavicle", 0.007, 0.009, 0.002},
                                                   {"upper_arm", 0.006, 0.009, 0.020},
                                                   {"forearm", 0.004, 0.006, 0.015},
                                                   {"thigh", 0.009, 0.014, 0.022},
                                                   {"shin", 0.005, 0.008, 0.015},
                                                   {"foot", 0.004, 0.005, 0.0},
                                                   {"hand", 0.003, 0.003, 0.0},
                                                   {"head", 0.004, 0.004, 0.0},
                                                   {"", 0.003, 0.003, 0.0}}};  // fingers, toes, jaw
constexpr double bone_cover = 0.005;
/// Share of the fat layer that is kept over muscles that have to be pushed in.
constexpr double kept_fat = 0.6;
/// Share of a gap that muscles are drawn out by in one round.
constexpr double pull_share = 0.6;
constexpr std::array<double, 5> spacings = {0.048, 0.040, 0.032, 0.024, 0.020};
constexpr double push_weight = 1.0, pull_weight = 0.4, bone_weight = 0.3, muscle_weight = 0.01;
/// Vertebrae lie where the back says; the muscles beside them give way.
constexpr double spine_weight = 6.0;

const RegionFat& fat_of_joint(std::string joint)
{
    for (const std::string side : {"left_", "right_"})
        if (joint.rfind(side, 0) == 0) joint = joint.substr(side.size());
    for (const RegionFat& region : region_fat)
        if (joint.rfind(region.joint, 0) == 0) return region;
    return region_fat.back();
}

/// Fat and largest pull at every skin vertex, blended by the skinning weights.
struct SkinFat {
    Eigen::VectorXd fat, most_pull;
};
SkinFat skin_fat(const AnatomyTarget& target)
{
    const Skeleton& skeleton = standard_skeleton();
    Eigen::VectorXd fat(skeleton.num_joints()), pull(skeleton.num_joints());
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const RegionFat& region = fat_of_joint(skeleton.joint_names[std::size_t(j)]);
        fat[j] = target.female ? region.female : region.male;
        pull[j] = region.most_pull;
    }
    return {target.weights * fat, target.weights * pull};
}

struct Joined : TriangleMesh {
    std::vector<char> is_bone, is_spine, hollow, triangle_is_bone;
};

Joined join(const std::vector<AnatomyMesh>& parts)
{
    Joined joined{join_meshes(parts), {}, {}, {}, {}};
    for (const AnatomyMesh& part : parts) {
        const bool bone = part.layer == AnatomyLayer::bone, hollow = part.joint != "head" && part.joint != "jaw";
        joined.is_bone.insert(joined.is_bone.end(), std::size_t(part.vertices.rows()), bone);
        const bool spine = bone && part.name.find("vertebra") != std::string::npos;
        joined.is_spine.insert(joined.is_spine.end(), std::size_t(part.vertices.rows()), spine);
        joined.hollow.insert(joined.hollow.end(), std::size_t(part.vertices.rows()), hollow);
        joined.triangle_is_bone.insert(joined.triangle_is_bone.end(), std::size_t(part.triangles.rows()), bone);
    }
    return joined;
}

/// Rows of a displacement field.
struct Wishes {
    Points positions, displacements;
    Eigen::VectorXd weights;
};

class SkinFit {
public:
    explicit SkinFit(const AnatomyTarget& target)
        : target_(target),
          depth_(target.vertices, target.triangles),
          tree_(target.vertices, target.triangles),
          normals_(vertex_normals(target.vertices, target.triangles)),
          fat_(skin_fat(target))
    {
    }

    Wishes wishes(const Joined& anatomy) const
    {
        const Eigen::Index count = anatomy.vertices.rows(), skin = target_.vertices.rows();
        Wishes result{Points(count + skin, 3), Points::Zero(count + skin, 3), Eigen::VectorXd::Zero(count + skin)};
        result.positions << anatomy.vertices, anatomy.vertices.row(0).replicate(skin, 1);
#pragma omp parallel for schedule(dynamic, 256)
        for (Eigen::Index i = 0; i < count; ++i) {
            const bool bone = anatomy.is_bone[std::size_t(i)] != 0;
            const bool hollow = anatomy.hollow[std::size_t(i)] != 0;
            result.weights[i] = anatomy.is_spine[i] ? spine_weight : bone ? bone_weight : muscle_weight;
            const SkinDepth::Result at = depth_.at(anatomy.vertices.row(i).transpose(), hollow);
            if (at.depth > 0.03) continue;
            const double wanted = depth_.cover_at(at, bone ? bone_cover : kept_fat * fat_at(at.point), hollow);
            if (at.depth >= wanted) continue;
            result.displacements.row(i) = (wanted - at.depth) * at.inward.transpose();
            result.weights[i] = push_weight;
        }
        const TriangleTree muscles(anatomy.vertices, anatomy.triangles);
#pragma omp parallel for schedule(dynamic, 256)
        for (Eigen::Index v = 0; v < skin; ++v) {
            if (fat_.most_pull[v] <= 0.001) continue;
            const Eigen::Vector3d point = target_.vertices.row(v).transpose(), normal = normals_.row(v).transpose();
            const ClosestPoint nearest = muscles.closest(point);
            if (anatomy.triangle_is_bone[std::size_t(nearest.triangle_idx)]) continue;
            const Eigen::Vector3d inward = nearest.point - point;
            const double gap = std::min(pull_share * (nearest.distance - fat_.fat[v]), fat_.most_pull[v]);
            // Straight below this skin, or it belongs to another piece of skin.
            if (gap <= 0.0 || -inward.dot(normal) < 0.7 * nearest.distance) continue;
            result.positions.row(count + v) = nearest.point.transpose();
            result.displacements.row(count + v) = gap * normal.transpose();
            result.weights[count + v] = pull_weight;
        }
        return result;
    }

    double outside_share(const Joined& anatomy) const
    {
        std::ptrdiff_t outside = 0;
#pragma omp parallel for schedule(dynamic, 256) reduction(+ : outside)
        for (Eigen::Index i = 0; i < anatomy.vertices.rows(); ++i)
            if (depth_.at(anatomy.vertices.row(i).transpose(), anatomy.hollow[std::size_t(i)] != 0).depth < 0.0)
                ++outside;
        return double(outside) / double(anatomy.vertices.rows());
    }

private:
    double fat_at(const Eigen::Vector3d& skin_point) const
    {
        const ClosestPoint nearest = tree_.closest(skin_point);
        double fat = 0;
        for (int k = 0; k < 3; ++k)
            fat += nearest.barycentric[k] * fat_.fat[target_.triangles(nearest.triangle_idx, k)];
        return fat;
    }

    const AnatomyTarget& target_;
    SkinDepth depth_;
    TriangleTree tree_;
    Points normals_;
    SkinFat fat_;
};

}  // namespace

SkinFitReport fit_to_skin(std::vector<AnatomyMesh>& parts, Points& joint_positions, const AnatomyTarget& target)
{
    SkinFitReport report;
    if (parts.empty()) return report;
    const SkinFit fit(target);
    Joined anatomy = join(parts);
    const Points before = anatomy.vertices;
    report.outside_before = fit.outside_share(anatomy);
    for (const double spacing : spacings) {
        const Wishes wishes = fit.wishes(anatomy);
        const DisplacementField field(wishes.positions, wishes.displacements, wishes.weights, spacing, {});
        anatomy.vertices += field.at(anatomy.vertices);
        joint_positions += field.at(joint_positions);
    }
    report.outside_after = fit.outside_share(anatomy);
    double sum = 0, count = 0;
    for (Eigen::Index i = 0; i < before.rows(); ++i) {
        if (!anatomy.is_bone[std::size_t(i)]) continue;
        sum += (anatomy.vertices.row(i) - before.row(i)).squaredNorm();
        count += 1;
    }
    report.bone_displacement = count > 0 ? std::sqrt(sum / count) : 0.0;
    take_joined_vertices(anatomy.vertices, parts);
    return report;
}

}  // namespace ndg
