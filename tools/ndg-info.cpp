// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/io/h5.h"
#include "ndg/io/mesh.h"
#include "ndg/measures/measure_report.h"
#include "ndg/template_build/template_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

using namespace ndg;

namespace {

std::string shape_text(const std::vector<std::size_t>& shape)
{
    return shape.empty() ? "scalar" : fmt::format("{}", fmt::join(shape, " x "));
}

void show_h5(const H5Listing& listing)
{
    fmt::print("attributes\n");
    for (const auto& [name, value] : listing.attributes) {
        std::string indented = value;  // licences take several lines
        for (std::size_t at = 0; (at = indented.find('\n', at)) != std::string::npos; at += 19) {
            indented.replace(at, 1, "\n" + std::string(18, ' '));
        }
        fmt::print("  {:<15} {}\n", name, indented);
    }
    std::size_t path_width = 0, shape_width = 0;
    for (const auto& dataset : listing.datasets) {
        path_width = std::max(path_width, dataset.path.size());
        shape_width = std::max(shape_width, shape_text(dataset.shape).size());
    }
    fmt::print("datasets\n");
    for (const auto& dataset : listing.datasets) {
        fmt::print("  {:<{}}  {:<7}  {:<{}}  {}\n", dataset.path, path_width, dataset.type, shape_text(dataset.shape),
                   shape_width, dataset.description);
    }
}

bool has_format(const H5Listing& listing, const std::string& format)
{
    return std::find(listing.attributes.begin(), listing.attributes.end(),
                     std::pair<std::string, std::string>("format", format)) != listing.attributes.end();
}

/// Prints the measures of bodies, and which of them are outside. Throws QualityError for those.
void show_measures(const std::string& path, const std::vector<MeasuredBody>& bodies)
{
    fmt::print("measures\n{}", measures_report(bodies));
    const std::string failures = failure_report(bodies);
    fmt::print("{}", failures.empty() ? "all bodies are inside the gates\n" : failures);
    const auto outside =
        std::count_if(bodies.begin(), bodies.end(), [](const MeasuredBody& body) { return !body.failures().empty(); });
    if (!failures.empty())
        throw QualityError(
            fmt::format("{}: {} of {} bodies miss a gate of the measures", path, outside, bodies.size()));
}

/// Prints the template check and the measures of the template body. Throws QualityError where a gate does not hold.
void show_template(const std::string& path)
{
    const Template body_template = read_template(path);
    const TemplateCheck check = check_template(body_template);
    fmt::print("template check\n{}", template_report(check));
    const auto failures = check.failures();
    if (!failures.empty()) throw QualityError(fmt::format("{}: {}", path, fmt::join(failures, "; ")));
    if (body_template.source_name.empty()) return;  // made of no person
    show_measures(path, {measure_body(body_template, body_template.rest, Person())});
}

void show_mesh(const std::string& path)
{
    const MeshFile mesh = read_mesh(path);
    const std::set<std::string> groups(mesh.triangle_groups.begin(), mesh.triangle_groups.end());
    const Eigen::RowVector3d low = mesh.vertices.colwise().minCoeff(), high = mesh.vertices.colwise().maxCoeff();
    fmt::print("vertices   {}\ntriangles  {}\ngroups     {}\n", mesh.vertices.rows(), mesh.triangles.rows(),
               groups.size());
    fmt::print("box        {:.6g} {:.6g} {:.6g} to {:.6g} {:.6g} {:.6g}\n", low[0], low[1], low[2], high[0], high[1],
               high[2]);
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool(
        "ndg-info",
        "Shows what stands in a file of this project or a mesh. A template is checked as well: elements, surfaces, "
        "anatomy, weights, volumes and masses. Of the template body, and of bodies or skins when --template is given, "
        "bones, joints and flesh are measured beside what is published of people. Exit code 3 where a gate does not "
        "hold.",
        "ndg-info bodies.h5 --template template.h5");
    std::string path, template_path;
    bool check = false;
    tool.positional_input(path, "HDF5 file or mesh (.obj, .ply, .off, .stl)");
    tool.input("template", template_path, "template of the bodies or skins, to measure them", false);
    tool.parameter("check", check, "read everything, with all checksums; exit code 2 if anything is broken");
    return tool.run(argc, argv, [&] {
        if (is_mesh_name(path)) return show_mesh(path);  // always read whole
        if (check) check_h5(path);                       // first: a broken file gives its error and nothing else
        const H5Listing listing = list_h5(path);
        show_h5(listing);
        if (check) fmt::print("check           complete and finite\n");
        if (has_format(listing, "ndg-template")) show_template(path);
        if (template_path.empty()) return;
        const bool bodies = has_format(listing, "ndg-bodies");
        require_input(bodies || has_format(listing, "ndg-skins"),
                      "{}: --template is for measures of bodies and skins, which this file does not hold", path);
        const Template body_template = read_template(template_path);
        show_measures(path, bodies ? measure_people(body_template, read_bodies(path, body_template))
                                   : measure_people(body_template, read_skins(path, body_template)));
    });
}
