// SPDX-License-Identifier: Apache-2.0
#include "ndg/export/gltf_parts.h"

#include <cstring>

namespace ndg::gltf {

int add_accessor(tinygltf::Model& model, const void* data, std::size_t bytes, int target, int component_type, int type,
                 std::size_t count)
{
    std::vector<unsigned char>& buffer = model.buffers[0].data;
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = buffer.size();
    view.byteLength = bytes;
    if (target != 0) view.target = target;
    buffer.resize(buffer.size() + bytes);
    std::memcpy(buffer.data() + view.byteOffset, data, bytes);
    tinygltf::Accessor accessor;
    accessor.bufferView = int(model.bufferViews.size());
    accessor.componentType = component_type;
    accessor.type = type;
    accessor.count = count;
    model.bufferViews.push_back(view);
    model.accessors.push_back(accessor);
    return int(model.accessors.size()) - 1;
}

int add_float_rows(tinygltf::Model& model, const FloatRows& rows)
{
    return add_accessor(model, rows.data(), std::size_t(rows.size()) * sizeof(float), TINYGLTF_TARGET_ARRAY_BUFFER,
                        TINYGLTF_COMPONENT_TYPE_FLOAT, TINYGLTF_TYPE_VEC3, std::size_t(rows.rows()));
}

int add_positions(tinygltf::Model& model, const FloatRows& positions)
{
    const int index = add_float_rows(model, positions);
    tinygltf::Accessor& accessor = model.accessors[std::size_t(index)];
    for (int k = 0; k < 3; ++k) {
        accessor.minValues.push_back(double(positions.col(k).minCoeff()));
        accessor.maxValues.push_back(double(positions.col(k).maxCoeff()));
    }
    return index;
}

int add_keys(tinygltf::Model& model, const std::vector<float>& values, int type, int components)
{
    return add_accessor(model, values.data(), values.size() * sizeof(float), 0, TINYGLTF_COMPONENT_TYPE_FLOAT, type,
                        values.size() / std::size_t(components));
}

Motion::Motion(tinygltf::Model& model, const RigClip& clip) : model_(model), clip_(clip)
{
    animation_.name = clip.name;
    std::vector<float> times;
    for (int f = 0; f < clip.size(); ++f) times.push_back(float(f / clip.frame_rate));
    times_ = add_keys(model, times, TINYGLTF_TYPE_SCALAR, 1);
    model.accessors[times_].minValues = {double(times.front())};
    model.accessors[times_].maxValues = {double(times.back())};
}

void Motion::add_channel(int node, const char* path, int values)
{
    tinygltf::AnimationSampler sampler;
    sampler.input = times_;
    sampler.output = values;
    sampler.interpolation = "LINEAR";
    tinygltf::AnimationChannel channel;
    channel.sampler = int(animation_.samplers.size());
    channel.target_node = node;
    channel.target_path = path;
    animation_.samplers.push_back(sampler);
    animation_.channels.push_back(channel);
}

void Motion::add_rotations(int node, const std::vector<Eigen::Quaterniond>& rotations)
{
    std::vector<float> keys;
    Eigen::Quaternionf before = Eigen::Quaternionf::Identity();
    for (int f = clip_.frame_begin; f < clip_.frame_end; ++f) {
        Eigen::Quaternionf rotation = rotations[f].cast<float>();
        rotation.normalize();
        if (rotation.dot(before) < 0.0f) rotation.coeffs() *= -1.0f;  // players blend the shorter way
        before = rotation;
        keys.insert(keys.end(), rotation.coeffs().data(), rotation.coeffs().data() + 4);
    }
    add_channel(node, "rotation", add_keys(model_, keys, TINYGLTF_TYPE_VEC4, 4));
}

void Motion::add_translations(int node, const Points& translations)
{
    const FloatRows keys = translations.middleRows(clip_.frame_begin, clip_.size()).cast<float>();
    add_channel(node, "translation", add_keys(model_, {keys.data(), keys.data() + keys.size()}, TINYGLTF_TYPE_VEC3, 3));
}

void Motion::add_weights(int node, const RowMatrix& weights)
{
    const RowMatrixF keys = weights.middleRows(clip_.frame_begin, clip_.size()).cast<float>();
    add_channel(node, "weights", add_keys(model_, {keys.data(), keys.data() + keys.size()}, TINYGLTF_TYPE_SCALAR, 1));
}

void Motion::add_target_weights(int node, int num_targets)
{
    if (target_weights_ < 0) {
        std::vector<float> weights(std::size_t(clip_.size() * num_targets), 0.0f);
        for (int f = clip_.frame_begin; f < clip_.frame_end; ++f)
            if (f > 0) weights[(f - clip_.frame_begin) * num_targets + f - 1] = 1.0f;
        target_weights_ = add_keys(model_, weights, TINYGLTF_TYPE_SCALAR, 1);
    }
    add_channel(node, "weights", target_weights_);
}

}  // namespace ndg::gltf
