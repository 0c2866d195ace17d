// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/io/mesh.h"
#include "ndg/registration/batch_report.h"
#include "ndg/scene/fit_picture.h"

#include <fmt/format.h>

#include <filesystem>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("picture-fit", "Shows a scan and the skin fitted to it, with their distance in colours.",
              "picture-fit --report fits.json --surfaces surfaces --picture worst.png");
    std::string report_path, surfaces, picture, name;
    double range = 0.005;
    int height = 700;
    tool.input("report", report_path, "report of fit-body");
    tool.input("surfaces", surfaces, "folder of the fitted skins, fit-body --surfaces");
    tool.output("picture", picture, "PNG file to write");
    tool.parameter("name", name, "name of the body; empty: the worst");
    tool.parameter("range", range, "distance shown in full colour, m", 1e-4, 0.1);
    tool.parameter("height", height, "pixels of one body", 100, 4000);
    return tool.run(argc, argv, [&] {
        const ReportedFit reported = read_reported_fit(report_path, name);
        ScanOptions options;
        options.unit = reported.unit;
        options.up = reported.up;
        const ScanPoints scan = read_scan(reported.file, options);
        const MeshFile surface = read_mesh((std::filesystem::path(surfaces) / (reported.name + ".ply")).string());
        const Eigen::Matrix3d upright = rotation_to_y_up(reported.up);
        FitPicture fit;
        fit.points = scan.points * upright.transpose();
        fit.normals = scan.normals * upright.transpose();
        fit.spacing = scan.spacing;
        fit.surface = surface.vertices;
        fit.triangles = surface.triangles;
        fit.heading = reported.heading_degrees * EIGEN_PI / 180.0;
        fit.title = reported.name;
        fit.footer = fmt::format("blue: scan inside, red: outside, full colour at {:.1f} mm", 1e3 * range);
        write_png(picture, fit_picture(fit, range, height));
        fmt::print("{}: {}\n", picture, reported.name);
    });
}
