// SPDX-License-Identifier: Apache-2.0
// What follows the volume and the bones: head, hands and toes, the anatomy. In single precision, one pass over each.
#pragma once

#include "ndg/bones/bone_rig.h"
#include "ndg/deform/residuals.h"
#include "ndg/runtime/prism_forces.h"

#include <array>
#include <vector>

namespace ndg {

/// Points that are moved by linear blend skinning.
class SkinnedPoints {
public:
    SkinnedPoints() = default;
    /// Rows `rows` of surfaces with these weights.
    SkinnedPoints(std::vector<int> rows, const SkinningWeights& weights);

    /// `rest`: all rows of the surface at rest.
    void set_rest(const Eigen::Ref<const Points>& rest);
    /// Writes their rows of the posed surface. Called by all threads of an OpenMP parallel region, or outside of one.
    void pose(const std::vector<Eigen::Matrix<float, 3, 4>>& world_from_rest, PointsF& posed) const;
    std::size_t table_bytes() const;

private:
    std::vector<int> rows_;
    std::vector<Eigen::Vector3f> rest_;
    std::vector<int> begins_, joints_;  ///< influences of each
    std::vector<float> weights_;
};

/// Bones and muscles, as PosedBody::anatomy has them.
class CarriedAnatomy {
public:
    /// `bones`: null where bones are not rigid. Keeps references.
    CarriedAnatomy(const Template& body_template, const RiggedBodies* bones);

    /// `anatomy_rest`: anatomy_at_rest of the body.
    void set_rest(const Eigen::Ref<const Points>& anatomy_rest);
    /// Motions of rigid bones. Called by one thread.
    void set_motions(const std::vector<Eigen::Isometry3d>& segments);
    /// Writes all rows. Called by all threads of an OpenMP parallel region, or outside of one. `volume`: N_v + N_i
    /// columns, volume and bone interior.
    void pose(const PointColumns& volume, const std::vector<Eigen::Matrix<float, 3, 4>>& world_from_rest,
              PointsF& anatomy) const;
    std::size_t table_bytes() const;

private:
    struct Embedded {
        int row, held;  ///< of the anatomy; in held_, or -1
        std::array<int, 6> corners;
        std::array<float, 6> weights;
    };
    /// Beside a bone: what the bones have of it.
    struct Held {
        float share;
        int begin, end;  ///< of influences_
        Eigen::Vector3f rest;
    };
    struct Influence {
        int segment;
        float weight;
    };
    Eigen::Vector3f hold(const Held& held) const;

    const BoneList* list_ = nullptr;
    std::vector<Embedded> embedded_;
    std::vector<int> held_rows_;
    std::vector<Held> held_;
    std::vector<Influence> influences_;
    SkinnedPoints skinned_;  ///< beyond the cuts
    PointsF rest_;
    std::vector<Eigen::Matrix<float, 3, 4>> segments_;
    std::vector<Eigen::Vector4f> reals_, duals_;  ///< dual quaternions of the segments
};

}  // namespace ndg
