// SPDX-License-Identifier: Apache-2.0
// Implicit surfaces from smoothly joined primitives (Ricci 1973; Wyvill et al. 1986): what the procedural body's skin
// and bones are made of. A field is negative inside and close to the distance in metres near its zero surface.
#pragma once

#include "ndg/core/types.h"

#include <vector>

namespace ndg {

/// Polynomial smooth minimum: equals min(a, b) where |a - b| >= k, twice differentiable in between.
double smooth_min(double a, double b, double k);

/// Rounded segment between two points with a radius at each.
struct Capsule {
    Eigen::Vector3d a, b;
    double radius_a, radius_b;

    double distance(const Eigen::Vector3d& point) const;
};

/// Ellipsoid; the columns of `axes` are its unit half-axes.
struct Ellipsoid {
    Eigen::Vector3d centre, radii;
    Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();

    double distance(const Eigen::Vector3d& point) const;
};

/// Rounded triangle.
struct Plate {
    Eigen::Vector3d a, b, c;
    double radius;

    double distance(const Eigen::Vector3d& point) const;
};

/// Section of a tube: a superellipse made of four quarters, whose half-axes are `outer` (+u), `inner` (-u), `front`
/// (+w) and `back` (-w), around a centre beside the axis.
struct TubeSection {
    double s;  ///< place along the axis, 0 at its origin, 1 at its end
    double centre_u, centre_w;
    double outer, inner, front, back;
};

/// Straight axis with sections between which all sizes run as cubic splines, and ellipsoidal ends.
struct Tube {
    Eigen::Vector3d origin, axis;  ///< axis: unit
    double length;
    Eigen::Vector3d u, w;       ///< unit, orthogonal to the axis
    double cap_begin, cap_end;  ///< m, half-axes of the ends beyond the first and last section
    double exponent = 2.0;      ///< of the superellipses
    std::vector<TubeSection> sections{};
    std::vector<TubeSection> slopes{};  ///< d/ds of the sections; made by prepare()

    /// Must be called when the sections are complete.
    void prepare();
    TubeSection at(double s) const;
    double distance(const Eigen::Vector3d& point) const;
    Eigen::Vector3d centre(double s) const;
};

/// A tree of primitives: groups are joined in order, the primitives of a group in order before that.
class Field {
public:
    enum class Side {
        middle,    ///< once, as given
        mirrored,  ///< given for x >= 0 and mirrored; the two halves do not blend
        blended,   ///< mirrored, the halves blending across x = 0 with the primitive's own k
    };

    /// Starts a group that joins what stands before with smoothing `k` (m). `tag` says which part it belongs to.
    void begin_group(double k, Side side, int tag = 0);
    void add(const Capsule& capsule, double k);
    void add(const Ellipsoid& ellipsoid, double k);
    void add(const Tube& tube, double k);
    void add(const Plate& plate, double k);
    /// Takes away, smoothly, what lies inside the ellipsoid.
    void carve(const Ellipsoid& ellipsoid, double k);
    /// Cuts the current group off, smoothly, where |x| < gap, so that it never meets its mirror image.
    void clip_middle(double gap, double k);
    /// Everything below y = height is cut off, with a rounded edge.
    void set_floor(double height, double k);

    /// A box around everything, not mirrored.
    Eigen::AlignedBox3d bounds() const;

    double value(const Eigen::Vector3d& point) const;
    /// Of the groups with one tag alone.
    double part_value(int tag, const Eigen::Vector3d& point) const;
    /// By differences over 0.1 mm.
    Eigen::Vector3d gradient(const Eigen::Vector3d& point) const;
    /// Newton's method along the gradient towards value(x) = level; a step is at most `max_step`.
    Eigen::Vector3d project(const Eigen::Vector3d& point, double level, int iterations, double max_step = 0.02) const;

private:
    enum class Shape { capsule, ellipsoid, tube, plate };
    struct Item {
        Shape shape;
        std::size_t idx;
        double k;
        bool carved;
        Eigen::Vector3d bound_centre;
        double bound_radius;
    };
    struct Group {
        double k;
        Side side;
        int tag;
        std::vector<Item> items;
        Eigen::Vector3d bound_centre = Eigen::Vector3d::Zero();
        double bound_radius = 0.0;
        double clip_gap = -1.0, clip_k = 0.0;  ///< gap < 0: not clipped
    };
    void add_item(Shape shape, std::size_t idx, double k, bool carved, const Eigen::Vector3d& centre, double radius);
    double group_value(const Group& group, const Eigen::Vector3d& point) const;
    double items_value(const Group& group, const Eigen::Vector3d& point) const;

    std::vector<Capsule> capsules_;
    std::vector<Ellipsoid> ellipsoids_;
    std::vector<Tube> tubes_;
    std::vector<Plate> plates_;
    Eigen::AlignedBox3d bounds_;
    std::vector<Group> groups_;
    bool has_floor_ = false;
    double floor_height_ = 0.0, floor_k_ = 0.0;
};

}  // namespace ndg
