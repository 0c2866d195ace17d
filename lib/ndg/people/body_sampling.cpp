// SPDX-License-Identifier: Apache-2.0
#include "ndg/people/body_sampling.h"

#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/core/random.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/placement/skeleton_placer.h"
#include "ndg/procedural/body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>

namespace ndg {

namespace {

constexpr double stature_tolerance_m = 0.001, bmi_tolerance = 0.05;
constexpr double proportion_tolerance = 0.002;
constexpr int max_rounds = 20, max_bisections = 30;
constexpr double max_detail = 0.6, max_length_deviation = 1.8;
constexpr double mean_bmi = 23.5;
constexpr double thinnest = -1.0, fullest = 4.0;  ///< ends of the path of `on_path`

/// People along a path from thin to heavy: muscle grows to what is wished, then the weight slider rises, then muscle
/// turns to fat and fullness grows.
MakeHumanParameters on_path(const MakeHumanParameters& wished, double place)
{
    MakeHumanParameters p = wished;
    p.weight = std::clamp(place, 0.0, 1.0);
    p.muscle = wished.muscle * std::clamp(std::min(1.0 + place, 2.0 - place), 0.0, 1.0);
    p.fullness = std::clamp(place - 1.0, 0.0, 3.0);
    return p;
}

double bmi_of(const ParametricSurface& surface)
{
    const double height = stature(surface.vertices);
    return body_density * enclosed_volume(surface.vertices, surface.triangles) / (height * height);
}

}  // namespace

void BodySamplingOptions::check() const
{
    check_options(*this);
    require_input(max_bmi - min_bmi >= 1.0, "min-bmi {} and max-bmi {} are less than 1 apart", min_bmi, max_bmi);
}

void describe(OptionList& list, BodySamplingOptions& options)
{
    list.add("min-bmi", options.min_bmi, "smallest body mass index, kg/m^2", 14, 49);
    list.add("max-bmi", options.max_bmi, "largest body mass index (the procedural body ends at 35)", 15, 50);
    list.add("muscle-spread", options.muscle_spread, "standard deviation of MakeHuman's muscle slider", 0, 0.5);
    list.add("proportion-spread", options.proportion_spread, "of its proportions slider", 0, 0.5);
    list.add("detail-spread", options.detail_spread, "of its sliders for girths", 0, 0.5);
    list.add("length-spread", options.length_spread, "of lengths and shoulders, in published deviations", 0, 2);
}

MakeHumanParameters makehuman_parameters(const MakeHuman& source, const Adult& adult, MakeHumanParameters wished,
                                         const ProportionValues& lengths)
{
    wished.details.resize(makehuman_details().size(), 0.0);
    wished.sex = adult.male ? 1.0 : 0.0;
    // MakeHuman's slider runs from 25 years and less, 0.5, to 90, 1.
    wished.age = 0.5 + std::max(0.0, adult.age_years - 25.0) / 130.0;
    double place = 0.6, height = 0.5, reached_stature = 0.0, reached_bmi = 0.0;
    std::optional<MakeHumanParameters> settled;  ///< right but for the proportions
    for (int round = 0; round < max_rounds; ++round) {
        // Stature rises with the slider, and hardly depends on weight.
        double low = 0.0, high = 1.0;
        for (int step = 0; step < max_bisections; ++step) {
            wished.height = height;
            reached_stature = stature(source.evaluate(on_path(wished, place)).vertices);
            if (std::abs(reached_stature - adult.stature_m) < 0.5 * stature_tolerance_m) break;
            (reached_stature < adult.stature_m ? low : high) = height;
            height = 0.5 * (low + high);
        }
        // The wished muscle is kept where the weight slider suffices; beyond, losing it can undo what fullness adds.
        const bool slider_suffices = bmi_of(source.evaluate(on_path(wished, 1.0))) >= adult.bmi;
        low = slider_suffices ? thinnest : 1.0;
        high = slider_suffices ? 1.0 : fullest;
        place = std::clamp(place, low, high);
        for (int step = 0; step < max_bisections; ++step) {
            reached_bmi = bmi_of(source.evaluate(on_path(wished, place)));
            if (std::abs(reached_bmi - adult.bmi) < bmi_tolerance) break;
            (reached_bmi < adult.bmi ? low : high) = place;
            place = 0.5 * (low + high);
        }
        const MakeHumanParameters reached = on_path(wished, place);
        const ParametricSurface surface = source.evaluate(reached);
        reached_stature = stature(surface.vertices);
        const double miss = approach_proportions(surface, lengths, wished);
        const bool good = std::abs(reached_stature - adult.stature_m) < stature_tolerance_m &&
                          std::abs(reached_bmi - adult.bmi) < bmi_tolerance;
        if (good && miss < proportion_tolerance) return reached;
        if (good) settled = reached;
    }
    if (settled) return *settled;
    throw Error(
        fmt::format("MakeHuman's body cannot be {:.3f} m tall with a body mass index of {:.1f}: it came to "
                    "{:.3f} m and {:.1f}",
                    adult.stature_m, adult.bmi, reached_stature, reached_bmi));
}

MakeHumanParameters mean_adult(const MakeHuman& source, bool male)
{
    return makehuman_parameters(source, {male, 25.0, adult_statistics(male).mean_stature_m, mean_bmi}, {},
                                usual_proportions(male ? 1.0 : 0.0));
}

MakeHumanParameters sample_parameters(const MakeHuman& source, std::uint64_t seed, int body_idx,
                                      const BodySamplingOptions& options)
{
    options.check();
    const Adult adult = sample_adult(seed, body_idx, options.min_bmi, options.max_bmi);
    Random random(seed, "makehuman", static_cast<std::uint64_t>(body_idx));
    MakeHumanParameters wished;
    wished.muscle = std::clamp((adult.male ? 0.5 : 0.4) + options.muscle_spread * random.normal(), 0.05, 0.95);
    wished.proportions = std::clamp(0.5 + options.proportion_spread * random.normal(), 0.05, 0.95);
    for (std::size_t i = 0; i < makehuman_details().size(); ++i)
        wished.details.push_back(std::clamp(options.detail_spread * random.normal(), -max_detail, max_detail));
    std::array<double, num_proportions> deviations{};
    for (double& deviation : deviations)
        deviation = std::clamp(options.length_spread * random.normal(), -max_length_deviation, max_length_deviation);
    correlate_legs(deviations);
    return makehuman_parameters(source, adult, wished, usual_proportions(adult.male ? 1.0 : 0.0, deviations));
}

Skin skin_on_template(const Template& body_template, const ParametricSurface& surface, const std::string& name)
{
    require_input(body_template.source_vertices.rows() == body_template.rest.skin_vertices.rows(),
                  "the template was not made from a parametric source: it has no map from the source's vertices");
    require_input(body_template.source_vertices.maxCoeff() < surface.vertices.rows(),
                  "the template's source map uses vertex {}, the source has {}",
                  body_template.source_vertices.maxCoeff(), surface.vertices.rows());
    Skin body;
    body.name = name;
    const double scale = stature(surface.vertices) / stature(body_template.rest.skin_vertices);
    body.joint_positions = surface.joint_positions + scale * body_template.source_joint_offsets;
    body.skin_vertices.setZero(body_template.source_vertices.rows(), 3);
    for (Eigen::Index v = 0; v < body.skin_vertices.rows(); ++v)
        for (int k = 0; k < 3; ++k)
            body.skin_vertices.row(v) +=
                body_template.source_barycentric(v, k) * surface.vertices.row(body_template.source_vertices(v, k));
    return body;
}

namespace {

struct SampledPerson {
    ParametricSurface surface;
    double sex = 0.5, age_years = 30.0;
};

std::function<SampledPerson(int)> person_source(const Template& body_template, const std::string& makehuman_folder,
                                                std::uint64_t seed, const BodySamplingOptions& options)
{
    const std::optional<SourceKind> kind = find_name<SourceKind>(body_template.source_name);
    require_input(kind.has_value(),
                  "the template was not made from a source that bodies can be drawn from (its source is '{}')",
                  body_template.source_name);
    if (kind == SourceKind::procedural) {
        const auto source = std::make_shared<ProceduralBody>();
        return [source, seed, options](int b) {
            const ProceduralParameters p =
                sample_procedural_parameters(seed, b, options.min_bmi, std::min(options.max_bmi, max_procedural_bmi));
            return SampledPerson{source->evaluate(p), p.sex, p.age_years};
        };
    }
    require_input(!makehuman_folder.empty(), "the template was made from MakeHuman's body: give --makehuman");
    const auto source = std::make_shared<MakeHuman>(makehuman_folder);
    return [source, seed, options](int b) {
        const MakeHumanParameters p = sample_parameters(*source, seed, b, options);
        const Adult adult = sample_adult(seed, b, options.min_bmi, options.max_bmi);
        return SampledPerson{source->evaluate(p), p.sex, adult.age_years};
    };
}

}  // namespace

SkinSet sample_skins(const Template& body_template, const std::string& makehuman_folder, int count, std::uint64_t seed,
                     const BodySamplingOptions& options)
{
    options.check();
    const auto person = person_source(body_template, makehuman_folder, seed, options);
    std::optional<SkeletonPlacer> placer;  // a skin alone, without bones, keeps its source's joints
    if (SkeletonPlacer::has_trunk_bones(body_template)) placer.emplace(body_template);
    SkinSet skins;
    skins.parameter_names = {"sex", "age_years", "stature_m", "mass_kg", "bmi"};
    skins.parameters.resize(count, 5);
    skins.bodies.resize(count);
    std::vector<std::string> errors(count);
    Progress progress("sample-bodies", static_cast<std::size_t>(count));
#pragma omp parallel for schedule(dynamic)
    for (int b = 0; b < count; ++b) {
        try {
            const SampledPerson p = person(b);
            Skin body = skin_on_template(body_template, p.surface, fmt::format("body_{:04d}", b));
            if (placer) body.joint_positions = placer->joints(body, placer->trunk_map(body, p.sex));
            // Of the source's own surface: a coarse tessellation cuts some percent of the volume off.
            const double height = stature(p.surface.vertices);
            const double mass = body_density * enclosed_volume(p.surface.vertices, p.surface.triangles);
            skins.parameters.row(b) << p.sex, p.age_years, height, mass, mass / (height * height);
            skins.bodies[b] = std::move(body);
        } catch (const std::exception& error) {
            errors[b] = error.what();
        }
        progress.advance();
    }
    for (int b = 0; b < count; ++b) require(errors[b].empty(), "body {}: {}", b, errors[b]);
    return skins;
}

std::string sampling_table(const SkinSet& skins, const BodySamplingOptions& options)
{
    std::string table = fmt::format("{:<8}{:<16}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}\n", "sex", "", "mean", "sd", "5 %",
                                    "50 %", "95 %", "asked");
    for (const bool male : {false, true}) {
        std::vector<std::vector<double>> values(3);
        for (Eigen::Index b = 0; b < skins.parameters.rows(); ++b) {
            if ((skins.parameters(b, 0) >= 0.5) != male) continue;
            for (std::size_t k = 0; k < 3; ++k)
                values[k].push_back(skins.parameters(b, 2 + static_cast<Eigen::Index>(k)));
        }
        const std::size_t count = values[0].size();
        if (count == 0) continue;
        const AdultStatistics& statistics = adult_statistics(male);
        const char* const names[] = {"stature m", "mass kg", "BMI kg/m^2"};
        const double asked[] = {statistics.mean_stature_m,
                                statistics.mean_bmi * (statistics.mean_stature_m * statistics.mean_stature_m +
                                                       statistics.stature_deviation_m * statistics.stature_deviation_m),
                                statistics.mean_bmi};
        for (std::size_t k = 0; k < 3; ++k) {
            std::vector<double>& sorted = values[k];
            std::sort(sorted.begin(), sorted.end());
            const Eigen::Map<const Eigen::ArrayXd> all(sorted.data(), static_cast<Eigen::Index>(count));
            const double mean = all.mean();
            const double deviation =
                count > 1 ? std::sqrt((all - mean).square().sum() / static_cast<double>(count - 1)) : 0.0;
            const auto percentile = [&](double share) {
                return sorted[std::lround(share * static_cast<double>(count - 1))];
            };
            table +=
                fmt::format("{:<8}{:<16}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}{:>8.3f}\n", male ? "men" : "women",
                            names[k], mean, deviation, percentile(0.05), percentile(0.5), percentile(0.95), asked[k]);
        }
        const auto share = [&](double bmi) {
            return 100.0 *
                   static_cast<double>(
                       std::count_if(values[2].begin(), values[2].end(), [&](double value) { return value >= bmi; })) /
                   static_cast<double>(count);
        };
        table += fmt::format("{:<8}BMI >= 30: {:.1f} % (published {:.1f}), BMI >= 40: {:.1f} % (published {:.1f})\n",
                             male ? "men" : "women", share(30.0), 100.0 * statistics.published_obese, share(40.0),
                             100.0 * statistics.published_severely_obese);
    }
    return table +
           fmt::format("asked: published means, before the BMI is cut to {} to {}\n", options.min_bmi, options.max_bmi);
}

}  // namespace ndg
