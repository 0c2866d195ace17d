// SPDX-License-Identifier: Apache-2.0
// How far tibia and kneecap are from the femur as the knees bend, moved by linear blend skinning and as rigid bones.
#include "clinical_pose.h"
#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/deform/posed_body.h"
#include "ndg/geometry/closest_point.h"
#include "report.h"

using namespace ndg;

namespace {

constexpr double mm = 1000.0;

/// Least signed distances to the femur, mm: left tibia, left kneecap, right tibia, right kneecap.
using Gaps = std::array<double, 4>;

const AnatomyPart& find_part(const Template& body_template, const std::string& name)
{
    for (const AnatomyPart& part : body_template.anatomy_parts)
        if (part.name == name) return part;
    throw InputError("the template has no " + name);
}

Gaps gaps(const Template& body_template, const Points& anatomy)
{
    Gaps least;
    int k = 0;
    for (const std::string side : {"Left ", "Right "}) {
        const AnatomyPart& femur = find_part(body_template, side + "femur");
        const TriangleTree tree(anatomy, body_template.anatomy_triangles.middleRows(
                                             femur.triangle_begin, femur.triangle_end - femur.triangle_begin));
        for (const std::string bone : {"tibia", "patella"}) {
            const AnatomyPart& moving = find_part(body_template, side + bone);
            least[std::size_t(k)] = 1.0;
            for (int v = moving.vertex_begin; v < moving.vertex_end; ++v)
                least[std::size_t(k)] =
                    std::min(least[std::size_t(k)], tree.signed_distance(anatomy.row(v).transpose()));
            least[std::size_t(k++)] *= mm;
        }
    }
    return least;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-knees", "Measures gaps in bending knees, by linear blend skinning and as rigid bones.",
              "bench_knees --template out/desk/template.h5 --bodies out/desk/bodies.h5");
    std::string template_path, bodies_path, output;
    int num_bodies = 3, step = 5;
    tool.input("template", template_path, "template with bones");
    tool.input("bodies", bodies_path, "bodies to measure besides the template's own", false);
    tool.parameter("body-count", num_bodies, "of the bodies, spread evenly", 1, 100000);
    tool.parameter("step", step, "degrees of flexion from one measurement to the next", 1, 145);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        std::vector<Body> bodies = {body_template.rest};
        if (!bodies_path.empty()) {
            const std::vector<Body> all = read_bodies(bodies_path, body_template).bodies;
            const std::size_t used = std::min(std::size_t(num_bodies), all.size());
            for (std::size_t b = 0; b < used; ++b) bodies.push_back(all[b * all.size() / used]);
        }
        bench::Report report("knees");
        for (const std::string& mode : names<BoneWrap>()) {
            const BodyPoser poser(body_template, PosingOptions{parse_name<BoneWrap>(mode)});
            std::array<double, 2> farthest = {0, 0};  // of tibiae and kneecaps
            for (std::size_t b = 0; b < bodies.size(); ++b) {
                const ClinicalFrames frames(bodies[b].joint_positions);
                const Points rest = anatomy_at_rest(body_template, bodies[b]);
                const Gaps at_rest = gaps(body_template, rest);
                fmt::print("{} body {}: flexion, mm from femur to left tibia and kneecap, right tibia and kneecap\n",
                           mode, b);
                fmt::print("  rest {:7.2f} {:7.2f} {:7.2f} {:7.2f}\n", at_rest[0], at_rest[1], at_rest[2], at_rest[3]);
                for (int angle = 0; angle <= 145; angle += step) {
                    const PosedBody posed =
                        poser.pose(bodies[b], bench::clinical_pose(frames, {{"both_knee.flexion", double(angle)}}));
                    const Gaps now = gaps(body_template, posed.anatomy(rest, posed.skinned_volume()));
                    fmt::print("{:6} {:7.2f} {:7.2f} {:7.2f} {:7.2f}\n", angle, now[0], now[1], now[2], now[3]);
                    for (std::size_t k = 0; k < now.size(); ++k)
                        farthest[k % 2] = std::max(farthest[k % 2], std::abs(now[k] - at_rest[k]));
                }
            }
            report.add(mode + "_femur_tibia_off_rest_mm", farthest[0]);
            report.add(mode + "_femur_patella_off_rest_mm", farthest[1]);
        }
        report.print();
        if (!output.empty()) report.write(output);
    });
}
