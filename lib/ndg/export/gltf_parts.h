// SPDX-License-Identifier: Apache-2.0
// What the writer of glTF is put together from. Only sources of this module include it.
#pragma once

#include "ndg/core/types.h"
#include "ndg/export/rig.h"

#include <tiny_gltf.h>

#include <vector>

namespace ndg::gltf {

using FloatRows = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

/// Appends raw data to the one buffer and describes it; returns the accessor's index.
int add_accessor(tinygltf::Model& model, const void* data, std::size_t bytes, int target, int component_type, int type,
                 std::size_t count);
int add_float_rows(tinygltf::Model& model, const FloatRows& rows);
/// With the extent, which glTF asks of positions.
int add_positions(tinygltf::Model& model, const FloatRows& positions);
/// Adds what an animation reads: floats, `components` a keyframe, or a value alone.
int add_keys(tinygltf::Model& model, const std::vector<float>& values, int type, int components);

/// One animation; finish() adds it to the model.
class Motion {
public:
    Motion(tinygltf::Model& model, const RigClip& clip);

    const RigClip& clip() const { return clip_; }
    /// The clip's frames of `rotations` and `translations`, which are of all frames.
    void add_rotations(int node, const std::vector<Eigen::Quaterniond>& rotations);
    void add_translations(int node, const Points& translations);
    /// Of morphs: a row a frame, of all frames.
    void add_weights(int node, const RowMatrix& weights);
    /// Of a target a frame but the first: at each frame its own stands alone, at the first none.
    void add_target_weights(int node, int num_targets);
    void finish() { model_.animations.push_back(animation_); }

private:
    void add_channel(int node, const char* path, int values);

    tinygltf::Model& model_;
    RigClip clip_;
    tinygltf::Animation animation_;
    int times_ = -1, target_weights_ = -1;
};

/// Joints below `skeleton` as nodes, and a skin of them; `node` gets skin, influences and morphs. The mesh's node must
/// be a root of the scene. Returns the nodes of the joints.
std::vector<int> add_rig(tinygltf::Model& model, const Rig& rig, int node);
void add_rig_motion(Motion& motion, const Rig& rig, int node, const std::vector<int>& joint_nodes);

}  // namespace ndg::gltf
