// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/layer_batch.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/stopwatch.h"
#include "ndg/dataset/run_batch.h"

#include <algorithm>
#include <string_view>

namespace ndg {
namespace {

constexpr double min_age_years = 18.0, max_age_years = 110.0;

std::string_view bytes(const Points& points)
{
    return {reinterpret_cast<const char*>(points.data()), static_cast<std::size_t>(points.size()) * sizeof(double)};
}

BatchItem batch_item(int body_idx, const Skin& skin, const Person& person)
{
    std::string content = skin.name + fmt::format(" {} {} ", person.sex, person.age_years);
    content += bytes(skin.skin_vertices);
    content += bytes(skin.joint_positions);
    return {fmt::format("{:06d}", body_idx), sha256(content), "body " + skin.name};
}

/// What is kept of a body while others are built.
struct BuiltBody {
    Body body;
    RowMatrix parameters;  ///< one row
    double seconds = 0.0;
};

void write_built(H5Writer& writer, const BuiltBody& built)
{
    const Body& body = built.body;
    writer.attribute("name", body.name);
    writer.attribute("seconds", built.seconds);
    writer.write("/body/skin_vertices", body.skin_vertices, "skin at rest, m", Storage::float64);
    writer.write("/body/volume_vertices", body.volume_vertices, "wraps at rest, m", Storage::float64);
    writer.write("/body/interior_vertices", body.interior_vertices, "inside the bone wrap, m", Storage::float64);
    writer.write("/body/joint_positions", body.joint_positions, "joints at rest, m", Storage::float64);
    writer.write("/body/parameters", built.parameters, "layer_parameter_names", Storage::float64);
}

BuiltBody read_built(const H5Reader& reader, const Template& body_template)
{
    const auto points = [&](const std::string& name, const Points& rest) -> Points {
        return reader.read_matrix("/body/" + name, rest.rows(), 3);
    };
    const Body& rest = body_template.rest;
    BuiltBody built;
    built.body.name = reader.attribute("name");
    built.seconds = reader.attribute_double("seconds");
    built.body.skin_vertices = points("skin_vertices", rest.skin_vertices);
    built.body.volume_vertices = points("volume_vertices", rest.volume_vertices);
    built.body.interior_vertices = points("interior_vertices", rest.interior_vertices);
    built.body.joint_positions = points("joint_positions", rest.joint_positions);
    built.parameters =
        reader.read_matrix("/body/parameters", 1, static_cast<Eigen::Index>(layer_parameter_names().size()));
    return built;
}

/// A skin that does not fit is its own failure, not the batch's.
BuiltBody build_one(const LayerBuilder& builder, const Skin& skin, const Person& person)
{
    try {
        const double start = thread_seconds();
        LayerReport report;
        BuiltBody built;
        built.body = builder.build(skin, person, &report);
        built.parameters = layer_parameters(person, report);
        built.seconds = thread_seconds() - start;
        return built;
    } catch (const InputError& error) {
        throw Error(error.what());
    }
}

}  // namespace

void describe(OptionList& list, PeopleOptions& options)
{
    list.add("sex", options.sex, "of all people; 'skins': the skins' parameters sex and age_years");
    list.add("age-years", options.age_years, "of all people, unless the skins say", min_age_years, max_age_years);
}

std::vector<Person> people_of_skins(const SkinSet& skins, const std::string& path, const PeopleOptions& options)
{
    const double sex = options.sex == SexSource::male ? 1.0 : options.sex == SexSource::female ? 0.0 : 0.5;
    std::vector<Person> people(skins.bodies.size(), Person{sex, options.age_years});
    if (options.sex == SexSource::skins) {
        const auto column = [&](const std::string& name) {
            const auto found = std::find(skins.parameter_names.begin(), skins.parameter_names.end(), name);
            require_input(found != skins.parameter_names.end(), "{}: has no body parameter '{}'", path, name);
            return found - skins.parameter_names.begin();
        };
        const Eigen::Index sex_column = column("sex"), age_column = column("age_years");
        for (std::size_t b = 0; b < people.size(); ++b)
            people[b] = {skins.parameters(static_cast<Eigen::Index>(b), sex_column),
                         skins.parameters(static_cast<Eigen::Index>(b), age_column)};
    }
    for (std::size_t b = 0; b < people.size(); ++b) {
        const Person& person = people[b];
        require_input(person.sex >= 0.0 && person.sex <= 1.0, "{}: body {} has sex {}, allowed is 0 to 1", path,
                      skins.bodies[b].name, person.sex);
        require_input(person.age_years >= min_age_years && person.age_years <= max_age_years,
                      "{}: body {} is {} years old, allowed is {} to {}", path, skins.bodies[b].name, person.age_years,
                      min_age_years, max_age_years);
    }
    return people;
}

LayerBatch build_layer_batch(const LayerBuilder& builder, const SkinSet& skins, const std::vector<Person>& people,
                             const PartStore& store, const std::function<bool()>& stop)
{
    require(people.size() == skins.bodies.size(), "{} skins were given with {} people", skins.bodies.size(),
            people.size());
    const Template& body_template = builder.body_template();
    Batch batch;
    batch.task = "build-layers";
    for (std::size_t b = 0; b < people.size(); ++b) {
        batch.items.push_back(batch_item(static_cast<int>(b), skins.bodies[b], people[b]));
    }
    batch.read = [&](const H5Reader& part) { read_built(part, body_template); };
    batch.make_worker = [&] {
        return [&](int b) -> PartWriter {
            const BuiltBody built = build_one(builder, skins.bodies[b], people[b]);
            return [built](H5Writer& part) { write_built(part, built); };
        };
    };
    LayerBatch result;
    result.num_resumed = run_batch(store, batch, stop);
    result.bodies.parameter_names = layer_parameter_names();
    result.bodies.template_sha256 = skins.template_sha256;
    RowMatrix& parameters = result.bodies.parameters;
    parameters.resize(static_cast<Eigen::Index>(people.size()), layer_parameter_names().size());
    for (const BatchItem& item : batch.items) {
        BuiltBody built;
        const std::string failure =
            store.read(item, [&](const H5Reader& part) { built = read_built(part, body_template); });
        if (!failure.empty()) {
            result.failures.push_back(failure);
            continue;
        }
        parameters.row(result.bodies.bodies.size()) = built.parameters;
        result.bodies.bodies.push_back(std::move(built.body));
        result.seconds.push_back(built.seconds);
    }
    parameters.conservativeResize(result.bodies.bodies.size(), Eigen::NoChange);
    return result;
}

const std::vector<std::string>& layer_parameter_names()
{
    static const std::vector<std::string> names = {"sex",
                                                   "age_years",
                                                   "stature_m",
                                                   "mass_kg",
                                                   "bmi",
                                                   "neck_girth_m",
                                                   "abdomen_girth_m",
                                                   "waist_girth_m",
                                                   "hip_girth_m",
                                                   "upper_arm_girth_m",
                                                   "forearm_girth_m",
                                                   "thigh_girth_m",
                                                   "calf_girth_m",
                                                   "fat_share",
                                                   "subcutaneous_fat_litre",
                                                   "skeletal_muscle_kg",
                                                   "wanted_fat_layer_litre",
                                                   "fat_layer_litre",
                                                   "muscle_layer_litre",
                                                   "min_scaled_jacobian",
                                                   "mean_skin_displacement_m",
                                                   "max_skin_displacement_m"};
    return names;
}

Eigen::RowVectorXd layer_parameters(const Person& person, const LayerReport& r)
{
    const BodyGirths& g = r.girths;
    Eigen::RowVectorXd values(static_cast<Eigen::Index>(layer_parameter_names().size()));
    values << person.sex, person.age_years, r.stature_m, r.mass_kg, r.bmi, g.neck, g.abdomen, g.waist, g.hip,
        g.upper_arm, g.forearm, g.thigh, g.calf, r.composition.fat_share, r.composition.subcutaneous_litre,
        r.composition.muscle_mass_kg, r.wanted_fat_litre, r.fat_layer_litre, r.muscle_layer_litre,
        r.fit.min_scaled_jacobian, r.fit.mean_skin_displacement, r.fit.max_skin_displacement;
    return values;
}

}  // namespace ndg
