// SPDX-License-Identifier: Apache-2.0
#include "ndg/runtime/ndg.h"

#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/runtime/runtime.h"

#include <cmath>
#include <memory>
#include <string>

struct ndg_runtime {
    ndg_runtime(const char* template_path, const char* bodies_path, const char* model_path)
        : body_template(ndg::read_template(template_path)),
          bodies(ndg::read_bodies(bodies_path, body_template).bodies),
          model(model_path),
          runtime(body_template, model)
    {
    }

    ndg::Template body_template;
    std::vector<ndg::Body> bodies;
    ndg::RuntimeModel model;
    ndg::Runtime runtime;
};

namespace {

thread_local std::string last_error;

/// Runs f; an exception becomes a code and last_error.
template <typename F>
int guarded(const F& f)
{
    try {
        f();
        return NDG_DONE;
    } catch (const ndg::InputError& error) {
        last_error = error.what();
        return NDG_BAD_INPUT;
    } catch (const std::exception& error) {
        last_error = error.what();
    } catch (...) {
        last_error = "something unknown failed";
    }
    return NDG_FAILED;
}

template <typename Container>
bool has(const Container& items, int index)
{
    return index >= 0 && static_cast<std::size_t>(index) < items.size();
}

ndg::Pose pose_from(const ndg::Skeleton& skeleton, const double* rotations, const double* displacement)
{
    ndg::Pose pose;
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const double* const q = rotations + 4 * static_cast<std::ptrdiff_t>(j);
        const Eigen::Quaterniond rotation(q[3], q[0], q[1], q[2]);
        const double length = rotation.norm();
        ndg::require_input(std::isfinite(length) && length > 1e-6,
                           "joint {}: the quaternion {}, {}, {}, {} is no rotation", skeleton.joint_names[j], q[0],
                           q[1], q[2], q[3]);
        pose.parent_from_joint.push_back(rotation.normalized().toRotationMatrix());
    }
    for (int axis = 0; axis < 3; ++axis) {
        ndg::require_input(std::isfinite(displacement[axis]), "the displacement of the root is not finite");
        pose.root_translation[axis] = displacement[axis];
    }
    return pose;
}

}  // namespace

const char* ndg_error(void)
{
    return last_error.c_str();
}

void ndg_set_num_threads(int count)
{
    ndg::set_num_threads(count > 0 ? count : 0);
}

int ndg_load(const char* template_path, const char* bodies_path, const char* model_path, ndg_runtime** runtime)
{
    return guarded([&] {
        ndg::require_input(
            runtime != nullptr && template_path != nullptr && bodies_path != nullptr && model_path != nullptr,
            "ndg_load was given a null pointer");
        *runtime = nullptr;
        *runtime = std::make_unique<ndg_runtime>(template_path, bodies_path, model_path).release();
    });
}

void ndg_free(ndg_runtime* runtime)
{
    delete runtime;
}

int ndg_num_bodies(const ndg_runtime* runtime)
{
    return static_cast<int>(runtime->bodies.size());
}

const char* ndg_body_name(const ndg_runtime* runtime, int body)
{
    return has(runtime->bodies, body) ? runtime->bodies[body].name.c_str() : nullptr;
}

int ndg_num_joints(const ndg_runtime* runtime)
{
    return runtime->body_template.skeleton.num_joints();
}

const char* ndg_joint_name(const ndg_runtime* runtime, int joint)
{
    const std::vector<std::string>& names = runtime->body_template.skeleton.joint_names;
    return has(names, joint) ? names[joint].c_str() : nullptr;
}

int ndg_joint_parent(const ndg_runtime* runtime, int joint)
{
    const std::vector<int>& parents = runtime->body_template.skeleton.parents;
    return has(parents, joint) ? parents[joint] : -1;
}

int ndg_set_body(ndg_runtime* runtime, int body)
{
    return guarded([&] {
        ndg::require_input(has(runtime->bodies, body), "body {} was asked for, there are {}", body,
                           runtime->bodies.size());
        runtime->runtime.set_body(runtime->bodies[body]);
    });
}

int ndg_set_pose(ndg_runtime* runtime, const double* parent_from_joint, const double* root_displacement)
{
    return guarded([&] {
        ndg::require_input(parent_from_joint != nullptr && root_displacement != nullptr,
                           "ndg_set_pose was given a null pointer");
        runtime->runtime.set_pose(pose_from(runtime->body_template.skeleton, parent_from_joint, root_displacement));
    });
}

int ndg_num_vertices(const ndg_runtime* runtime, ndg_surface surface)
{
    switch (surface) {
        case NDG_SKIN:
            return static_cast<int>(runtime->runtime.skin().rows());
        case NDG_MUSCLE_WRAP:
        case NDG_BONE_WRAP:
            return runtime->body_template.num_wrap_vertices();
        case NDG_ANATOMY:
            return static_cast<int>(runtime->runtime.anatomy().rows());
    }
    return 0;
}

const float* ndg_vertices(const ndg_runtime* runtime, ndg_surface surface)
{
    const float* const volume = runtime->runtime.volume().data();
    switch (surface) {
        case NDG_SKIN:
            return runtime->runtime.skin().data();
        case NDG_MUSCLE_WRAP:
            return volume + 3 * static_cast<std::ptrdiff_t>(runtime->body_template.num_wrap_vertices());
        case NDG_BONE_WRAP:
            return volume;
        case NDG_ANATOMY:
            return runtime->runtime.anatomy().data();
    }
    return nullptr;
}

int ndg_num_triangles(const ndg_runtime* runtime, ndg_surface surface)
{
    switch (surface) {
        case NDG_SKIN:
            return static_cast<int>(runtime->body_template.skin_triangles.rows());
        case NDG_MUSCLE_WRAP:
        case NDG_BONE_WRAP:
            return static_cast<int>(runtime->body_template.wrap_triangles.rows());
        case NDG_ANATOMY:
            return static_cast<int>(runtime->body_template.anatomy_triangles.rows());
    }
    return 0;
}

const int* ndg_triangles(const ndg_runtime* runtime, ndg_surface surface)
{
    switch (surface) {
        case NDG_SKIN:
            return runtime->body_template.skin_triangles.data();
        case NDG_MUSCLE_WRAP:
        case NDG_BONE_WRAP:
            return runtime->body_template.wrap_triangles.data();
        case NDG_ANATOMY:
            return runtime->body_template.anatomy_triangles.data();
    }
    return nullptr;
}

int ndg_num_parts(const ndg_runtime* runtime)
{
    return static_cast<int>(runtime->body_template.anatomy_parts.size());
}

int ndg_get_part(const ndg_runtime* runtime, int index, ndg_part* part)
{
    return guarded([&] {
        const std::vector<ndg::AnatomyPart>& parts = runtime->body_template.anatomy_parts;
        ndg::require_input(has(parts, index) && part != nullptr, "part {} was asked for, there are {}", index,
                           parts.size());
        const ndg::AnatomyPart& found = parts[index];
        *part = {found.name.c_str(),   found.layer == ndg::AnatomyLayer::bone ? 1 : 0,
                 found.vertex_begin,   found.vertex_end,
                 found.triangle_begin, found.triangle_end};
    });
}
