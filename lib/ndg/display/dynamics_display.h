// SPDX-License-Identifier: Apache-2.0
// A body in motion with inertia as it is shown: beside itself as skinning alone has it, among obstacles and in
// garments.
#pragma once

#include "ndg/avatar/avatar.h"
#include "ndg/dynamics/dynamics_file.h"
#include "ndg/export/mesh_sequence.h"

#include <string>
#include <vector>

namespace ndg {

/// Frames are those of the file. Keeps references to both.
class DynamicsDisplay {
public:
    /// `avatar`: of a soft-tissue body; none of a layered one, of which what moves is shown and no more. Throws
    /// InputError for an avatar that is not the file's.
    DynamicsDisplay(const DynamicsReader& reader, const Avatar* avatar);

    const DynamicsSet& set() const { return reader_.set(); }
    const Triangles& triangles() const { return triangles_; }  ///< of the skin, whole where there is an avatar
    /// Of every vertex of the skin: whether it can give way; head, hands, feet and rims go where skinning has them.
    const std::vector<char>& soft() const { return soft_; }
    const Points& rest() const { return rest_; }  ///< of the skin
    /// The skin from all vertices of a frame.
    Points skin(int frame, const Points& positions) const;
    bool has_skinned() const { return avatar_ != nullptr; }
    /// By skinning alone: the statistical body in the pose. Throws Error without an avatar.
    Points skinned(int frame) const;
    /// Distance of every skin vertex from there, m.
    Eigen::VectorXd displacements(int frame) const;

    /// A motion: "skin", then obstacles and garments. Refers to this. With `range` > 0 the skin is coloured by its
    /// displacements, white 0 to red `range` metres.
    MeshSequence sequence(int index, const std::string& credits, double range = 0) const;

    const DynamicsReader& reader() const { return reader_; }

private:
    const DynamicsReader& reader_;
    const Avatar* avatar_;
    int body_begin_ = 0;
    std::vector<int> vertices_;  ///< without an avatar: those of the skin
    Triangles triangles_;
    std::vector<char> soft_;
    Points rest_;
};

/// A page of one motion: as skinning alone has it, where there is an avatar, beside the simulation; what it meets and
/// wears in both. Returns the largest error of a position, m.
double write_dynamics_page(const std::string& path, const DynamicsDisplay& display, int sequence,
                           const std::string& credits);

/// White to red, one colour a value.
VertexColours distance_colours(const Eigen::Ref<const Eigen::VectorXd>& distances, double range);

}  // namespace ndg
