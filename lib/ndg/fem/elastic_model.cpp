// SPDX-License-Identifier: Apache-2.0
#include "ndg/fem/elastic_model.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"

namespace ndg {

namespace {

template <class Element>
std::vector<std::vector<int>> elements_around(const std::vector<Element>& elements, int num_vertices)
{
    std::vector<std::vector<int>> around(static_cast<std::size_t>(num_vertices));
    for (std::size_t e = 0; e < elements.size(); ++e) {
        for (const int vertex : elements[e].vertices) {
            around[static_cast<std::size_t>(vertex)].push_back(static_cast<int>(e));
        }
    }
    return around;
}

}  // namespace

ElasticModel::ElasticModel(const Template& body_template, const MaterialOptions& material)
    : material_((check_options(material), material)),
      prisms_(body_template.prisms),
      num_vertices_(body_template.num_volume_vertices()),
      num_fixed_(body_template.num_wrap_vertices()),
      flesh_(static_cast<std::size_t>(prisms_.rows()))
{
    const Lame muscle = lame_parameters(material.young_muscle_pascal, material.poisson_ratio);
    const Lame fat = lame_parameters(material.young_fat_pascal, material.poisson_ratio);
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        FleshElement& element = flesh_[static_cast<std::size_t>(p)];
        for (int a = 0; a < 6; ++a) element.vertices[static_cast<std::size_t>(a)] = prisms_(p, a);
        element.lame = p >= body_template.fat_begin() ? fat : muscle;
    }
    // A hinge needs two triangles; edges on the cuts at head, hands and toes have one and carry no skin energy.
    const int skin_begin = 2 * num_fixed_;
    for (const MeshEdge& edge : mesh_edges(body_template.wrap_triangles, num_fixed_)) {
        if (edge.right_triangle < 0) continue;
        SkinElement element;
        element.vertices = {skin_begin + edge.v0, skin_begin + edge.v1, skin_begin + edge.left_vertex,
                            skin_begin + edge.right_vertex};
        skin_.push_back(element);
    }
    flesh_around_ = elements_around(flesh_, num_vertices_);
    skin_around_ = elements_around(skin_, num_vertices_);
    set_rest(body_template.rest.volume_vertices);
}

void ElasticModel::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    require(rest_vertices.rows() == num_vertices_, "the body has {} volume vertices, the template {}",
            rest_vertices.rows(), num_vertices_);
    for (Eigen::Index p = 0; p < prisms_.rows(); ++p) {
        FleshElement& element = flesh_[static_cast<std::size_t>(p)];
        const PrismVertices prism = gather_prism(rest_vertices, prisms_, p);
        const double volume = prism_volume(prism);
        require(volume > 0, "rest prism {} has volume {} m^3", p, volume);
        element.gradient = prism_gradient_operator(prism);
        element.rest_volume = volume;
        element.weight = material_.flesh_stiffness * volume;
    }
    const auto position = [&](int vertex) -> Eigen::Vector3d { return rest_vertices.row(vertex).transpose(); };
    for (SkinElement& element : skin_) {
        const auto& v = element.vertices;
        const Hinge hinge{position(v[0]), position(v[1]), position(v[2]), position(v[3])};
        const Eigen::Vector3d along = hinge.x1 - hinge.x0;
        element.rest_length = along.norm();
        element.bend.left_area = 0.5 * along.cross(hinge.left - hinge.x0).norm();
        element.bend.right_area = 0.5 * along.cross(hinge.right - hinge.x0).norm();
        require(element.bend.left_area > 0 && element.bend.right_area > 0,
                "the skin triangles at volume vertices {} and {} have rest areas {} and {} m^2", v[0], v[1],
                element.bend.left_area, element.bend.right_area);
        element.bend.angle = dihedral_angle(hinge.x0, hinge.x1, hinge.left, hinge.right);
        element.bend.weight = 3 * material_.bend_stiffness * element.rest_length * element.rest_length /
                              (element.bend.left_area + element.bend.right_area);
    }
}

}  // namespace ndg
