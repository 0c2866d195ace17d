// SPDX-License-Identifier: Apache-2.0
#include "ndg/capture/measure_motion.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/display/field_picture.h"

#include <fmt/format.h>

#include <memory>

namespace {

using namespace ndg;

Eigen::VectorXd millimetres(const Eigen::VectorXd& variances)
{
    return 1e3 * variances.cwiseMax(0.0).cwiseSqrt();
}

/// Root of how far two variances are apart.
Eigen::VectorXd difference(const Eigen::VectorXd& a, const Eigen::VectorXd& b)
{
    return millimetres((a - b).cwiseAbs());
}

std::vector<SkinField> fields_of(const MotionMeasure& measure)
{
    if (!measure.simulated)
        return {{measure.sequence + ", normal", millimetres(measure.captured.normal)},
                {measure.sequence + ", tangential", millimetres(measure.captured.tangent)}};
    return {{"skinned, normal", millimetres(measure.captured.normal)},
            {"simulated, normal", difference(measure.captured.normal, measure.simulated->normal)},
            {"skinned, tangential", millimetres(measure.captured.tangent)},
            {"simulated, tangential", difference(measure.captured.tangent, measure.simulated->tangent)}};
}

}  // namespace

int main(int argc, char** argv)
{
    std::string avatar_path, capture_path, dynamics_path, output_path, picture_path, shown;
    double range_mm = 10;

    Tool tool("measure-motion",
              "Measures how captured skin moves beyond its skinning, and how well a simulation moves alike.",
              "measure-motion --avatar avatar.h5 --capture capture.h5 --dynamics dynamics.h5 --output motion.json "
              "--picture motion.png");
    tool.input("avatar", avatar_path, "avatar of the captured person");
    tool.input("capture", capture_path, "capture with poses (import-capture, simulate-capture)");
    tool.input("dynamics", dynamics_path, "the avatar simulated in the capture's motions at its frame rate", false);
    tool.output("output", output_path, "all measures and the liveliest trajectories, JSON");
    tool.output("picture", picture_path,
                "PNG: the captured motion on the skin, or what is missing of it without and with simulation", false);
    tool.parameter("sequence", shown, "the one in the picture; the first without it");
    tool.parameter("range", range_mm, "mm of motion shown in full red", 1e-3, 1e3);

    return tool.run(argc, argv, [&] {
        const Avatar avatar = read_avatar(avatar_path);
        const Capture capture = read_capture(capture_path);
        std::unique_ptr<DynamicsReader> dynamics;
        if (!dynamics_path.empty()) dynamics = std::make_unique<DynamicsReader>(dynamics_path);
        if (!shown.empty()) capture.sequence(shown);
        const MeasuredSkin skin(avatar);
        const std::vector<MotionMeasure> measures = measure_motion(avatar, skin, capture, dynamics.get());
        write_file(output_path, motion_measures_json(capture.subject, measures));
        fmt::print("{}", motion_measures_table(measures));
        if (picture_path.empty()) return;
        for (const MotionMeasure& measure : measures) {
            if (!shown.empty() && measure.sequence != shown) continue;
            const std::string footer =
                fmt::format("{}: root of the {}, white none, red {:g} mm or more", measure.sequence,
                            measure.simulated ? "error of the motion variance" : "motion variance", range_mm);
            write_png(picture_path, skin_field_picture(avatar.skin_vertices, avatar.whole_skin_triangles,
                                                       skin.skin_vertices, fields_of(measure), range_mm, footer));
            break;
        }
    });
}
