// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/make_avatar.h"
#include "ndg/core/error.h"
#include "ndg/core/json_file.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/scene/layer_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

using namespace ndg;

namespace {

std::vector<std::string> comma_list(const std::string& text)
{
    std::vector<std::string> items;
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        items.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    return items;
}

Eigen::VectorXd shape_of(const StatisticalBody& body, const std::string& person, const std::string& numbers)
{
    require_input(person.empty() || numbers.empty(), "--person and --shape both say what the shape is");
    if (!person.empty()) return body.people_shapes.row(body.person(person)).transpose();
    const std::vector<std::string> items = comma_list(numbers);
    Eigen::VectorXd shape(Eigen::Index(items.size()));
    for (std::size_t i = 0; i < items.size(); ++i) {
        char* end = nullptr;
        shape[Eigen::Index(i)] = std::strtod(items[i].c_str(), &end);
        require_input(!items[i].empty() && *end == '\0' && std::isfinite(shape[Eigen::Index(i)]),
                      "--shape {}: \"{}\" is no number", numbers, items[i]);
    }
    return shape;
}

void print_report(const Avatar& avatar, const AvatarReport& report)
{
    fmt::print("  volume: {} vertices ({} held), {} tetrahedra, {:.2f} l\n", avatar.num_vertices(), avatar.num_held,
               avatar.tetrahedra.rows(), 1e3 * report.quality.total_volume);
    fmt::print(
        "  thickness: {:.1f} mm on average, bounds allow {:.1f} mm; {} of {} vertices have bone nearer than the "
        "least thickness\n",
        1e3 * report.mean_thickness, 1e3 * report.mean_max_thickness, report.num_thin, avatar.skin_of_inner.size());
    fmt::print(
        "  projections: neighbours lie at most {:.1f} times as far apart as on the skin; {} directions turned "
        "towards the normal\n",
        report.largest_stretch, report.num_turned);
    fmt::print("  lowered where the inner surface would fold: {} bounds, {} thicknesses\n", report.num_lowered,
               report.num_unfolded);
    fmt::print(
        "  tetrahedra: dihedral angles {:.1f} to {:.1f} degrees, radius ratio {:.3f} on average, {:.4f} at least, "
        "least volume {:.2g} mm^3\n",
        report.quality.least_dihedral * 180 / EIGEN_PI, report.quality.greatest_dihedral * 180 / EIGEN_PI,
        report.quality.mean_radius_ratio, report.quality.least_radius_ratio, 1e9 * report.quality.least_volume);
}

/// Belly, hip, thigh and upper arm of a body that stands upright: by share of its height.
std::vector<double> section_heights(const Avatar& avatar)
{
    const double low = avatar.skin_vertices.col(1).minCoeff(), high = avatar.skin_vertices.col(1).maxCoeff();
    std::vector<double> heights;
    for (const double share : {0.72, 0.61, 0.53, 0.42}) heights.push_back(low + share * (high - low));
    return heights;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "make-avatar",
        "Makes a soft-tissue avatar of a statistical body: tetrahedra between skin and bones that skinning moves.",
        "make-avatar --body statistical_body.h5 --person body_0003 --thickness 0.04 --output avatar.h5");
    std::string body_path, person, shape_text, extremities, thickness_path, picture_path, output_path;
    AvatarOptions options;
    int picture_height = 900;
    tool.input("body", body_path, "statistical body");
    tool.input("thickness-field", thickness_path,
               "JSON file with {\"thickness\": [m, ...]}, a number for each control point, instead of --thickness",
               false);
    tool.output("output", output_path, "avatar to write");
    tool.output("picture", picture_path, "PNG file of sections with every tetrahedron", false);
    tool.parameter("person", person, "one of the people of the statistical body; without, --shape or the mean");
    tool.parameter("shape", shape_text, "shape parameters, separated by commas; those left out are 0");
    tool.parameter("extremities", extremities,
                   "joints that, with all below them, have no soft tissue: \"head,left_hand,...\"; without, as the "
                   "statistical body says");
    tool.parameter("picture-height", picture_height, "pixels of one body", 100, 4000);
    tool.options(options);
    return tool.run(argc, argv, [&] {
        StatisticalBody body = read_statistical_body(body_path);
        if (!extremities.empty()) {
            std::vector<int> joints;
            for (const std::string& name : comma_list(extremities)) {
                const auto& names = body.skeleton.joint_names;
                require_input(std::count(names.begin(), names.end(), name) > 0,
                              "--extremities: the statistical body has no joint \"{}\"", name);
                joints.push_back(body.skeleton.joint(name));
            }
            body.soft_triangles =
                soft_triangles_without(body.triangles, RowMatrix(body.weights), body.skeleton.parents, joints);
        }
        std::vector<double> control_values;
        if (!thickness_path.empty()) {
            const JsonValue file(thickness_path);
            file.check_keys({"thickness"});
            control_values = file.at("thickness").numbers(options.control_points);
        }
        AvatarReport report;
        Avatar avatar = make_avatar(body, shape_of(body, person, shape_text), options, control_values, report);
        avatar.name = person.empty() ? body.name : person;
        write_avatar(output_path, avatar, tool.provenance());
        fmt::print("{}: {}\n", output_path, avatar.name);
        print_report(avatar, report);
        if (picture_path.empty()) return;
        LayerPicture layer;
        layer.skin = {avatar.skin_vertices, avatar.whole_skin_triangles};
        layer.vertices = avatar.rest;
        layer.tetrahedra = avatar.tetrahedra;
        layer.joints = avatar.joint_positions;
        layer.parents = avatar.skeleton.parents;
        layer.title = fmt::format("{}: soft tissue, {:.0f} mm on average", avatar.name, 1e3 * report.mean_thickness);
        write_png(picture_path, layer_picture(layer, section_heights(avatar), picture_height));
        fmt::print("{}\n", picture_path);
    });
}
