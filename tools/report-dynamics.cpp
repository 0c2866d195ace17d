// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/avatar.h"
#include "ndg/core/tool.h"
#include "ndg/display/dynamics_report.h"

#include <fmt/core.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool(
        "report-dynamics",
        "Puts results of simulate-dynamics together as a page: pictures, distances from the skinned shape, what is "
        "inside of what.",
        "report-dynamics --avatar avatar.h5 --figures configs/dynamics-figures.json --runs runs --output "
        "report/index.html");
    std::string avatar_path, figures_path, runs_path, output;
    int picture_height = 700;
    tool.input("avatar", avatar_path, "avatar of soft tissue that all runs moved");
    tool.input("figures", figures_path, "JSON: the figures and the runs that each shows");
    tool.input("runs", runs_path, "folder with the runs, <name>.h5, and the commands that made them, <name>.txt");
    tool.output("output", output, "HTML file; its pictures are written beside it too");
    tool.parameter("picture-height", picture_height, "pixels of one body", 50, 4000);
    return tool.run(argc, argv, [&] {
        const std::vector<DynamicsFigure> figures = read_dynamics_figures(figures_path, runs_path);
        write_dynamics_report(output, figures, read_avatar(avatar_path), picture_height);
        fmt::print("{}: {} figures\n", output, figures.size());
    });
}
