// SPDX-License-Identifier: Apache-2.0
// How deep points lie under a skin, and how deep they can be asked to lie.
#pragma once

#include "ndg/geometry/closest_point.h"

#include <memory>
#include <vector>

namespace ndg {

/// Outside air around a closed skin: what a flood fill reaches on a grid of `cell` metres. Openings narrower than about
/// two cells keep it out: mouth, nostrils and the hollows behind the eyelids are not reached.
class OuterAir {
public:
    OuterAir(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
             double cell = 0.008);
    ~OuterAir();
    /// Triangles with air beside them.
    const std::vector<int>& triangles() const;
    /// Whether air is in the point's cell or one beside it.
    bool reaches(const Eigen::Vector3d& point) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

class SkinDepth {
public:
    /// `vertices`, `triangles`: closed, outward.
    SkinDepth(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles);

    struct Result {
        double depth = 0.0;                                ///< m, negative outside
        Eigen::Vector3d inward = Eigen::Vector3d::Zero();  ///< unit direction into the skin at `point`
        Eigen::Vector3d point = Eigen::Vector3d::Zero();   ///< nearest point of the skin
    };
    /// `hollow`: the cavities of the head count as outside, as the surface has it; for bones of the skull they do not.
    Result at(const Eigen::Vector3d& point, bool hollow) const;
    /// Greatest depth met going inwards from a point of the skin, as far as `reach`: half of the body's thickness there
    /// where it is thinner than twice that.
    double room_at(const Result& nearest, double reach, bool hollow) const;
    /// The part of `cover` that the body has room for: two fifths of the room, which is the whole cover where the body
    /// is thicker than five times that. Not below a fifth.
    double cover_at(const Result& nearest, double cover, bool hollow) const;

private:
    OuterAir air_;
    TriangleTree closed_, outer_;
};

}  // namespace ndg
