// SPDX-License-Identifier: Apache-2.0
#include "ndg/measures/body_measures.h"

#include "ndg/body/anatomy.h"
#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/measures/measure_report.h"
#include "ndg/measures/measured_parts.h"

#include <algorithm>

namespace ndg {
namespace {

/// m, over the bodies of a set.
constexpr double largest_mean_hip_distance = 0.012;
constexpr int least_bodies_of_mean = 10;

const Skin& checked(const Template& body_template, const Skin& skin)
{
    require(skin.skin_vertices.rows() == body_template.rest.skin_vertices.rows() &&
                skin.joint_positions.rows() == body_template.rest.joint_positions.rows(),
            "body {}: has {} skin vertices and {} joints, the template has {} and {}", skin.name,
            skin.skin_vertices.rows(), skin.joint_positions.rows(), body_template.rest.skin_vertices.rows(),
            body_template.rest.joint_positions.rows());
    return skin;
}

MeasuredBody measured(const MeasuredSkin& skin, const Person& person, const MeasureTable& table)
{
    return {skin.skin.name, person, skin.stature_m, skin.bmi, table.measures()};
}

/// By the parameters "sex" and "age_years"; an unknown person without them.
template <typename T>
Person person_of(const PeopleOf<T>& people, int body_idx)
{
    Person person;
    for (std::size_t k = 0; k < people.parameter_names.size(); ++k) {
        if (people.parameter_names[k] == "sex") person.sex = people.parameters(body_idx, k);
        if (people.parameter_names[k] == "age_years") person.age_years = people.parameters(body_idx, k);
    }
    return person;
}

template <typename T, typename Measure>
std::vector<MeasuredBody> measure_all(const Template& body_template, const PeopleOf<T>& people, const Measure& measure)
{
    std::vector<MeasuredBody> measured(people.bodies.size());
    parallel_for(static_cast<int>(measured.size()),
                 [&](int b) { measured[b] = measure(body_template, people.bodies[b], person_of(people, b)); });
    return measured;
}

}  // namespace

MeasuredSkin::MeasuredSkin(const Template& measured_template, const Skin& measured_skin)
    : body_template(measured_template),
      skin(checked(measured_template, measured_skin)),
      stature_m(stature(skin.skin_vertices)),
      floor_m(skin.skin_vertices.col(1).minCoeff()),
      mass_kg(body_density * enclosed_volume(skin.skin_vertices, body_template.skin_triangles)),
      bmi(mass_kg / (stature_m * stature_m)),
      surface(skin.skin_vertices, body_template.skin_triangles)
{
}

Eigen::Vector3d MeasuredSkin::joint(const std::string& name) const
{
    return skin.joint_positions.row(body_template.skeleton.joint(name)).transpose();
}

double MeasuredSkin::cover(const Points& points) const
{
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index i = 0; i < points.rows(); ++i) least = std::min(least, depth(points.row(i).transpose()));
    return least;
}

MeasuredBones::MeasuredBones(const Template& measured_template, const Body& measured_body)
    : MeasuredSkin(measured_template, measured_body),
      body(measured_body),
      anatomy(anatomy_at_rest(measured_template, measured_body)),
      meshes(bone_meshes(measured_template, anatomy)),
      bones(meshes)
{
}

bool MeasuredBones::has(const std::vector<std::string>& names) const
{
    return std::all_of(names.begin(), names.end(),
                       [&](const std::string& name) { return bones.find(name) != nullptr; });
}

Points between_shares(const Points& vertices, const Eigen::Vector3d& axis, double low, double high)
{
    const Eigen::VectorXd along = vertices * axis;
    const double begin = along.minCoeff(), extent = along.maxCoeff() - begin;
    Points result(vertices.rows(), 3);
    Eigen::Index count = 0;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v)
        if (along[v] >= begin + low * extent && along[v] <= begin + high * extent)
            result.row(count++) = vertices.row(v);
    return result.topRows(count);
}

std::vector<std::string> MeasuredBody::failures() const
{
    std::vector<std::string> sentences;
    for (const BodyMeasure& measure : measures)
        if (measure.gate && measure.outside()) sentences.push_back(measure.failure());
    return sentences;
}

MeasuredBody measure_body(const Template& body_template, const Body& body, const Person& person)
{
    const MeasuredBones bones(body_template, body);
    MeasureTable table(person);
    add_joint_measures(bones, table);
    add_spine_measures(bones, table);
    add_trunk_measures(bones, table);
    add_limb_measures(bones, table);
    add_flesh_measures(bones, table);
    return measured(bones, person, table);
}

MeasuredBody measure_skin(const Template& body_template, const Skin& skin, const Person& person)
{
    const MeasuredSkin measured_skin(body_template, skin);
    MeasureTable table(person);
    add_joint_measures(measured_skin, table);
    return measured(measured_skin, person, table);
}

std::vector<MeasuredBody> measure_people(const Template& body_template, const BodySet& bodies)
{
    return measure_all(body_template, bodies, measure_body);
}

std::vector<MeasuredBody> measure_people(const Template& body_template, const SkinSet& skins)
{
    return measure_all(body_template, skins, measure_skin);
}

std::vector<std::string> common_failures(const std::vector<MeasuredBody>& bodies)
{
    double sum = 0.0;
    int count = 0;
    for (const MeasuredBody& body : bodies)
        for (const BodyMeasure& measure : body.measures) {
            if (measure.name != hip_centre_measure) continue;
            sum += measure.value;
            ++count;
        }
    std::vector<std::string> sentences;
    if (count >= least_bodies_of_mean && sum / count > largest_mean_hip_distance)
        sentences.push_back(fmt::format("{}: {} in the mean of {} bodies, allowed {}", hip_centre_measure,
                                        measure_text(sum / count, MeasureUnit::millimetre), count,
                                        measure_text(largest_mean_hip_distance, MeasureUnit::millimetre)));
    return sentences;
}

}  // namespace ndg
