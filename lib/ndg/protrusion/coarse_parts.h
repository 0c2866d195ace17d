// SPDX-License-Identifier: Apache-2.0
// Body and pose that do not go together: skins whose limbs pass through each other (NDG 5.3).
#pragma once

#include "ndg/body/template.h"

#include <array>

namespace ndg {

/// Trunk with head, both arms from the shoulder on, both legs from the hip on. A triangle of the skin belongs to a part
/// when its three vertices move with the part's joints by nine tenths or more; the folds of armpit and groin, which
/// every bend closes, belong to none.
class CoarseParts {
public:
    /// Throws InputError for a skeleton without upper arms and thighs.
    explicit CoarseParts(const Template& body_template);

    /// Whether triangles of two parts cross. `skin_vertices`: N_s x 3.
    bool collide(const Eigen::Ref<const Points>& skin_vertices) const;

    static constexpr int count = 5;

private:
    std::array<Triangles, count> triangles_;
};

}  // namespace ndg
