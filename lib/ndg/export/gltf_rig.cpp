// SPDX-License-Identifier: Apache-2.0
// A mesh on a skeleton in glTF: JOINTS_n and WEIGHTS_n in sets of four, inverse bind matrices, morph targets.
#include "ndg/export/gltf_parts.h"

#include <fmt/format.h>

#include <algorithm>

namespace ndg::gltf {
namespace {

/// One set of four influences.
void add_influences(tinygltf::Model& model, tinygltf::Primitive& primitive, int set, const RowMatrixI& all_joints,
                    const RowMatrixF& all_weights)
{
    const Eigen::Matrix<std::uint16_t, Eigen::Dynamic, 4, Eigen::RowMajor> joints =
        all_joints.middleCols(4 * set, 4).cast<std::uint16_t>();
    const Eigen::Matrix<float, Eigen::Dynamic, 4, Eigen::RowMajor> weights = all_weights.middleCols(4 * set, 4);
    const std::size_t count = std::size_t(joints.rows());
    primitive.attributes[fmt::format("JOINTS_{}", set)] =
        add_accessor(model, joints.data(), 8 * count, TINYGLTF_TARGET_ARRAY_BUFFER,
                     TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT, TINYGLTF_TYPE_VEC4, count);
    primitive.attributes[fmt::format("WEIGHTS_{}", set)] =
        add_accessor(model, weights.data(), 16 * count, TINYGLTF_TARGET_ARRAY_BUFFER, TINYGLTF_COMPONENT_TYPE_FLOAT,
                     TINYGLTF_TYPE_VEC4, count);
}

/// Weights whose sum is one in single precision too: what rounding leaves goes to the largest.
RowMatrixF rounded_weights(const RowMatrix& weights)
{
    RowMatrixF rounded = weights.cast<float>();
    for (Eigen::Index i = 0; i < rounded.rows(); ++i) {
        Eigen::Index largest = 0;
        rounded.row(i).maxCoeff(&largest);
        rounded(i, largest) += 1.0f - rounded.row(i).sum();
    }
    return rounded;
}

/// From the world at rest to each joint's frame: no rotation, the joint at the origin.
int add_inverse_bind_matrices(tinygltf::Model& model, const Points& joint_positions)
{
    std::vector<float> values;
    for (Eigen::Index j = 0; j < joint_positions.rows(); ++j) {
        Eigen::Matrix4f matrix = Eigen::Matrix4f::Identity();
        matrix.topRightCorner<3, 1>() = -joint_positions.row(j).transpose().cast<float>();
        values.insert(values.end(), matrix.data(), matrix.data() + 16);
    }
    return add_keys(model, values, TINYGLTF_TYPE_MAT4, 16);
}

void add_morphs(tinygltf::Model& model, tinygltf::Mesh& mesh, const std::vector<Points>& morphs)
{
    tinygltf::Value::Array names;
    for (std::size_t k = 0; k < morphs.size(); ++k) {
        mesh.primitives[0].targets.push_back({{"POSITION", add_positions(model, morphs[k].cast<float>())}});
        names.emplace_back(fmt::format("corrective_{}", k));
    }
    mesh.weights.assign(morphs.size(), 0.0);
    mesh.extras = tinygltf::Value(tinygltf::Value::Object{{"targetNames", tinygltf::Value(names)}});
}

}  // namespace

std::vector<int> add_rig(tinygltf::Model& model, const Rig& rig, int node)
{
    const int first = int(model.nodes.size());
    std::vector<int> joint_nodes;
    for (int j = 0; j < rig.num_joints(); ++j) {
        tinygltf::Node joint;
        joint.name = rig.joint_names[j];
        const Eigen::RowVector3d position = rig.local_position(j);
        joint.translation = {position[0], position[1], position[2]};
        joint_nodes.push_back(first + j);
        if (j > 0) model.nodes[joint_nodes[rig.parents[j]]].children.push_back(first + j);
        model.nodes.push_back(joint);
    }
    model.scenes[0].nodes.push_back(first);
    tinygltf::Skin skin;
    skin.name = "skeleton";
    skin.skeleton = first;
    skin.joints = joint_nodes;
    skin.inverseBindMatrices = add_inverse_bind_matrices(model, rig.joint_positions);
    model.nodes[node].skin = int(model.skins.size());
    model.skins.push_back(skin);
    tinygltf::Mesh& mesh = model.meshes[model.nodes[node].mesh];
    const RowMatrixF weights = rounded_weights(rig.weights);
    for (int set = 0; set < int(weights.cols()) / 4; ++set)
        add_influences(model, mesh.primitives[0], set, rig.weight_joints, weights);
    if (!rig.morphs.empty()) add_morphs(model, mesh, rig.morphs);
    return joint_nodes;
}

void add_rig_motion(Motion& motion, const Rig& rig, int node, const std::vector<int>& joint_nodes)
{
    const Points positions = rig.root_translations.rowwise() + Eigen::RowVector3d(rig.joint_positions.row(0));
    motion.add_translations(joint_nodes[0], positions);
    for (int j = 0; j < rig.num_joints(); ++j) {
        std::vector<Eigen::Quaterniond> rotations;
        for (const std::vector<Eigen::Quaterniond>& frame : rig.rotations) rotations.push_back(frame[j]);
        // Joints that no frame moves (eyes, often fingers) stay as they are.
        if (std::any_of(rotations.begin(), rotations.end(),
                        [](const Eigen::Quaterniond& rotation) { return rotation.vec().norm() > 1e-7; }))
            motion.add_rotations(joint_nodes[j], rotations);
    }
    if (!rig.morphs.empty()) motion.add_weights(node, rig.morph_weights);
}

}  // namespace ndg::gltf
