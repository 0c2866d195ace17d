// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/camera.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <cmath>

namespace ndg {

Eigen::Vector3d view_direction(View view, double heading)
{
    double azimuth = heading;  // about +y, from +z towards +x
    switch (view) {
        case View::front:
            break;
        case View::back:
            azimuth += M_PI;
            break;
        case View::left:
            azimuth += M_PI / 2;
            break;
        case View::right:
            azimuth -= M_PI / 2;
            break;
        case View::three_quarter:
            azimuth += 35.0 * M_PI / 180.0;
            break;
    }
    const double elevation = 7.0 * M_PI / 180.0;
    return {std::cos(elevation) * std::sin(azimuth), std::sin(elevation), std::cos(elevation) * std::cos(azimuth)};
}

Ray Camera::ray(double x, double y, double aspect) const
{
    const double across = (x - 0.5) * image_height * aspect, upward = (0.5 - y) * image_height;
    if (!perspective) return {position + across * right + upward * up, -backward};
    return {position, (across * right + upward * up - backward).normalized()};
}

Camera frame_points(const Eigen::Ref<const Points>& points, const Eigen::Vector3d& towards_camera, double aspect,
                    double margin, double field_of_view)
{
    require(points.rows() > 0 && points.allFinite(), "There are no finite points to frame");
    Camera camera;
    camera.backward = towards_camera.normalized();
    const Eigen::Vector3d vertical =
        std::abs(camera.backward.y()) > 0.999 ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
    camera.right = vertical.cross(camera.backward).normalized();
    camera.up = camera.backward.cross(camera.right);

    Eigen::Matrix3d axes;  // columns: right, up, backward
    axes << camera.right, camera.up, camera.backward;
    const Points local = points * axes;
    const Eigen::RowVector3d low = local.colwise().minCoeff(), high = local.colwise().maxCoeff();
    const Eigen::RowVector3d centre = 0.5 * (low + high), extent = high - low;
    if (field_of_view <= 0.0) {
        camera.image_height = std::max({extent[1], extent[0] / aspect, 1e-6}) * (1.0 + 2.0 * margin);
        camera.position = axes * (centre + Eigen::RowVector3d(0, 0, 0.5 * extent[2] + 0.5)).transpose();
        return camera;
    }
    camera.perspective = true;
    camera.image_height = 2.0 * std::tan(0.5 * field_of_view);
    // Every point asks for a distance at which it falls inside the margin; the largest serves all.
    const double reach = 0.5 * camera.image_height / (1.0 + 2.0 * margin);
    double distance = 0.5 * extent[2] + 0.1;
    for (Eigen::Index i = 0; i < local.rows(); ++i) {
        const Eigen::RowVector3d p = local.row(i) - centre;
        distance = std::max(distance, p[2] + std::max(std::abs(p[1]), std::abs(p[0]) / aspect) / reach);
    }
    camera.position = axes * (centre + Eigen::RowVector3d(0, 0, distance)).transpose();
    return camera;
}

}  // namespace ndg
