// SPDX-License-Identifier: Apache-2.0
// HDF5 files of the project: what each format holds, in words.
#include "ndg/core/error.h"
#include "ndg/dataset/sample_index.h"
#include "ndg/info/describers.h"
#include "ndg/io/h5.h"
#include "ndg/io/schema.h"
#include "ndg/measures/measure_report.h"
#include "ndg/runtime/model_traits.h"
#include "ndg/template_build/template_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

namespace ndg {
namespace {

using Attributes = std::map<std::string, std::string>;

std::string shape_text(const std::vector<std::size_t>& shape)
{
    return shape.empty() ? "scalar" : fmt::format("{}", fmt::join(shape, " x "));
}

/// Points of slice `index` along the first axis of an n x N x 3 dataset.
Points slice_points(const H5Reader& reader, const std::string& name, std::size_t index)
{
    const std::vector<float> values = reader.read_slice(name, index);
    return Eigen::Map<const RowMatrixF>(values.data(), static_cast<Eigen::Index>(values.size() / 3), 3).cast<double>();
}

/// "body_0000 to body_0039".
std::string first_to_last(const std::vector<std::string>& names)
{
    return names.empty() ? "" : names.size() == 1 ? names.front() : names.front() + " to " + names.back();
}

/// Heights of surfaces n x N x 3 that stand upright.
void add_statures(const H5Reader& reader, const std::string& skins, FileReport& report)
{
    double least = std::numeric_limits<double>::max(), greatest = 0;
    const std::size_t count = reader.shape(skins)[0];
    for (std::size_t i = 0; i < count; ++i) {
        const Points skin = slice_points(reader, skins, i);
        const double height = skin.col(1).maxCoeff() - skin.col(1).minCoeff();
        least = std::min(least, height);
        greatest = std::max(greatest, height);
    }
    if (count > 0) report.add("stature", "{:.3f} to {:.3f} m, skin alone", least, greatest);
}

void add_template(const H5Reader& reader, FileReport& report)
{
    const auto rows = [&](const char* name) { return reader.shape(name)[0]; };
    report.add("body", "{} of the source {}", reader.attribute("body_name"), reader.attribute("source_name"));
    report.add("skin", "{} vertices, {} triangles", rows("/skin/vertices"), rows("/skin/triangles"));
    report.add("volume",
               "{} vertices (three wraps), {} prisms (muscle layer, fat layer); {} tetrahedra inside the bones",
               rows("/volume/vertices"), rows("/volume/prisms"), rows("/bone_interior/tetrahedra"));
    const std::vector<std::string> layers = reader.read_strings("/anatomy/part_layers");
    report.add("anatomy", "{} bones, {} muscles, {} vertices", std::count(layers.begin(), layers.end(), "bone"),
               std::count(layers.begin(), layers.end(), "muscle"), rows("/anatomy/vertices"));
    report.add("joints", "{}", rows("/skeleton/joint_names"));
    const Points skin = reader.read_matrix("/skin/vertices", -1, 3);
    report.add("stature", "{:.3f} m", skin.col(1).maxCoeff() - skin.col(1).minCoeff());
    add_box(skin, " m", report);
}

void add_people(const H5Reader& reader, FileReport& report)
{
    const std::vector<std::string> names = reader.read_strings("/bodies/names");
    report.add("bodies", "{}: {}", names.size(), first_to_last(names));
    const bool layered = reader.has("/bodies/volume_vertices");
    report.add("vertices", "{} of the skin{}", reader.shape("/bodies/skin_vertices")[1],
               layered ? fmt::format(", {} of the volume", reader.shape("/bodies/volume_vertices")[1]) : "");
    add_statures(reader, "/bodies/skin_vertices", report);
    const std::vector<std::string> parameters = reader.read_strings("/bodies/parameter_names");
    const RowMatrix values = reader.read_matrix("/bodies/parameters");
    for (const char* name : {"age_years", "mass_kg", "bmi"}) {
        const auto found = std::find(parameters.begin(), parameters.end(), name);
        if (found == parameters.end() || values.rows() == 0) continue;
        const auto column = values.col(found - parameters.begin());
        report.add(name, "{:.4g} to {:.4g}", column.minCoeff(), column.maxCoeff());
    }
}

void add_scan_truth(const H5Reader& reader, FileReport& report)
{
    report.add("people", "{}", reader.shape("/bodies/names")[0]);
    add_statures(reader, "/bodies/rest_skin", report);
}

void add_poses(const H5Reader& reader, FileReport& report)
{
    const std::vector<std::string> clips = reader.read_strings("/clips/names");
    const std::vector<double> rates = reader.read_doubles("/clips/frame_rates");
    const auto [slowest, fastest] = std::minmax_element(rates.begin(), rates.end());
    report.add("poses", "{} of {} clips{}", reader.shape("/poses/rotations")[0], clips.size(),
               rates.empty() ? "" : fmt::format(" at {:.4g} to {:.4g} Hz", *slowest, *fastest));
    report.add("clips", first_to_last(clips));
    report.add("joints", "{}", reader.shape("/skeleton/joint_names")[0]);
    if (!reader.has("/poses/spliced_from")) return;
    const RowMatrixI from =
        reader.read_int_matrix("/poses/spliced_from", static_cast<Eigen::Index>(reader.shape("/poses/spliced_from")[0]),
                               6, -1, std::numeric_limits<int>::max());
    report.add("spliced", "{} are put together of three others", (from.col(0).array() >= 0).count());
}

void add_splits(const H5Reader& reader, FileReport& report)
{
    for (const std::string& split : split_names) {
        const std::string group = "/splits/" + split;
        if (!reader.has(group + "/pairs")) continue;
        report.add(split, "{} samples of {} bodies and {} poses", reader.shape(group + "/pairs")[0],
                   reader.shape(group + "/bodies")[0], reader.shape(group + "/poses")[0]);
    }
}

/// What begins all files of samples; `payload`: with a slice a frame.
void add_samples(const H5Reader& reader, const std::string& group, const std::string& payload, FileReport& report)
{
    const SampleIndex index = read_sample_index(reader, group);
    std::vector<std::string> counts;
    for (const std::string& split : split_names) {
        const auto count = std::count(index.pair_splits.begin(), index.pair_splits.end(), split);
        if (count > 0) counts.push_back(fmt::format("{} {}", count, split));
    }
    std::set<int> bodies;
    for (const SamplePair& pair : index.pairs) bodies.insert(pair.body_idx);
    report.add("method", "{}, bone wrap {}", index.method, to_name(index.posing.bone_wrap));
    report.add("samples", "{} ({}) of {} bodies, {} frames", index.size(), fmt::join(counts, ", "), bodies.size(),
               reader.shape(payload)[0]);
}

void add_deformations(const H5Reader& reader, FileReport& report)
{
    add_samples(reader, "/deformations", "/deformations/vertices", report);
    if (reader.has("/statistics/converged")) {
        const std::vector<double> converged = reader.read_doubles("/statistics/converged");
        report.add("converged", "{} of {}", std::count(converged.begin(), converged.end(), 1.0), converged.size());
    }
    if (reader.has("/failures/pairs")) report.add("failed", "{}", reader.shape("/failures/pairs")[0]);
    if (reader.shape("/deformations/vertices")[0] > 0)
        add_box(slice_points(reader, "/deformations/vertices", 0), " m, of the first frame", report);
}

void add_gradients(const H5Reader& reader, FileReport& report)
{
    add_samples(reader, "/gradients", "/gradients/F", report);
    report.add("prisms", "{}", reader.shape("/gradients/F")[1]);
}

void add_anatomy(const H5Reader& reader, FileReport& report)
{
    add_samples(reader, "/anatomy", "/anatomy/vertices", report);
    if (reader.shape("/anatomy/vertices")[0] > 0)
        add_box(slice_points(reader, "/anatomy/vertices", 0), " m, of the first frame", report);
}

void add_shape_space(const H5Reader& reader, FileReport& report)
{
    const std::vector<double> errors = reader.read_doubles("/shape_space/reconstruction_errors");
    report.add("components", "{} of {} bodies, {:.4f} % of the variance",
               reader.shape("/shape_space/standard_deviations")[0], errors.size(),
               100 * reader.attribute_double("explained_variance"));
    if (!errors.empty())
        report.add("error", "of a body at most {:.3f} mm", 1e3 * *std::max_element(errors.begin(), errors.end()));
}

void add_model(const H5Reader& reader, FileReport& report)
{
    const ModelTraits traits = read_model_traits(reader);
    report.add("predicts", "{}{}, bone wrap {}", traits.output_space,
               traits.output_space == "residuals"
                   ? fmt::format(" ({}, {})", to_name(traits.parametrisation),
                                 traits.rotation ? "in the frame of each prism's rotation" : "in the root's frame")
                   : "",
               to_name(traits.posing.bone_wrap));
    const std::vector<int> visible = reader.read_ints("/input/visible_joints", -1, 0, 1);
    report.add("sees", "rotations of {} joints, {} of which move flesh{}", visible.size(),
               std::count(visible.begin(), visible.end(), 1),
               traits.shape
                   ? fmt::format(", {} numbers of the body", reader.shape("/shape_space/standard_deviations")[0])
                   : "");
    report.add("network", "hidden layers {}{}", reader.attribute("widths"),
               reader.has_attribute("region_reach") ? ", one network a region of the body" : "");
    const auto epoch = static_cast<int>(reader.attribute_double("best_epoch"));
    if (epoch == 0 || !reader.has("/training/epoch")) return report.add("training", "none yet");
    const std::vector<double> losses = reader.read_doubles("/training/validation_loss");
    require_input(epoch <= int(losses.size()), "{}: attribute best_epoch is {}, of {} epochs", reader.path(), epoch,
                  losses.size());
    report.add("training", "epoch {} of {}, validation loss {:.4g} ({:.4g} without a network)", epoch, losses.size(),
               losses[epoch - 1], reader.attribute_double("initial_validation_loss"));
}

void add_correctives(const H5Reader& reader, FileReport& report)
{
    report.add("joints", "{}", reader.shape("/correctives/joint_names")[0]);
    report.add("blend shapes", "{}, of {} coordinates", reader.shape("/correctives/blend_shapes")[0],
               reader.shape("/correctives/blend_shapes")[1]);
}

void add_dynamics(const H5Reader& reader, FileReport& report)
{
    const std::vector<std::string> names = reader.read_strings("/sequences/names");
    const std::vector<std::size_t> shape = reader.shape("/frames/vertices");
    report.add("model", "{}, {} vertices, {} of them held", reader.attribute("model"), shape[1],
               reader.read_ints("/mesh/held_count", 1, 0, static_cast<int>(shape[1]))[0]);
    report.add("motions", "{}, {} frames at {:g} Hz, steps of {:.4g} ms", names.size(), shape[0],
               reader.attribute_double("frame_rate"), 1e3 * reader.attribute_double("time_step"));
    const std::vector<double> converged = reader.read_doubles("/statistics/converged");
    report.add("converged", "{} frames, when {}", std::count(converged.begin(), converged.end(), 1.0),
               reader.attribute("convergence_criterion"));
    if (reader.has("/failures/sequences"))
        report.add("failed", "{}", fmt::join(reader.read_strings("/failures/sequences"), ", "));
}

void add_capture(const H5Reader& reader, FileReport& report)
{
    const std::vector<std::size_t> shape = reader.shape("/frames/vertices");
    report.add("subject", "{}{}", reader.attribute("subject"),
               reader.has("/truth/stiffness") ? ", a twin whose stiffness is known" : "");
    report.add("surface", "{} vertices, {} triangles", shape[1], reader.shape("/skin/triangles")[0]);
    const std::vector<std::string> names = reader.read_strings("/sequences/names");
    const std::vector<double> rates = reader.read_doubles("/sequences/frame_rates");
    report.add("motions", "{} of {} frames at {:g} Hz: {}", names.size(), shape[0],
               rates.empty() ? 0.0 : *std::max_element(rates.begin(), rates.end()), fmt::join(names, ", "));
    report.add("poses", "{}", reader.has("/poses/rotations") ? "one a frame" : "none");
}

void add_statistical_body(const H5Reader& reader, FileReport& report)
{
    const auto rows = [&](const char* name) { return reader.has(name) ? reader.shape(name)[0] : 0; };
    report.add("body", "{}", reader.attribute("name"));
    report.add("skin", "{} vertices, {} triangles{}", rows("/skin/vertices"), rows("/skin/triangles"),
               reader.has("/skin/soft_triangles") ? "" : "; it does not say where soft tissue is");
    report.add("joints", "{}", rows("/skeleton/joint_names"));
    report.add("shape", "{} directions, shapes of {} people", rows("/shape/directions"), rows("/people/names"));
    report.add("pose", "{} directions, of {} joints", rows("/pose/directions"), rows("/pose/joint_names"));
    add_box(reader.read_matrix("/skin/vertices", -1, 3), " m", report);
}

void add_avatar(const H5Reader& reader, FileReport& report)
{
    const auto rows = [&](const char* name) { return reader.has(name) ? reader.shape(name)[0] : 0; };
    report.add("person", "{}", reader.attribute("name"));
    report.add("volume", "{} vertices, {} of them held, {} tetrahedra", rows("/volume/vertices"),
               reader.read_ints("/volume/num_held", 1, 0, std::numeric_limits<int>::max()).front(),
               rows("/volume/tetrahedra"));
    const std::vector<double> thickness = reader.read_doubles("/layer/thickness");
    if (!thickness.empty()) {
        const auto [least, greatest] = std::minmax_element(thickness.begin(), thickness.end());
        report.add("soft tissue", "{:.1f} to {:.1f} mm below {} skin vertices", 1e3 * *least, 1e3 * *greatest,
                   thickness.size());
    }
    report.add("control points", "{}", rows("/control/vertices"));
    report.add("skin", "{} vertices, {} triangles", rows("/skin/vertices"), rows("/skin/triangles"));
    report.add("joints", "{}, pose directions of {}", rows("/skeleton/joint_names"), rows("/pose/joint_names"));
    add_box(reader.read_matrix("/skin/vertices", -1, 3), " m", report);
}

void add_part(const H5Reader& reader, FileReport& report)
{
    const std::string failure = reader.attribute("failure");
    report.add("result", failure.empty() ? "there is one" : "none: " + failure);
}

/// A format: what its files are, and what there is to say of one.
struct Format {
    const char* name;
    const char* what;
    void (*add)(const H5Reader& reader, FileReport& report);
};

const Format formats[] = {
    {"ndg-template", "a template: what all bodies share, and the template body at rest", add_template},
    {"ndg-skins", "people of whom skin and joints are known, in a template's numbering", add_people},
    {"ndg-bodies", "layered bodies at rest, in a template's numbering", add_people},
    {"ndg-scan-truth", "the people of simulated scans", add_scan_truth},
    {"ndg-poses", "poses on our skeleton", add_poses},
    {"ndg-splits", "training, validation and test sets", add_splits},
    {"ndg-deformations", "deformed volumes", add_deformations},
    {"ndg-gradients", "deformation gradients of every prism", add_gradients},
    {"ndg-anatomy", "bones and muscles of posed bodies", add_anatomy},
    {"ndg-shape-space", "principal components of bodies at rest", add_shape_space},
    {"ndg-model", "a trained network", add_model},
    {"ndg-correctives", "blend shapes linear in the pose", add_correctives},
    {"ndg-dynamics", "bodies in motion with inertia", add_dynamics},
    {"ndg-capture", "a person's surface in motion, frame by frame", add_capture},
    {"ndg-dynamics-part", "finished frames of simulate-dynamics under way", add_part},
    {"ndg-statistical-body", "a statistical body: skins linear in shape and pose", add_statistical_body},
    {"ndg-avatar", "one person's soft tissue as tetrahedra, and what poses it", add_avatar},
    {"ndg-fem-part", "a finished sample of a simulation under way", add_part},
    {"ndg-body-part", "a finished body of build-layers under way", add_part},
    {"ndg-fit-part", "a finished scan of fit-body under way", add_part},
};

void add_datasets(const H5Listing& listing, const Attributes& attributes, FileReport& report)
{
    std::string text = "attributes\n";
    for (const auto& [name, value] : attributes) text += fmt::format("  {:<15} {}\n", name, value);
    std::size_t path_width = 0, shape_width = 0;
    for (const auto& dataset : listing.datasets) {
        path_width = std::max(path_width, dataset.path.size());
        shape_width = std::max(shape_width, shape_text(dataset.shape).size());
    }
    text += "datasets\n";
    for (const auto& dataset : listing.datasets) {
        text += fmt::format("  {:<{}}  {:<7}  {:<{}}  {}\n", dataset.path, path_width, dataset.type,
                            shape_text(dataset.shape), shape_width, dataset.description);
    }
    report.add_block(text);
}

/// The measures of bodies, and which of them are outside.
void add_measures(const FileQuestion& file, const std::vector<MeasuredBody>& bodies, FileReport& report)
{
    const std::string failures = failure_report(bodies);
    report.add_block(fmt::format("measures\n{}{}", measures_report(bodies),
                                 failures.empty() ? "all bodies are inside the gates\n" : failures));
    const auto outside =
        std::count_if(bodies.begin(), bodies.end(), [](const MeasuredBody& body) { return !body.failures().empty(); });
    if (!failures.empty())
        report.add_failure(
            fmt::format("{}: {} of {} bodies miss a gate of the measures", file.path, outside, bodies.size()));
}

/// The check of a template and the measures of its body.
void add_template_check(const FileQuestion& file, FileReport& report)
{
    const Template body_template = read_template(file.path);
    const TemplateCheck check = check_template(body_template);
    report.add_block("template check\n" + template_report(check));
    const auto failures = check.failures();
    if (!failures.empty()) return report.add_failure(fmt::format("{}: {}", file.path, fmt::join(failures, "; ")));
    if (body_template.source_name.empty()) return;  // made of no person
    add_measures(file, {measure_body(body_template, body_template.rest, Person())}, report);
}

}  // namespace

void describe_h5(const FileQuestion& file, FileReport& report)
{
    if (file.check) check_h5(file.path);
    const H5Listing listing = list_h5(file.path);
    Attributes attributes(listing.attributes.begin(), listing.attributes.end());
    const std::string name = attributes["format"], version = attributes["format_version"];
    const auto format =
        std::find_if(std::begin(formats), std::end(formats), [&](const Format& f) { return name == f.name; });
    const bool known = format != std::end(formats);
    report.add("what", "{} ({}, version {})",
               known          ? format->what
               : name.empty() ? "an HDF5 file of another program"
                              : "an HDF5 file of a format that is not known here",
               name.empty() ? "HDF5" : name, version.empty() ? "none" : version);
    if (!name.empty())
        report.add("conventions", "{}, {} up; the body faces +z, its left side is +x", attributes["units"],
                   attributes["up_axis"]);
    if (known) {
        const auto schema =
            std::find_if(schemas().begin(), schemas().end(), [&](const Schema& s) { return name == s.format; });
        const H5Reader reader(file.path, name, schema->version);  // refuses another version
        check_h5_schema(file.path);
        format->add(reader, report);
    }
    if (attributes.count("created_by") > 0)
        add_provenance(file, attributes["created_by"], attributes["config"], attributes["inputs"],
                       attributes["licences"], report);
    for (const SchemaItem& common : common_attributes()) attributes.erase(common.name.substr(1));
    if (file.check) report.add("check", "complete and finite");
    add_datasets(listing, attributes, report);
    if (name == "ndg-template") add_template_check(file, report);
    if (file.template_path.empty()) return;
    const bool bodies = name == "ndg-bodies";
    require_input(bodies || name == "ndg-skins",
                  "{}: --template is for measures of bodies and skins, which this file does not hold", file.path);
    const Template body_template = read_template(file.template_path);
    add_measures(file,
                 bodies ? measure_people(body_template, read_bodies(file.path, body_template))
                        : measure_people(body_template, read_skins(file.path, body_template)),
                 report);
}

}  // namespace ndg
