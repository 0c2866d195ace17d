// SPDX-License-Identifier: Apache-2.0
#include "ndg/motion/neutral_posture.h"

#include "ndg/core/error.h"
#include "ndg/geometry/rotation.h"

#include <cmath>
#include <string>

namespace ndg {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Neutral posture of one body: rotations from rest, built down the limbs.
class PostureBuilder {
public:
    explicit PostureBuilder(const Eigen::Ref<const Points>& joint_positions)
        : positions_(joint_positions), rotations_(std::size_t(joint_positions.rows()), Matrix3d::Identity())
    {
        for (const std::string side : {"left_", "right_"}) {
            hang(side + "thigh", side + "shin", Matrix3d::Identity());
            hang(side + "shin", side + "foot", at(side + "thigh"));
            // The feet stand as they do at rest.
            hang(side + "upper_arm", side + "forearm", Matrix3d::Identity());
            hang(side + "forearm", side + "hand", at(side + "upper_arm"));
            turn_palm(side);
            for (const char* finger : {"index", "middle", "ring", "pinky"}) straighten(side + finger);
            for (int k = 1; k <= 3; ++k) at(side + "thumb_" + std::to_string(k)) = at(side + "hand");
        }
    }

    /// Columns: axes of the thumb in the neutral posture.
    Matrix3d thumb_frame(const std::string& side) const
    {
        const Matrix3d& hand = rotations_[index(side + "hand")];
        const Vector3d along = hand * bone(side + "thumb_1", side + "thumb_2").normalized();
        const Vector3d to_pinky = hand * bone(side + "thumb_1", side + "pinky_1");
        const Vector3d flexion = along.cross(to_pinky);
        require_input(flexion.norm() > 1e-9, "{}thumb_1: the thumb points at the base of the little finger", side);
        Matrix3d frame;
        frame.col(1) = -along;
        frame.col(2) = flexion.normalized();
        frame.col(0) = frame.col(1).cross(frame.col(2));
        return frame;
    }

    const std::vector<Matrix3d>& rotations() const { return rotations_; }

private:
    static std::size_t index(const std::string& name)
    {
        return static_cast<std::size_t>(standard_skeleton().joint(name));
    }
    Matrix3d& at(const std::string& name) { return rotations_[index(name)]; }

    Vector3d bone(const std::string& from, const std::string& to) const
    {
        const Vector3d vector =
            (positions_.row(Eigen::Index(index(to))) - positions_.row(Eigen::Index(index(from)))).transpose();
        require_input(vector.norm() > 1e-9, "the rest positions of {} and {} are the same", from, to);
        return vector;
    }

    /// The bone from `joint` to `end` hangs down, by the least rotation beyond that of its parent.
    void hang(const std::string& joint, const std::string& end, const Matrix3d& parent)
    {
        at(joint) = minimal_rotation(parent * bone(joint, end), -Vector3d::UnitY()) * parent;
    }

    /// The hand hangs, and turns about the forearm until the knuckles from little to index finger point forward.
    void turn_palm(const std::string& side)
    {
        hang(side + "hand", side + "middle_1", at(side + "forearm"));
        const Vector3d knuckles = at(side + "hand") * bone(side + "pinky_1", side + "index_1");
        require_input(std::hypot(knuckles.x(), knuckles.z()) > 1e-9, "{}hand: its knuckles lie along it", side);
        const double turn = -std::atan2(knuckles.x(), knuckles.z());
        at(side + "hand") = about_y(turn) * at(side + "hand");
        at(side + "forearm_twist") = about_y(0.5 * turn) * at(side + "forearm");
    }

    /// Phalanges into the plane of the palm. The last one has no end joint and keeps its rest angle to the one before.
    void straighten(const std::string& finger)
    {
        Matrix3d parent = at(finger.substr(0, finger.find('_') + 1) + "hand");
        for (int k = 1; k <= 3; ++k) {
            const std::string joint = finger + "_" + std::to_string(k);
            if (k < 3) {
                const Vector3d phalanx = parent * bone(joint, finger + "_" + std::to_string(k + 1));
                parent = about_z(-std::atan2(phalanx.x(), -phalanx.y())) * parent;
            }
            at(joint) = parent;
        }
    }

    Points positions_;
    std::vector<Matrix3d> rotations_;
};

}  // namespace

NeutralPosture find_neutral_posture(const Eigen::Ref<const Points>& joint_positions)
{
    const PostureBuilder builder(joint_positions);
    return {builder.rotations(), {builder.thumb_frame("left_"), builder.thumb_frame("right_")}};
}

}  // namespace ndg
