// SPDX-License-Identifier: Apache-2.0
// Where the joints of a body model of the SMPL family lie, from the user's own copy of the model.
#pragma once

#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// Rest joints as a linear function of shape. The models are under licences of their own and do not come with the
/// project; Loper et al. 2015, "SMPL: A Skinned Multi-Person Linear Model", equation 10: joints are J_regressor times
/// the shaped vertices.
class SmplSkeleton {
public:
    /// An .npz with "J_regressor" (M x V), "v_template" (V x 3) and "shapedirs" (V x 3 x B), as models come, or with
    /// "J" (M x 3) alone, metres, y up, facing +z, left at +x; M 24 (SMPL), 52 (SMPL-H) or 55 (SMPL-X). Throws
    /// InputError naming file, array and value: as NpzFile does, another shape, joints that are no standing person.
    explicit SmplSkeleton(const std::string& path);

    /// M x 3; coefficients beyond those of the model are left out, as are all where the file has "J" alone.
    Points joints(const std::vector<double>& betas) const;

private:
    Points mean_;
    std::vector<Points> directions_;  ///< of each coefficient, M x 3
};

}  // namespace ndg
