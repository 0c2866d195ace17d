// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/geometry/prism.h"
#include "ndg/io/h5.h"

#include <algorithm>
#include <limits>

namespace ndg {

namespace {

constexpr int format_version = 1;

/// Writes one array of every body as bodies x rows x 3.
template <typename T, typename Owner>
void write_positions(H5Writer& writer, const std::string& dataset, const PeopleOf<T>& bodies, Points Owner::*positions,
                     const std::string& description)
{
    const Eigen::Index rows = (bodies.bodies.front().*positions).rows();
    writer.create(dataset, {bodies.bodies.size(), static_cast<std::size_t>(rows), 3}, description);
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const Points& points = bodies.bodies[i].*positions;
        require(points.rows() == rows, "Body {} has {} rows for {}, the first body {}", bodies.bodies[i].name,
                points.rows(), dataset, rows);
        if (rows == 0) continue;
        const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> stored = points.cast<float>();
        writer.write_slice(dataset, i, stored.data());
    }
}

template <typename T, typename Owner>
void read_positions(const H5Reader& reader, const std::string& dataset, Eigen::Index rows, PeopleOf<T>& bodies,
                    Points Owner::*positions)
{
    const std::vector<std::size_t> expected = {bodies.bodies.size(), static_cast<std::size_t>(rows), 3};
    const std::vector<std::size_t> shape = reader.shape(dataset);
    require_input(shape == expected, "{}: {} has shape {}, but {} bodies of this template need {} x {} x 3",
                  reader.path(), dataset, fmt::join(shape, " x "), expected[0], expected[0], rows);
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        Points& points = bodies.bodies[i].*positions;
        points.resize(rows, 3);
        if (rows == 0) continue;
        const std::vector<float> stored = reader.read_slice(dataset, i);
        points = Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(stored.data(), rows, 3)
                     .cast<double>();
    }
}

/// What bodies and skins have in common.
template <typename T>
void write_common(H5Writer& writer, const PeopleOf<T>& bodies)
{
    const auto count = static_cast<Eigen::Index>(bodies.bodies.size());
    const auto num_parameters = static_cast<Eigen::Index>(bodies.parameter_names.size());
    std::vector<std::string> names;
    for (const T& body : bodies.bodies) names.push_back(body.name);
    require(num_parameters == 0 || (bodies.parameters.rows() == count && bodies.parameters.cols() == num_parameters),
            "{} bodies with {} parameters were given {} x {} parameter values", count, num_parameters,
            bodies.parameters.rows(), bodies.parameters.cols());
    writer.attribute("template_sha256", bodies.template_sha256);
    writer.write("/bodies/names", names, "names of the bodies");
    writer.write("/bodies/parameter_names", bodies.parameter_names, "names of the parameters, unit as suffix");
    writer.write("/bodies/parameters", num_parameters > 0 ? bodies.parameters : RowMatrix(count, 0),
                 "parameters of each body", Storage::float64);
    write_positions(writer, "/bodies/skin_vertices", bodies, &Skin::skin_vertices, "rest positions of the skins, m");
    write_positions(writer, "/bodies/joint_positions", bodies, &Skin::joint_positions,
                    "rest positions of the joints, m");
}

template <typename T>
PeopleOf<T> read_common(const H5Reader& reader, const Template& body_template)
{
    PeopleOf<T> bodies;
    const std::vector<std::string> names = reader.read_strings("/bodies/names");
    require_input(!names.empty(), "{}: /bodies/names is empty", reader.path());
    bodies.bodies.resize(names.size());
    for (std::size_t i = 0; i < names.size(); ++i) bodies.bodies[i].name = names[i];
    bodies.template_sha256 = reader.attribute("template_sha256");
    require_input(bodies.template_sha256.empty() || body_template.file_sha256.empty() ||
                      bodies.template_sha256 == body_template.file_sha256,
                  "{}: these bodies belong to a template with hash {}, not to the one given with hash {}",
                  reader.path(), bodies.template_sha256, body_template.file_sha256);
    bodies.parameter_names = reader.read_strings("/bodies/parameter_names");
    bodies.parameters = reader.read_matrix("/bodies/parameters", static_cast<Eigen::Index>(names.size()),
                                           static_cast<Eigen::Index>(bodies.parameter_names.size()));
    read_positions(reader, "/bodies/skin_vertices", body_template.rest.skin_vertices.rows(), bodies,
                   &Skin::skin_vertices);
    read_positions(reader, "/bodies/joint_positions", body_template.skeleton.num_joints(), bodies,
                   &Skin::joint_positions);
    return bodies;
}

}  // namespace

