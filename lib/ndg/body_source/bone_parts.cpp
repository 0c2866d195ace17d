// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_source/bone_parts.h"

#include "ndg/core/error.h"

#include <cctype>

namespace ndg {
namespace {

std::string lower(std::string text)
{
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

}  // namespace

PartFinder::PartFinder(const std::vector<AnatomyMesh>& parts)
{
    for (const AnatomyMesh& part : parts) parts_.emplace(lower(part.name), &part);
}

const AnatomyMesh* PartFinder::find(const std::string& name) const
{
    const auto found = parts_.find(lower(name));
    return found == parts_.end() ? nullptr : found->second;
}

const AnatomyMesh& PartFinder::part(const std::string& name) const
{
    const AnatomyMesh* found = find(name);
    require(found != nullptr, "the anatomy has no part '{}'", name);
    return *found;
}

std::vector<AnatomyMesh> bone_meshes(const Template& body_template, const Eigen::Ref<const Points>& anatomy)
{
    std::vector<AnatomyMesh> bones;
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != AnatomyLayer::bone || part.vertex_end == part.vertex_begin) continue;
        AnatomyMesh& bone = bones.emplace_back();
        bone.name = part.name;
        bone.fma_id = part.fma_id;
        bone.side = part.side;
        bone.layer = part.layer;
        bone.vertices = anatomy.middleRows(part.vertex_begin, part.vertex_end - part.vertex_begin);
        bone.triangles =
            body_template.anatomy_triangles.middleRows(part.triangle_begin, part.triangle_end - part.triangle_begin)
                .array() -
            part.vertex_begin;
    }
    return bones;
}

Eigen::Vector3d end_centre(const Points& vertices, const Eigen::Vector3d& direction, double depth)
{
    const Eigen::VectorXd along = vertices * direction.normalized();
    const double limit = along.maxCoeff() - depth;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double count = 0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) {
        if (along[v] < limit) continue;
        sum += vertices.row(v).transpose();
        count += 1;
    }
    return sum / count;
}

Eigen::Vector3d farthest(const Points& vertices, const Eigen::Vector3d& direction)
{
    Eigen::Index v = 0;
    (vertices * direction).maxCoeff(&v);
    return vertices.row(v).transpose();
}

Eigen::Vector3d middle(const Points& vertices)
{
    return vertices.colwise().mean().transpose();
}

Points near(const Points& vertices, const Eigen::Vector3d& centre, double radius)
{
    Points result(vertices.rows(), 3);
    Eigen::Index count = 0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        if ((vertices.row(v).transpose() - centre).norm() <= radius) result.row(count++) = vertices.row(v);
    return result.topRows(count);
}

Sphere head_sphere(const Points& vertices, const Eigen::Vector3d& direction, double expected_radius)
{
    const Eigen::Vector3d end = end_centre(vertices, direction, 0.6 * expected_radius);
    const Eigen::Vector3d guess = end - 0.6 * expected_radius * direction.normalized();
    return fit_sphere(near(vertices, guess, 1.35 * expected_radius));
}

}  // namespace ndg
