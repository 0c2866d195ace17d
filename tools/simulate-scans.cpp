// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/io/mesh.h"
#include "ndg/scan/people.h"
#include "ndg/scan/scan_simulation.h"
#include "ndg/scan/scan_truth.h"

#include <fmt/format.h>

#include <filesystem>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("simulate-scans",
              "Scans skins as a body scanner would: other triangulation, noise, holes, another pose and place; keeps "
              "the truth.",
              "simulate-scans --template template.h5 --skins skins.h5 --scans scans --output truth.h5");
    std::string template_path, skins_path, folder, output, people;
    LengthUnit unit = LengthUnit::metre;
    Axis up = Axis::y;
    ScanSimulationOptions options;
    int first = 0, count = 0;
    tool.input("template", template_path, "template file");
    tool.input("skins", skins_path, "skins in the template's tessellation");
    tool.parameter("scans", folder, "folder for the scans, NAME.ply each; made if need be");
    tool.output("output", output, "file for the true posed skins and joints");
    tool.output("people", people, "JSON file for sex and age of the bodies, as fit-body reads it", false);
    tool.options(options);
    tool.parameter("unit", unit, "unit of the scan files");
    tool.parameter("up", up, "axis of the scan files that points up");
    tool.parameter("first", first, "first body to scan", 0, 1000000);
    tool.parameter("count", count, "number of bodies to scan; 0: all from the first on", 0, 1000000);
    return tool.run(argc, argv, [&] {
        require_input(!folder.empty(), "--scans is missing");
        const Template body_template = read_template(template_path);
        const SkinSet skins = read_skins(skins_path, body_template);
        const int total = static_cast<int>(skins.bodies.size());
        require_input(first < total, "{}: --first {}, but there are {} bodies", skins_path, first, total);
        const int end = count > 0 ? std::min(total, first + count) : total;
        std::filesystem::create_directories(folder);
        const Eigen::Matrix3d file_from_world = rotation_to_y_up(up).transpose() / metres_of_unit(unit);
        ScanTruth truth;
        std::size_t points = 0;
        for (int b = first; b < end; ++b) {
            const Skin& body = skins.bodies[b];
            SimulatedScan simulated = simulate_scan(
                {body.skin_vertices, body_template.skin_triangles, body_template.skin_weights, body.joint_positions},
                options, tool.seed(), b);
            const Points vertices = simulated.scan.vertices * file_from_world.transpose();
            write_mesh((std::filesystem::path(folder) / (body.name + ".ply")).string(), vertices,
                       simulated.scan.triangles);
            points += static_cast<std::size_t>(vertices.rows());
            truth.bodies.push_back({body.name, std::move(simulated.posed_skin), std::move(simulated.posed_joints),
                                    simulated.person.vertices, simulated.person.joint_positions});
        }
        if (!people.empty()) write_people(people, skins, skins_path);
        write_scan_truth(output, truth, tool.provenance());
        fmt::print("scans: {} of {} points in the mean\n", truth.bodies.size(), points / truth.bodies.size());
    });
}
