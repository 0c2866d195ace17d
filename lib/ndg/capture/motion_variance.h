// SPDX-License-Identifier: Apache-2.0
// How much skin moves beyond its skinning: the anisotropic motion variance of Romero et al. 2020, section 5.2.
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/capture/capture.h"
#include "ndg/core/enum_names.h"

#include <vector>

namespace ndg {

/// Of V vertices, m^2 (equation 6): along the skin's normal and across it.
struct MotionVariance {
    Eigen::VectorXd normal, tangent;

    Eigen::VectorXd total() const { return normal + tangent; }
    /// Both stacked, 2 V: what residuals are differences of (equation 7).
    Eigen::VectorXd stacked() const;
};

/// Which metric residuals are made of: the two variances of each vertex, or their sum.
enum class VarianceMetric { anisotropic, isotropic };
template <>
inline constexpr EnumName<VarianceMetric> enum_table<VarianceMetric>[] = {{VarianceMetric::anisotropic, "anisotropic"},
                                                                          {VarianceMetric::isotropic, "isotropic"}};

/// Sums over the frames of a trajectory.
class MotionVarianceSum {
public:
    /// `reference`: V x 3, near which trajectories run, so that nothing cancels; `normals`: V x 3, of any length but
    /// zero. Throws Error for a normal without direction.
    MotionVarianceSum(const Points& reference, const Points& normals);

    /// `unposed`: V x 3, P^-1 z of one frame, m.
    void add(const Points& unposed);
    int num_frames() const { return num_frames_; }
    /// Throws Error where no frame was added.
    MotionVariance variance() const;
    /// V x 3, z-bar.
    Points mean() const;

private:
    Points reference_, normals_, sum_;
    Eigen::VectorXd squares_, normal_sum_, normal_squares_;
    int num_frames_ = 0;
};

/// Where an avatar's skin is measured: skin vertices above soft tissue that are free to move.
struct MeasuredSkin {
    explicit MeasuredSkin(const Avatar& avatar);

    int size() const { return static_cast<int>(skin_vertices.size()); }
    /// V x 3 of one frame: `skin` N x 3, in the world, taken back to unposed space by the maps of the volume (M).
    Points unposed_skin(const Points& skin, const std::vector<AffineMap>& world_from_unposed) const;
    /// The same of the volume's vertices, M x 3.
    Points unposed_volume(const Points& volume, const std::vector<AffineMap>& world_from_unposed) const;

    std::vector<int> skin_vertices, volume_vertices;  ///< V each
    Points rest, normals;                             ///< V x 3
};

/// Of the sequence's own frames, skinned by its own poses. Throws InputError where it has no poses or another number of
/// vertices than the avatar's skin.
MotionVariance motion_variance(const Avatar& avatar, const MeasuredSkin& skin, const CaptureSequence& sequence);

/// D^T D of equation 8 for two motions of the same vertices, m^4.
double variance_error(const MotionVariance& a, const MotionVariance& b, VarianceMetric metric);

}  // namespace ndg
