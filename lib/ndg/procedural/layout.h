// SPDX-License-Identifier: Apache-2.0
// Where everything of the procedural body goes: joints and the map from the drawing board to the person.
#pragma once

#include "ndg/core/types.h"
#include "ndg/procedural/parameters.h"

#include <algorithm>
#include <string>

namespace ndg {

/// The drawing board: a person of 1.70 m, in metres, on which heights and shapes of trunk and head are given.
/// Proportions: segment lengths of de Leva 1996 (J. Biomech. 29:1223, table 4: upper arm 0.162, forearm 0.155, hand to
/// the knuckle 0.049, thigh 0.242, shank 0.249 of stature), heights of Drillis and Contini 1966 (hip 0.530, knee 0.285,
/// ankle 0.039, chin 0.870, eyes 0.936 of stature, foot length 0.152), breadths of ANSUR II (Gordon et al. 2014:
/// biacromial 41.6 and 36.5 cm, bizygomatic 13.9 and 13.2 cm, head 15.4 x 19.9 and 14.7 x 19.0 cm, hand breadth 8.8 and
/// 7.8 cm, men and women).
constexpr double board_stature = 1.70;
constexpr double board_hip_height = 0.900;
constexpr double board_neck_height = 1.435;

class BodyLayout {
public:
    /// `girth`: fat as the mass asks for it; 0 is a body mass index of about 22 kg/m^2 at middling muscle, one unit
    /// about 1 cm of fat over the whole body.
    BodyLayout(const ProceduralParameters& parameters, double girth);

    const ProceduralParameters& parameters() const { return parameters_; }
    double girth() const { return girth_; }
    /// The same skeleton in the same pose with no more fat than `girth`.
    BodyLayout leaner(double girth) const
    {
        BodyLayout result = *this;
        result.girth_ = std::min(girth_, girth);
        return result;
    }
    /// Twice the muscularity above the middle: -1 to 1.
    double muscle() const { return 2.0 * parameters_.muscularity - 1.0; }
    /// Between the female and the male value.
    double by_sex(double female, double male) const { return female + parameters_.sex * (male - female); }
    /// Stature over that of the drawing board.
    double unit() const { return unit_; }
    double height(double board_y) const;
    /// A point of the drawing board (left side, x >= 0).
    Eigen::Vector3d place(double x, double y, double z) const;
    /// J x 3 on the standard skeleton.
    const Points& joints() const { return joints_; }
    Eigen::Vector3d joint(const std::string& name) const;

    /// Left arm: along it, upwards and outwards across it, and forwards.
    Eigen::Vector3d arm_axis() const { return arm_axis_; }
    Eigen::Vector3d arm_up() const { return arm_up_; }
    /// Left leg from hip to ankle, outwards across it, forwards across it.
    Eigen::Vector3d leg_axis() const { return leg_axis_; }
    Eigen::Vector3d leg_out() const { return leg_out_; }
    Eigen::Vector3d leg_front() const { return leg_front_; }
    /// Left foot: forwards and outwards on the floor.
    Eigen::Vector3d foot_front() const { return foot_front_; }
    Eigen::Vector3d foot_out() const { return foot_out_; }
    /// Left hand: direction of the fingers is arm_axis(), thumb side, and out of the palm.
    Eigen::Vector3d thumb_side() const { return Eigen::Vector3d::UnitZ(); }
    Eigen::Vector3d palm_side() const { return -arm_up_; }
    /// Size of head, hands and feet over the drawing board's; heads vary less between the sexes than statures do.
    double head_scale() const { return unit_ * by_sex(0.985, 1.01); }
    double hand_scale() const { return hand_scale_; }
    double foot_scale() const { return foot_scale_; }

    void set_joint(const std::string& name, const Eigen::Vector3d& position);

private:
    void place_axis_joints();
    void place_arm();
    void place_leg();

    ProceduralParameters parameters_;
    double girth_, unit_, trunk_scale_, hand_scale_, foot_scale_;
    Points joints_;
    Eigen::Vector3d arm_axis_, arm_up_, leg_axis_, leg_out_, leg_front_, foot_front_, foot_out_;
};

/// A finger of the left hand in the hand's own frame.
struct FingerPlan {
    const char* name;
    Eigen::Vector3d knuckle;  ///< m from the wrist: along the arm, to the thumb side, out of the palm
    double spread, bend;      ///< radians, to the thumb side and into the palm
    double lengths[3];        ///< m, of the three phalanges (thumb: metacarpal and two phalanges)
    double radii[4];          ///< m, at the four ends
};
/// Thumb, index, middle, ring, pinky.
const FingerPlan& finger_plan(int finger_idx);
/// The four points of a finger: its three joints and its tip (without the end's radius).
Points finger_points(const BodyLayout& layout, int finger_idx);

}  // namespace ndg
