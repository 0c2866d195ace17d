// SPDX-License-Identifier: Apache-2.0
#include "ndg/template_build/template_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

namespace ndg {
namespace {

constexpr std::size_t shown_parts = 5;

/// "name 1.2 mm, name 0.8 mm and 3 more".
std::string parts_text(const std::vector<PartDistance>& parts)
{
    std::string text;
    for (std::size_t i = 0; i < std::min(parts.size(), shown_parts); ++i)
        text += fmt::format("{}{} {:.3g} mm", i == 0 ? "" : ", ", parts[i].part, 1e3 * parts[i].distance);
    if (parts.size() > shown_parts) text += fmt::format(" and {} more", parts.size() - shown_parts);
    return text;
}

std::string names_text(const std::vector<std::string>& names)
{
    std::string text = fmt::format(
        "{}", fmt::join(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), shown_parts)),
                        ", "));
    if (names.size() > shown_parts) text += fmt::format(" and {} more", names.size() - shown_parts);
    return text;
}

std::string containment_text(const Containment& containment)
{
    if (containment.num_vertices == 0) return "no vertices";
    std::string text = fmt::format("{:.3f} % of {} vertices", 100.0 * containment.share(), containment.num_vertices);
    if (containment.num_outside > 0)
        text += fmt::format(", {} outside: {}", containment.num_outside, parts_text(containment.worst));
    return text;
}

}  // namespace

int TemplateCheck::num_intersections() const
{
    return skin_self + muscle_self + bone_self + skin_muscle + muscle_bone + skin_bone;
}

std::vector<std::string> TemplateCheck::failures() const
{
    std::vector<std::string> failures;
    const auto gate = [&](bool holds, const std::string& sentence) {
        if (!holds) failures.push_back(sentence);
    };
    gate(skin_defect.empty(), "the skin is " + skin_defect);
    gate(wrap_defect.empty(), "a closed wrap is faulty: " + wrap_defect);
    const int invalid = muscle_jacobians.num_invalid + fat_jacobians.num_invalid;
    gate(invalid == 0, fmt::format("{} prisms are invalid", invalid));
    const double least = std::min(muscle_jacobians.min_scaled, fat_jacobians.min_scaled);
    gate(least > gates.min_scaled_jacobian, fmt::format("the smallest scaled Jacobian is {:.4f}, which is not above {}",
                                                        least, gates.min_scaled_jacobian));
    gate(num_flat_tetrahedra == 0, fmt::format("{} tetrahedra are flat or inverted", num_flat_tetrahedra));
    gate(num_intersections() == 0,
         fmt::format("{} pairs of triangles of skin and wraps intersect", num_intersections()));
    gate(bones_inside.share() >= gates.containment,
         fmt::format("only {:.3f} % of the bones' vertices lie inside the bone wrap", 100.0 * bones_inside.share()));
    gate(muscles_inside.share() >= gates.containment,
         fmt::format("only {:.3f} % of the muscles' vertices lie inside the muscle wrap",
                     100.0 * muscles_inside.share()));
    gate(coverage.num_far == 0, fmt::format("{} anatomy vertices lie more than {} mm from every element",
                                            coverage.num_far, 1e3 * gates.embedding_limit));
    return failures;
}

std::string template_report(const TemplateCheck& check)
{
    std::string text;
    const auto out = std::back_inserter(text);
    const auto line = [&](const char* item, const std::string& value) {
        fmt::format_to(out, "{:<20}{}\n", item, value);
    };
    line("skin", fmt::format("{} vertices, {} triangles, {}", check.skin_vertices, check.skin_triangles,
                             check.skin_defect.empty() ? "closed" : check.skin_defect));
    line("wraps", fmt::format("{} vertices, {} triangles each, borders of {} vertices{}", check.wrap_vertices,
                              check.wrap_triangles, fmt::join(check.border_vertices, ", "),
                              check.wrap_defect.empty() ? "" : "; " + check.wrap_defect));
    line("elements", fmt::format("{} prisms, {} tetrahedra ({} flat or inverted), {} interior vertices", check.prisms,
                                 check.tetrahedra, check.num_flat_tetrahedra, check.interior_vertices));
    line("anatomy", fmt::format("{} bones, {} muscles, {} vertices; {} landmarks", check.bones, check.muscles,
                                check.anatomy_vertices, check.landmarks));
    for (const auto& [name, layer] :
         {std::pair{"muscle layer", &check.muscle_jacobians}, std::pair{"fat layer", &check.fat_jacobians}}) {
        line(name,
             fmt::format("{} invalid prisms, smallest scaled Jacobian {:.4f}", layer->num_invalid, layer->min_scaled));
        line("", fmt::format("by tenths {}", fmt::join(layer->histogram, " ")));
    }
    line("intersections", fmt::format("{} (skin {}, muscle wrap {}, bone wrap {}, skin-muscle {}, muscle-bone {}, "
                                      "skin-bone {})",
                                      check.num_intersections(), check.skin_self, check.muscle_self, check.bone_self,
                                      check.skin_muscle, check.muscle_bone, check.skin_bone));
    for (const auto& [name, layer] : {std::pair{"bone to muscle wrap", check.muscle_thickness},
                                      std::pair{"muscle wrap to skin", check.fat_thickness}})
        line(name, fmt::format("{:.2f} to {:.2f} mm, mean {:.2f}", 1e3 * layer.min, 1e3 * layer.max, 1e3 * layer.mean));
    line("bones inside", containment_text(check.bones_inside));
    line("muscles inside", containment_text(check.muscles_inside));
    const Coverage& coverage = check.coverage;
    line("embedding",
         fmt::format("{} vertices: {} in an element, {} within {} mm, {} farther{}{}; {} skinned",
                     coverage.num_volumetric, coverage.num_inside, coverage.num_near, 1e3 * check.gates.embedding_limit,
                     coverage.num_far, coverage.worst.empty() ? "" : ": ", parts_text(coverage.worst),
                     coverage.num_skinned));
    line("weights",
         fmt::format("rows sum to 1 within {:.2g}, {:.3g} to {:.3g}, {} joints used{}{}", check.weights.worst_row_sum,
                     check.weights.min_weight, check.weights.max_weight, check.weights.num_joints_used,
                     check.weights.unused_joints.empty() ? "" : ", not ", names_text(check.weights.unused_joints)));
    line("joints outside skin", check.joints_outside.empty() ? std::string("none") : parts_text(check.joints_outside));
    fmt::format_to(out, "{:<20}{:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "segment", "interior", "muscle", "fat",
                   "no layers", "litre", "kg");
    for (const SegmentMeasure& segment : check.segments) {
        if (segment.volume() == 0.0) continue;
        fmt::format_to(out, "{:<20}{:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f} {:>9.3f}\n", segment.name,
                       1e3 * segment.interior, 1e3 * segment.muscle, 1e3 * segment.fat, 1e3 * segment.surface,
                       1e3 * segment.volume(), segment.mass);
    }
    line("skin encloses", fmt::format("{:.3f} litre; stature {:.3f} m", 1e3 * check.skin_volume, check.stature));
    line("left and right",
         fmt::format("differ by at most {:.2f} %{}{}", 100.0 * check.worst_asymmetry,
                     check.worst_asymmetry_segment.empty() ? "" : " in ", check.worst_asymmetry_segment));
    const auto failures = check.failures();
    line("result", failures.empty() ? std::string("passes") : fmt::format("fails: {}", fmt::join(failures, "; ")));
    return text;
}

}  // namespace ndg
