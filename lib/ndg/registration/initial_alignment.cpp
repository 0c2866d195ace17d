// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/initial_alignment.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

constexpr int num_headings = 12;
constexpr int icp_points = 400;
constexpr int icp_iterations = 8;
/// Share of the points that count, the nearest ones: arms and hands may lie anywhere.
constexpr double kept_share = 0.75;

/// `percent` percentile of a column.
double percentile(const Points& points, int column, double percent)
{
    std::vector<double> values(points.col(column).begin(), points.col(column).end());
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(percent / 100.0 * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

Eigen::Isometry3d rigid_fit(const Points& from, const Points& to)
{
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.matrix() = Eigen::umeyama(from.transpose(), to.transpose(), false);
    return motion;
}

/// One candidate improved by ICP. `points`: the sample in the file's axes; the template's tree is in template units.
void improve(const Points& points, const TriangleTree& tree, InitialAlignment& candidate)
{
    const auto kept = static_cast<std::size_t>(kept_share * static_cast<double>(points.rows()));
    for (int iteration = 0; iteration <= icp_iterations; ++iteration) {
        std::vector<std::pair<double, int>> order;
        Points moved(points.rows(), 3), nearest(points.rows(), 3);
        for (Eigen::Index i = 0; i < points.rows(); ++i) {
            const Eigen::Vector3d position = candidate.template_from_file * points.row(i).transpose();
            moved.row(i) = position.transpose();
            const ClosestPoint closest = tree.closest(position / candidate.template_scale);
            nearest.row(i) = candidate.template_scale * closest.point.transpose();
            order.emplace_back(candidate.template_scale * closest.distance, static_cast<int>(i));
        }
        std::sort(order.begin(), order.end());
        candidate.error = 0.0;
        Points from(static_cast<Eigen::Index>(kept), 3), to(from.rows(), 3);
        for (std::size_t i = 0; i < kept; ++i) {
            candidate.error += order[i].first / static_cast<double>(kept);
            from.row(static_cast<Eigen::Index>(i)) = moved.row(order[i].second);
            to.row(static_cast<Eigen::Index>(i)) = nearest.row(order[i].second);
        }
        if (iteration < icp_iterations)
            candidate.template_from_file = rigid_fit(from, to) * candidate.template_from_file;
    }
}

}  // namespace

std::vector<InitialAlignment> align_initially(const ScanPoints& scan, const SkinnedSurface& skin, int count)
{
    const TriangleTree tree(skin.vertices, skin.triangles);
    const double template_low = skin.vertices.col(1).minCoeff();
    const double template_stature = skin.vertices.col(1).maxCoeff() - template_low;
    const Eigen::RowVector3d template_centre =
        0.5 * (skin.vertices.colwise().minCoeff() + skin.vertices.colwise().maxCoeff());

    const auto stride = std::max<Eigen::Index>(1, scan.points.rows() / icp_points);
    Points sample(scan.points.rows() / stride, 3);
    for (Eigen::Index i = 0; i < sample.rows(); ++i) sample.row(i) = scan.points.row(i * stride);

    std::vector<InitialAlignment> candidates;
    for (const Axis up : scan.up_axes) {
        const Eigen::Matrix3d upright = rotation_to_y_up(up);
        const Points turned = scan.points * upright.transpose();
        const double low = percentile(turned, 1, 0.05), high = percentile(turned, 1, 99.95);
        // The middle of the trunk, not of the arms.
        const Eigen::RowVector3d middle(percentile(turned, 0, 50), low, percentile(turned, 2, 50));
        for (int h = 0; h < num_headings; ++h) {
            InitialAlignment candidate;
            candidate.up = up;
            candidate.template_scale = (high - low) / template_stature;
            const Eigen::Matrix3d heading = about_y(2.0 * EIGEN_PI * h / num_headings);
            candidate.template_from_file.linear() = heading * upright;
            const Eigen::Vector3d target =
                candidate.template_scale * Eigen::Vector3d(template_centre[0], template_low, template_centre[2]);
            candidate.template_from_file.translation() = target - heading * middle.transpose();
            candidates.push_back(std::move(candidate));
        }
    }
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t c = 0; c < candidates.size(); ++c) improve(sample, tree, candidates[c]);
    std::stable_sort(candidates.begin(), candidates.end(),
                     [](const auto& a, const auto& b) { return a.error < b.error; });
    // Headings that ended in the same place are one.
    std::vector<InitialAlignment> distinct;
    for (const InitialAlignment& candidate : candidates) {
        const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const InitialAlignment& other) {
            const Eigen::Matrix3d between =
                candidate.template_from_file.linear() * other.template_from_file.linear().transpose();
            return Eigen::AngleAxisd(between).angle() < 0.35;
        });
        if (!known && static_cast<int>(distinct.size()) < count) distinct.push_back(candidate);
    }
    return distinct;
}

InitialAlignment align_by_landmarks(const std::string& name, const Eigen::Ref<const Points>& positions,
                                    const Eigen::Ref<const Points>& on_template)
{
    require_input(positions.rows() >= 3, "{}: {} landmarks of the template are given, at least three are needed", name,
                  positions.rows());
    const Points centred = positions.rowwise() - positions.colwise().mean();
    const Eigen::Vector3d singular = Eigen::MatrixXd(centred).jacobiSvd().singularValues();
    require_input(singular[1] > 0.05 * singular[0], "{}: the landmarks lie on a line", name);
    // The template is scaled, not the scan: from template to scan first.
    const Eigen::Matrix4d scan_from_template = Eigen::umeyama(on_template.transpose(), positions.transpose(), true);
    InitialAlignment result;
    result.template_scale = std::cbrt(scan_from_template.topLeftCorner<3, 3>().determinant());
    result.template_from_file.linear() = (scan_from_template.topLeftCorner<3, 3>() / result.template_scale).transpose();
    result.template_from_file.translation() =
        -(result.template_from_file.linear() * scan_from_template.topRightCorner<3, 1>());
    const Eigen::Vector3d up_in_file = result.template_from_file.linear().transpose() * Eigen::Vector3d::UnitY();
    Eigen::Index axis = 0;
    up_in_file.cwiseAbs().maxCoeff(&axis);
    result.up = axis_along(static_cast<int>(axis), up_in_file[axis] < 0);
    const Points mapped = (positions * result.template_from_file.linear().transpose()).rowwise() +
                          result.template_from_file.translation().transpose();
    result.error = (mapped - result.template_scale * on_template).rowwise().norm().mean();
    return result;
}

}  // namespace ndg
