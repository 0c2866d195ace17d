// SPDX-License-Identifier: Apache-2.0
// The elements of a layered body's elastic energy (NDG equation 7): flesh prisms and skin edges, their rest data and
// which of them meet at a vertex. What is unknown and how it is assembled: elastic_system.h.
#pragma once

#include "ndg/body/template.h"
#include "ndg/elastic/materials.h"
#include "ndg/elastic/shell.h"
#include "ndg/geometry/prism.h"

#include <array>
#include <vector>

namespace ndg {

/// A prism of flesh; vertices index the volume vertices, gradient is G_p, weight k_f V_p.
struct FleshElement {
    std::array<int, 6> vertices{};
    PrismGradient gradient;
    double weight = 0;
    double rest_volume = 0;
    Lame lame;
};

/// An edge of the skin with two triangles: x0, x1, left, right.
struct SkinElement {
    std::array<int, 4> vertices{};
    double rest_length = 0;
    HingeRest bend;
};

/// Made once per template; set_rest() changes the body.
class ElasticModel {
public:
    ElasticModel(const Template& body_template, const MaterialOptions& material);

    /// Throws Error for a flat or inverted rest prism or a skin edge of no length.
    void set_rest(const Eigen::Ref<const Points>& rest_vertices);

    int num_vertices() const { return num_vertices_; }
    /// The first N_w volume vertices are the bone wrap, which is given.
    int num_fixed_vertices() const { return num_fixed_; }
    const Prisms& prisms() const { return prisms_; }
    bool guards_volume() const { return material_.guards_volume(); }
    double stretch_stiffness() const { return material_.stretch_stiffness; }

    const std::vector<FleshElement>& flesh() const { return flesh_; }
    const std::vector<SkinElement>& skin() const { return skin_; }

    /// Elements with vertex v: flesh_around()[v], skin_around()[v].
    const std::vector<std::vector<int>>& flesh_around() const { return flesh_around_; }
    const std::vector<std::vector<int>>& skin_around() const { return skin_around_; }

private:
    MaterialOptions material_;
    Prisms prisms_;
    int num_vertices_ = 0, num_fixed_ = 0;
    std::vector<FleshElement> flesh_;
    std::vector<SkinElement> skin_;
    std::vector<std::vector<int>> flesh_around_, skin_around_;
};

}  // namespace ndg
