// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/enum_names.h"
#include "ndg/core/types.h"

namespace ndg {

/// Where the camera stands as seen from the body, which faces +z with its left side at +x.
enum class View { front, back, left, right, three_quarter };
template <>
inline constexpr EnumName<View> enum_table<View>[] = {{View::front, "front"},
                                                      {View::back, "back"},
                                                      {View::left, "left"},
                                                      {View::right, "right"},
                                                      {View::three_quarter, "three-quarter"}};
/// Unit vector from the subject towards the camera, a little raised so that the floor is seen. `heading`: angle in
/// radians about +y by which the subject is turned away from +z.
Eigen::Vector3d view_direction(View view, double heading = 0.0);

struct Ray {
    Eigen::Vector3d origin, direction;
};

/// Pinhole or parallel camera. right, up, backward are orthonormal; the camera looks along -backward.
struct Camera {
    Eigen::Vector3d position, right, up, backward;
    bool perspective = false;
    /// Orthographic: height of the image in metres. Perspective: 2 tan(vertical field of view / 2).
    double image_height = 1.0;

    /// Ray through image coordinates x, y in [0, 1] from the top left, of an image with width / height = `aspect`.
    Ray ray(double x, double y, double aspect) const;
};

/// The camera in direction `towards_camera` that shows all `points` (N x 3) with a margin (share of the image height).
/// `field_of_view` in radians, vertical; 0: orthographic.
Camera frame_points(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& towards_camera, double aspect,
                    double margin = 0.04, double field_of_view = 0.0);

}  // namespace ndg
