// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/elastic/lane_term.h"
#include "ndg/elastic/skin_lanes.h"

namespace ndg {

/// Stretching and bending of a skin's edges (NDG equations 5 and 6).
class SkinTerm : public LaneTerm<SkinLanes> {
public:
    /// Edges of one triangle carry no energy. `stretch_stiffness`, `bend_stiffness`: k_s, k_b, joule.
    SkinTerm(const Eigen::Ref<const Triangles>& triangles, double stretch_stiffness, double bend_stiffness,
             int num_vertices);

    /// Throws Error for a triangle without area.
    void set_rest(const Eigen::Ref<const Points>& rest_vertices) override;

private:
    double stretch_stiffness_, bend_stiffness_;
};

}  // namespace ndg
