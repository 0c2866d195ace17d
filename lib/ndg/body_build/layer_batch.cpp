// SPDX-License-Identifier: Apache-2.0
#include "ndg/body_build/layer_batch.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/core/log.h"
#include "ndg/core/progress.h"

#include <algorithm>
#include <atomic>
#include <ctime>
#include <exception>
#include <filesystem>
#include <optional>
#include <string_view>

namespace ndg {
namespace {

namespace fs = std::filesystem;

constexpr double min_age_years = 18.0, max_age_years = 110.0;

std::string parts_folder(const LayerBatchOptions& options)
{
    return options.output + ".parts";
}

std::string_view bytes(const Points& points)
{
    return {reinterpret_cast<const char*>(points.data()), static_cast<std::size_t>(points.size()) * sizeof(double)};
}

/// Its name holds everything that the body depends on.
std::string part_file(const LayerBatchOptions& options, const Body& skin, const Person& person)
{
    std::string key = options.settings + skin.name + fmt::format(" {} {} ", person.sex, person.age_years);
    key += bytes(skin.skin_vertices);
    key += bytes(skin.joint_positions);
    return (fs::path(parts_folder(options)) / (sha256(key).substr(0, 24) + ".h5")).string();
}

/// Seconds this thread has worked, whatever else the machine does.
double thread_seconds()
{
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// What a batch knows of one body.
struct Outcome {
    std::optional<Body> body;
    Eigen::RowVectorXd parameters;
    std::string failure;
    bool resumed = false;
    double seconds = 0.0;
};

bool read_part(const std::string& path, const Template& body_template, Outcome& outcome)
{
    if (!fs::exists(path)) return false;
    try {
        BodySet part;
        std::exception_ptr failure;
        // HDF5 need not be built for several threads.
#pragma omp critical(layer_batch_file)
        {
            try {
                part = read_bodies(path, body_template);
            } catch (...) {
                failure = std::current_exception();
            }
        }
        if (failure) std::rethrow_exception(failure);
        if (part.parameter_names != layer_parameter_names()) return false;
        outcome.body = std::move(part.bodies.front());
        outcome.parameters = part.parameters.row(0);
        outcome.resumed = true;
        return true;
    } catch (const Error& error) {
        log_warning("{} is made anew: {}", path, error.what());
        return false;
    }
}

void write_part(const std::string& path, const Outcome& outcome, const Template& body_template)
{
    BodySet part;
    part.bodies.push_back(*outcome.body);
    part.parameter_names = layer_parameter_names();
    part.parameters = outcome.parameters;
    part.template_sha256 = body_template.file_sha256;
    std::exception_ptr failure;
#pragma omp critical(layer_batch_file)
    {
        try {
            write_bodies(path, part, {"build-layers", "{}", {}, ""});
        } catch (...) {
            failure = std::current_exception();
        }
    }
    if (failure) std::rethrow_exception(failure);
}

void build_one(const LayerBuilder& builder, const Body& skin, const Person& person, const LayerBatchOptions& options,
               Outcome& outcome)
{
    const std::string part = part_file(options, skin, person);
    if (read_part(part, builder.body_template(), outcome)) return;
    const double start = thread_seconds();
    LayerReport report;
    outcome.body = builder.build(skin, person, &report);
    outcome.parameters = layer_parameters(person, report);
    outcome.seconds = thread_seconds() - start;
    write_part(part, outcome, builder.body_template());
}

}  // namespace

void describe(OptionList& list, PeopleOptions& options)
{
    list.add("sex", options.sex, "of all people; 'skins': the skins' parameters sex and age_years");
    list.add("age-years", options.age_years, "of all people, unless the skins say", min_age_years, max_age_years);
}

std::vector<Person> people_of_skins(const BodySet& skins, const std::string& path, const PeopleOptions& options)
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

LayerBatch build_layer_batch(const LayerBuilder& builder, const BodySet& skins, const std::vector<Person>& people,
                             const LayerBatchOptions& options, const std::function<bool()>& stop)
{
    require(people.size() == skins.bodies.size(), "{} skins were given with {} people", skins.bodies.size(),
            people.size());
    fs::create_directories(parts_folder(options));
    const std::size_t count = skins.bodies.size();
    std::vector<Outcome> outcomes(count);
    std::atomic<bool> stopped{false};
    std::exception_ptr fatal;
    Progress progress("build-layers", count);
#pragma omp parallel for schedule(dynamic, 1)
    for (std::size_t b = 0; b < count; ++b) {
        if (stopped || stop()) {
            stopped = true;
            continue;
        }
        try {
            build_one(builder, skins.bodies[b], people[b], options, outcomes[b]);
        } catch (const Error& error) {
            outcomes[b].failure = error.what();
        } catch (...) {
#pragma omp critical(layer_batch_fatal)
            fatal = std::current_exception();
            stopped = true;
        }
        progress.advance();
    }
    if (fatal) std::rethrow_exception(fatal);
    if (stopped)
        throw Interrupted(fmt::format(
            "interrupted; finished bodies are kept in {}, the same command goes on from there", parts_folder(options)));
    LayerBatch batch;
    batch.bodies.parameter_names = layer_parameter_names();
    batch.bodies.template_sha256 = skins.template_sha256;
    std::vector<Eigen::RowVectorXd> parameters;
    for (Outcome& outcome : outcomes) {
        if (!outcome.body) {
            batch.failures.push_back(outcome.failure);
            continue;
        }
        batch.bodies.bodies.push_back(std::move(*outcome.body));
        parameters.push_back(outcome.parameters);
        if (outcome.resumed)
            ++batch.num_resumed;
        else
            batch.seconds.push_back(outcome.seconds);
    }
    batch.bodies.parameters.resize(static_cast<Eigen::Index>(parameters.size()),
                                   static_cast<Eigen::Index>(layer_parameter_names().size()));
    for (std::size_t i = 0; i < parameters.size(); ++i)
        batch.bodies.parameters.row(static_cast<Eigen::Index>(i)) = parameters[i];
    return batch;
}

void remove_layer_parts(const LayerBatchOptions& options)
{
    std::error_code error;
    fs::remove_all(parts_folder(options), error);
    if (error) log_warning("{} could not be removed: {}", parts_folder(options), error.message());
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
