// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/field.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr double far_away = 1e3;           // m, value of nothing
constexpr double difference_step = 1e-4;   // m
constexpr double converged = 1e-6;         // m
constexpr double bound_reliability = 0.6;  // fields may fall short of the distance by this factor

double smooth_max(double a, double b, double k)
{
    return -smooth_min(-a, -b, k);
}

/// First-order distance to the level 1 of g = (sum |q_i / r_i|^n)^(1/n).
double first_order_distance(const Eigen::Vector3d& q, const Eigen::Vector3d& r, double exponent)
{
    const Eigen::Vector3d scaled = q.cwiseQuotient(r);
    if (exponent == 2.0) {
        const double g = scaled.norm(), slope = scaled.cwiseQuotient(r).norm();
        return slope > 1e-12 ? g * (g - 1.0) / slope : -r.minCoeff();
    }
    const Eigen::Vector2d lower(std::pow(std::abs(scaled[0]), exponent - 1.0),
                                std::pow(std::abs(scaled[1]), exponent - 1.0));
    const double flat = std::pow(lower[0] * std::abs(scaled[0]) + lower[1] * std::abs(scaled[1]), 1.0 / exponent);
    const double g = std::hypot(flat, scaled[2]);
    if (g < 1e-9) return -r.minCoeff();
    // d g / d q = (flat * d flat, scaled_2 / r_2) / g, with d flat = lower / r * flat^(1 - n)
    const double power = flat > 1e-9 ? std::pow(flat, 1.0 - exponent) : 0.0;
    const Eigen::Vector3d slope(flat * lower[0] * power / r[0], flat * lower[1] * power / r[1], scaled[2] / r[2]);
    const double norm = slope.norm() / g;
    return norm > 1e-12 ? (g - 1.0) / norm : -r.minCoeff();
}

}  // namespace

double smooth_min(double a, double b, double k)
{
    const double h = k > 0.0 ? std::max(0.0, 1.0 - std::abs(a - b) / k) : 0.0;
    return std::min(a, b) - h * h * h * k * (1.0 / 6.0);
}

