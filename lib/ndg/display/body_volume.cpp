// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/body_volume.h"

#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/tetrahedra.h"

#include <memory>

namespace ndg {
namespace {

Eigen::VectorXf ratio(const Eigen::VectorXd& deformed, const Eigen::VectorXd& rest)
{
    return (rest.array() > 0).select(deformed.array() / rest.array().max(1e-300), 0.0).cast<float>();
}

/// What the body at rest, bone wrap and what lies inside, has as vertices of tetrahedra.
Points stacked(const Eigen::Ref<const Points>& volume_vertices, const Points& interior_vertices, int num_wrap)
{
    Points vertices(num_wrap + interior_vertices.rows(), 3);
    vertices << volume_vertices.topRows(num_wrap), interior_vertices;
    return vertices;
}

/// The rest shape of the body of the last frame.
struct RestVolume {
    const Body* body = nullptr;
    Eigen::SparseMatrix<double> gradient;
    Eigen::VectorXd prism_volumes, tetrahedron_volumes;
};

VolumeFrame flesh_frame(const BodyVolume& shown, const RestVolume& rest, const Prisms& prisms)
{
    VolumeFrame frame;
    frame.vertices = shown.volume_vertices;
    frame.stored_vertices = shown.stored;
    frame.cell_fields["volume_change"] =
        ratio(prism_volumes(shown.volume_vertices, prisms), rest.prism_volumes).array() - 1.0f;
    const auto gradients = deformation_gradients(rest.gradient, shown.volume_vertices);
    Eigen::VectorXf& determinants = frame.cell_fields["determinant"] = Eigen::VectorXf(prisms.rows());
    for (Eigen::Index p = 0; p < prisms.rows(); ++p)
        determinants[p] = float(Eigen::Map<const Eigen::Matrix3d>(gradients.row(p).data()).determinant());
    if (shown.reference.rows() > 0) {
        require(shown.reference.rows() == shown.volume_vertices.rows(), "The reference has {} vertices instead of {}",
                shown.reference.rows(), shown.volume_vertices.rows());
        frame.point_fields["error"] = (shown.volume_vertices - shown.reference).rowwise().norm().cast<float>();
    }
    return frame;
}

VolumeFrame interior_frame(const BodyVolume& shown, const RestVolume& rest, const Template& body_template)
{
    VolumeFrame frame;
    frame.vertices = stacked(shown.volume_vertices, shown.interior_vertices, body_template.num_wrap_vertices());
    const Eigen::VectorXf determinants =
        ratio(tetrahedron_volumes(frame.vertices, body_template.tetrahedra), rest.tetrahedron_volumes);
    frame.cell_fields["determinant"] = determinants;
    frame.cell_fields["volume_change"] = determinants.array() - 1.0f;
    return frame;
}

}  // namespace

VolumeSequence body_volume(const Template& body_template, const std::string& template_path,
                           const LayerStiffness& stiffness, std::function<BodyVolume(int frame_idx)> frame)
{
    const int num_prisms = body_template.num_prisms(), fat_begin = body_template.fat_begin();
    const Eigen::Index num_tetrahedra = body_template.tetrahedra.rows();
    const auto layered = [&](double muscle, double fat) {
        Eigen::VectorXf values(num_prisms);
        values << Eigen::VectorXf::Constant(fat_begin, float(muscle)),
            Eigen::VectorXf::Constant(num_prisms - fat_begin, float(fat));
        return values;
    };
    VolumeSequence volume;
    volume.grids = {
        {"flesh",
         CellKind::wedge,
         {template_path, "/volume/prisms", {std::size_t(num_prisms), 6}},
         {{"layer", layered(1, 2)}, {"young_modulus", layered(stiffness.young_muscle, stiffness.young_fat)}}}};
    if (num_tetrahedra > 0)
        volume.grids.push_back({"bone_interior",
                                CellKind::tetrahedron,
                                {template_path, "/bone_interior/tetrahedra", {std::size_t(num_tetrahedra), 4}},
                                {{"layer", Eigen::VectorXf::Zero(num_tetrahedra)},
                                 {"young_modulus", Eigen::VectorXf::Zero(num_tetrahedra)}}});
    volume.frame = [frame = std::move(frame), &body_template, rest = RestVolume(),
                    num_grids = volume.grids.size()](int frame_idx) mutable {
        const BodyVolume shown = frame(frame_idx);
        if (rest.body != shown.body) {
            const Points& vertices = shown.body->volume_vertices;
            rest = {
                shown.body, gradient_operator(vertices, body_template.prisms),
                prism_volumes(vertices, body_template.prisms),
                tetrahedron_volumes(stacked(vertices, shown.body->interior_vertices, body_template.num_wrap_vertices()),
                                    body_template.tetrahedra)};
        }
        std::vector<VolumeFrame> frames = {flesh_frame(shown, rest, body_template.prisms)};
        if (num_grids > 1) frames.push_back(interior_frame(shown, rest, body_template));
        return frames;
    };
    return volume;
}

}  // namespace ndg