void write_bodies(const std::string& path, const BodySet& bodies, const Provenance& provenance)
{
    require(!bodies.bodies.empty(), "There are no bodies to write to {}", path);
    H5Writer writer(path, "ndg-bodies", format_version, provenance);
    write_common(writer, bodies);
    write_positions(writer, "/bodies/volume_vertices", bodies, &Body::volume_vertices,
                    "rest positions of bone wrap, muscle wrap and volumetric skin, m");
    write_positions(writer, "/bodies/interior_vertices", bodies, &Body::interior_vertices,
                    "rest positions inside the bone wrap, m");
    writer.commit();
}

BodySet read_bodies(const std::string& path, const Template& body_template)
{
    const H5Reader reader(path, "ndg-bodies", format_version);
    BodySet bodies = read_common<Body>(reader, body_template);
    read_positions(reader, "/bodies/volume_vertices", body_template.num_volume_vertices(), bodies,
                   &Body::volume_vertices);
    read_positions(reader, "/bodies/interior_vertices", body_template.rest.interior_vertices.rows(), bodies,
                   &Body::interior_vertices);
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const PrismCheck check = check_prisms(bodies.bodies[i].volume_vertices, body_template.prisms);
        require_input(check.num_invalid == 0,
                      "{}: /bodies/volume_vertices[{}] ({}) has {} invalid rest prisms, the worst is prism {} with "
                      "Jacobian {} m^3",
                      path, i, bodies.bodies[i].name, check.num_invalid, check.worst_prism_idx, check.min_jacobian);
    }
    return bodies;
}

void write_skins(const std::string& path, const SkinSet& skins, const Provenance& provenance)
{
    require(!skins.bodies.empty(), "There are no skins to write to {}", path);
    H5Writer writer(path, "ndg-skins", format_version, provenance);
    write_common(writer, skins);
    writer.commit();
}

SkinSet read_skins(const std::string& path, const Template& body_template)
{
    return read_common<Skin>(H5Reader(path, "ndg-skins", format_version), body_template);
}

PrismCheck check_prisms(const Eigen::Ref<const Points>& volume_vertices, const Eigen::Ref<const Prisms>& prisms)
{
    Eigen::VectorXd jacobians(prisms.rows());
#pragma omp parallel for schedule(static)
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        const PrismVertices prism = gather_prism(volume_vertices, prisms, p);
        // Positions that are no numbers make the worst prism there is.
        jacobians[p] = prism.allFinite() ? prism_min_jacobian(prism) : -std::numeric_limits<double>::infinity();
    }
    PrismCheck check;
    for (Eigen::Index p = 0; p < prisms.rows(); ++p) {
        if (check.worst_prism_idx < 0 || jacobians[p] < check.min_jacobian) {
            check.min_jacobian = jacobians[p];
            check.worst_prism_idx = static_cast<int>(p);
        }
        if (!(jacobians[p] > 0.0)) ++check.num_invalid;
    }
    return check;
}

double min_scaled_jacobian(const Eigen::Ref<const Points>& volume_vertices, const Eigen::Ref<const Prisms>& prisms)
{
    double smallest = std::numeric_limits<double>::infinity();
    for (Eigen::Index p = 0; p < prisms.rows(); ++p)
        smallest = std::min(smallest, prism_min_scaled_jacobian(gather_prism(volume_vertices, prisms, p)));
    return smallest;
}

}  // namespace ndg