double Capsule::distance(const Eigen::Vector3d& point) const
{
    const Eigen::Vector3d axis = b - a;
    const double t = std::clamp((point - a).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    const double radius = radius_a + (radius_b - radius_a) * t * t * (3.0 - 2.0 * t);
    return (point - a - t * axis).norm() - radius;
}

double Ellipsoid::distance(const Eigen::Vector3d& point) const
{
    return first_order_distance(axes.transpose() * (point - centre), radii, 2.0);
}

double Plate::distance(const Eigen::Vector3d& point) const
{
    return closest_point_on_triangle(point, a, b, c).distance - radius;
}

void Tube::prepare()
{
    require(sections.size() >= 2, "A tube has {} sections", sections.size());
    const auto difference = [&](std::size_t i, std::size_t j) {
        const TubeSection &p = sections[i], &q = sections[j];
        const double h = 1.0 / (q.s - p.s);
        return TubeSection{1.0,
                           (q.centre_u - p.centre_u) * h,
                           (q.centre_w - p.centre_w) * h,
                           (q.outer - p.outer) * h,
                           (q.inner - p.inner) * h,
                           (q.front - p.front) * h,
                           (q.back - p.back) * h};
    };
    slopes.clear();
    for (std::size_t i = 0; i < sections.size(); ++i)
        slopes.push_back(difference(i == 0 ? 0 : i - 1, std::min(i + 1, sections.size() - 1)));
    // Flat at the ends, so that they pass smoothly into the caps.
    slopes.front() = slopes.back() = TubeSection{1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0};
}

TubeSection Tube::at(double s) const
{
    if (s <= sections.front().s) return sections.front();
    if (s >= sections.back().s) return sections.back();
    std::size_t i = 0;
    while (s > sections[i + 1].s) ++i;
    const TubeSection &p = sections[i], &q = sections[i + 1], &dp = slopes[i], &dq = slopes[i + 1];
    const double h = q.s - p.s, t = (s - p.s) / h, t2 = t * t, t3 = t2 * t;
    const double a = 2.0 * t3 - 3.0 * t2 + 1.0, b = (t3 - 2.0 * t2 + t) * h, c = 3.0 * t2 - 2.0 * t3, d = (t3 - t2) * h;
    const auto mix = [&](double TubeSection::*x) { return a * p.*x + b * dp.*x + c * q.*x + d * dq.*x; };
    return {s,
            mix(&TubeSection::centre_u),
            mix(&TubeSection::centre_w),
            mix(&TubeSection::outer),
            mix(&TubeSection::inner),
            mix(&TubeSection::front),
            mix(&TubeSection::back)};
}

Eigen::Vector3d Tube::centre(double s) const
{
    const TubeSection section = at(s);
    return origin + s * length * axis + section.centre_u * u + section.centre_w * w;
}

double Tube::distance(const Eigen::Vector3d& point) const
{
    const Eigen::Vector3d local = point - origin;
    const double s = local.dot(axis) / length;
    const TubeSection section = at(s);
    const Eigen::Vector3d q(local.dot(u) - section.centre_u, local.dot(w) - section.centre_w,
                            s < sections.front().s  ? (s - sections.front().s) * length
                            : s > sections.back().s ? (s - sections.back().s) * length
                                                    : 0.0);
    const Eigen::Vector3d r(q[0] > 0.0 ? section.outer : section.inner, q[1] > 0.0 ? section.front : section.back,
                            q[2] > 0.0 ? cap_end : cap_begin);
    return first_order_distance(q, r, exponent);
}

void Field::begin_group(double k, Side side, int tag)
{
    groups_.push_back({k, side, tag, {}, Eigen::Vector3d::Zero(), 0.0, -1.0, 0.0});
}

void Field::add_item(Shape shape, std::size_t idx, double k, bool carved, const Eigen::Vector3d& centre, double radius)
{
    require(!groups_.empty(), "A primitive was added before the first group");
    Group& group = groups_.back();
    if (!carved) {  // the smallest sphere around the two
        const Eigen::Vector3d apart = centre - group.bound_centre;
        const double distance = apart.norm();
        if (group.items.empty() || distance + group.bound_radius <= radius) {
            group.bound_centre = centre;
            group.bound_radius = radius;
        } else if (distance + radius > group.bound_radius) {
            const double merged = 0.5 * (distance + radius + group.bound_radius);
            group.bound_centre += apart * ((merged - group.bound_radius) / distance);
            group.bound_radius = merged;
        }
    }
    group.items.push_back({shape, idx, k, carved, centre, radius});
}

void Field::add(const Capsule& capsule, double k)
{
    capsules_.push_back(capsule);
    for (const auto& [end, radius] : {std::pair(capsule.a, capsule.radius_a), std::pair(capsule.b, capsule.radius_b)}) {
        bounds_.extend(end - Eigen::Vector3d::Constant(radius));
        bounds_.extend(end + Eigen::Vector3d::Constant(radius));
    }
    add_item(Shape::capsule, capsules_.size() - 1, k, false, 0.5 * (capsule.a + capsule.b),
             0.5 * (capsule.b - capsule.a).norm() + std::max(capsule.radius_a, capsule.radius_b));
}

void Field::add(const Ellipsoid& ellipsoid, double k)
{
    ellipsoids_.push_back(ellipsoid);
    const Eigen::Vector3d reach = (ellipsoid.axes * ellipsoid.radii.asDiagonal()).rowwise().norm();
    bounds_.extend(ellipsoid.centre - reach);
    bounds_.extend(ellipsoid.centre + reach);
    add_item(Shape::ellipsoid, ellipsoids_.size() - 1, k, false, ellipsoid.centre, ellipsoid.radii.maxCoeff());
}

void Field::add(const Tube& tube, double k)
{
    tubes_.push_back(tube);
    tubes_.back().prepare();
    double widest = 0.0;
    for (const TubeSection& section : tube.sections)
        widest = std::max(widest, std::hypot(std::max(section.outer, section.inner) + std::abs(section.centre_u),
                                             std::max(section.front, section.back) + std::abs(section.centre_w)));
    const double begin = tube.sections.front().s * tube.length - tube.cap_begin;
    const double end = tube.sections.back().s * tube.length + tube.cap_end;
    for (const double place : {begin, end}) {
        bounds_.extend(tube.origin + place * tube.axis - Eigen::Vector3d::Constant(widest));
        bounds_.extend(tube.origin + place * tube.axis + Eigen::Vector3d::Constant(widest));
    }
    add_item(Shape::tube, tubes_.size() - 1, k, false, tube.origin + 0.5 * (begin + end) * tube.axis,
             std::hypot(0.5 * (end - begin), 1.1 * widest));
}

void Field::add(const Plate& plate, double k)
{
    plates_.push_back(plate);
    const Eigen::Vector3d centre = (plate.a + plate.b + plate.c) / 3.0;
    const double reach =
        std::max({(plate.a - centre).norm(), (plate.b - centre).norm(), (plate.c - centre).norm()}) + plate.radius;
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(plate.radius);
    for (const Eigen::Vector3d& corner : {plate.a, plate.b, plate.c}) {
        bounds_.extend(corner - margin);
        bounds_.extend(corner + margin);
    }
    add_item(Shape::plate, plates_.size() - 1, k, false, centre, reach);
}

Eigen::AlignedBox3d Field::bounds() const
{
    return bounds_;
}

void Field::carve(const Ellipsoid& ellipsoid, double k)
{
    ellipsoids_.push_back(ellipsoid);
    add_item(Shape::ellipsoid, ellipsoids_.size() - 1, k, true, ellipsoid.centre, ellipsoid.radii.maxCoeff());
}

void Field::clip_middle(double gap, double k)
{
    require(!groups_.empty(), "There is no group to clip");
    groups_.back().clip_gap = gap;
    groups_.back().clip_k = k;
}

void Field::set_floor(double height, double k)
{
    has_floor_ = true;
    floor_height_ = height;
    floor_k_ = k;
}

double Field::items_value(const Group& group, const Eigen::Vector3d& point) const
{
    double value = far_away;
    for (const Item& item : group.items) {
        const double bound = bound_reliability * ((point - item.bound_centre).norm() - item.bound_radius);
        if (item.carved ? bound > item.k - value : bound > value + item.k) continue;
        const double distance = item.shape == Shape::capsule     ? capsules_[item.idx].distance(point)
                                : item.shape == Shape::ellipsoid ? ellipsoids_[item.idx].distance(point)
                                : item.shape == Shape::plate     ? plates_[item.idx].distance(point)
                                                                 : tubes_[item.idx].distance(point);
        value = item.carved ? smooth_max(value, -distance, item.k) : smooth_min(value, distance, item.k);
    }
    return value;
}

double Field::group_value(const Group& group, const Eigen::Vector3d& point) const
{
    if (group.side == Side::middle) return items_value(group, point);
    const Eigen::Vector3d left(std::abs(point.x()), point.y(), point.z());
    const double value = items_value(group, left);
    if (group.clip_gap >= 0.0) return smooth_max(value, group.clip_gap - left.x(), group.clip_k);
    if (group.side == Side::mirrored) return value;
    return smooth_min(value, items_value(group, {-left.x(), left.y(), left.z()}), group.items.front().k);
}

double Field::part_value(int tag, const Eigen::Vector3d& point) const
{
    double value = far_away;
    for (const Group& group : groups_)
        if (group.tag == tag) value = smooth_min(value, group_value(group, point), group.k);
    return value;
}

double Field::value(const Eigen::Vector3d& point) const
{
    double value = far_away;
    for (const Group& group : groups_) {
        Eigen::Vector3d near = point;
        if (group.side != Side::middle) near.x() = std::abs(near.x());
        const double bound = bound_reliability * ((near - group.bound_centre).norm() - group.bound_radius);
        if (bound > value + group.k) continue;
        value = smooth_min(value, group_value(group, point), group.k);
    }
    return has_floor_ ? smooth_max(value, floor_height_ - point.y(), floor_k_) : value;
}

Eigen::Vector3d Field::gradient(const Eigen::Vector3d& point) const
{
    // Four corners of a tetrahedron: second order on average, four evaluations.
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& corner :
         {Eigen::Vector3d(1, -1, -1), Eigen::Vector3d(-1, -1, 1), Eigen::Vector3d(-1, 1, -1), Eigen::Vector3d(1, 1, 1)})
        sum += corner * value(point + difference_step * corner);
    return sum / (4.0 * difference_step);
}

Eigen::Vector3d Field::project(const Eigen::Vector3d& point, double level, int iterations, double max_step) const
{
    Eigen::Vector3d x = point, slope = Eigen::Vector3d::Zero();
    double last_miss = 0.0;
    for (int i = 0; i < iterations; ++i) {
        const double miss = value(x) - level;
        if (std::abs(miss) < converged) break;
        // The gradient hardly changes over a short step: it is renewed only where the last step did not do well.
        if (i == 0 || std::abs(miss) > 0.1 * std::abs(last_miss)) slope = gradient(x);
        last_miss = miss;
        const double squared = slope.squaredNorm();
        if (squared < 1e-4) break;
        Eigen::Vector3d step = -miss / squared * slope;
        if (step.norm() > max_step) step *= max_step / step.norm();
        x += step;
    }
    return x;
}

}  // namespace ndg
