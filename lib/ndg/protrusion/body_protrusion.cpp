// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/body_protrusion.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/protrusion/coarse_parts.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace ndg {

namespace {

/// Sample of each pair in a file.
std::vector<int> find_samples(const ProtrusionInput& file, const std::vector<SamplePair>& pairs)
{
    std::vector<int> samples;
    for (const SamplePair& pair : pairs) {
        const auto found = std::find(file.set.pairs.begin(), file.set.pairs.end(), pair);
        require_input(found != file.set.pairs.end(), "{} ({}) has no sample of {}", file.path, file.set.method,
                      describe(pair));
        samples.push_back(int(found - file.set.pairs.begin()));
    }
    return samples;
}

}  // namespace

BodyProtrusion::BodyProtrusion(const Template& body_template) : template_(&body_template)
{
    std::vector<Eigen::RowVector3i> kept;
    const std::vector<int>& elements = body_template.embedding.elements;
    for (Eigen::Index t = 0; t < body_template.anatomy_triangles.rows(); ++t) {
        const Eigen::RowVector3i corners = body_template.anatomy_triangles.row(t);
        if (elements[corners[0]] >= 0 && elements[corners[1]] >= 0 && elements[corners[2]] >= 0)
            kept.push_back(corners);
    }
    require_input(!kept.empty(), "the template has no anatomy whose protrusion could be measured");
    compared_anatomy_.resize(kept.size(), 3);
    for (std::size_t t = 0; t < kept.size(); ++t) compared_anatomy_.row(t) = kept[t];
    std::set<std::array<int, 3>> volumetric;
    for (Eigen::Index t = 0; t < body_template.wrap_triangles.rows(); ++t) {
        std::array<int, 3> corners;
        for (int k = 0; k < 3; ++k) corners[k] = body_template.wrap_to_skin[body_template.wrap_triangles(t, k)];
        std::sort(corners.begin(), corners.end());
        volumetric.insert(corners);
    }
    for (Eigen::Index t = 0; t < body_template.skin_triangles.rows(); ++t) {
        std::array<int, 3> corners;
        for (int k = 0; k < 3; ++k) corners[k] = body_template.skin_triangles(t, k);
        std::sort(corners.begin(), corners.end());
        compared_skin_.push_back(volumetric.count(corners) != 0);
    }
}

FrameProtrusion BodyProtrusion::posed(const PosedBody& posed, const Eigen::Ref<const Points>& anatomy_rest,
                                      const Eigen::Ref<const Points>& deformed_volume) const
{
    return measure(posed.display_skin(deformed_volume), posed.anatomy(anatomy_rest, deformed_volume));
}

FrameProtrusion BodyProtrusion::at_rest(const Body& body) const
{
    return measure(body.skin_vertices, anatomy_at_rest(*template_, body));
}

std::string BodyProtrusion::part_of(int vertex) const
{
    for (const AnatomyPart& part : template_->anatomy_parts)
        if (vertex >= part.vertex_begin && vertex < part.vertex_end) return part.name;
    return "";
}

std::string BodyProtrusion::deepest_part(const FrameProtrusion& frame) const
{
    return part_of(frame.deepest_vertex);
}

std::set<std::string> BodyProtrusion::intersecting_parts(const FrameProtrusion& frame) const
{
    std::set<std::string> parts;
    for (const int triangle : frame.intersecting) parts.insert(part_of(compared_anatomy_(triangle, 0)));
    return parts;
}

FrameProtrusion BodyProtrusion::measure(Points skin_vertices, const Points& anatomy) const
{
    return frame_protrusion({std::move(skin_vertices), template_->skin_triangles, compared_skin_}, anatomy,
                            compared_anatomy_);
}

ProtrusionTable body_protrusion(const Template& body_template, const BodySet& bodies, const std::vector<Pose>& poses,
                                const std::vector<SamplePair>& pairs, const std::vector<ProtrusionInput>& files)
{
    require_input(!files.empty(), "there are no deformations whose protrusion could be measured");
    for (const ProtrusionInput& file : files)
        require_input(file.set.posing.bone_wrap == files[0].set.posing.bone_wrap,
                      "{}: its bodies are posed with bone-wrap {}, those of {} with {}", file.path,
                      to_name(file.set.posing.bone_wrap), files[0].path, to_name(files[0].set.posing.bone_wrap));
    std::vector<std::vector<int>> samples;
    for (const ProtrusionInput& file : files) samples.push_back(find_samples(file, pairs));
    std::map<int, std::vector<int>> pairs_of_body;  // what a body costs is paid once
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        require_pair(pairs[i], bodies.bodies.size(), poses.size());
        pairs_of_body[pairs[i].body_idx].push_back(int(i));
    }

    ProtrusionTable table;
    table.pairs = int(pairs.size());
    std::vector<ProtrusionSum> sums;
    for (const ProtrusionInput& file : files) sums.emplace_back(file.set.method);
    const BodyPoser poser(body_template, files[0].set.posing);
    const BodyProtrusion measured(body_template);
    const CoarseParts parts(body_template);
    Progress progress("protrusion", pairs.size());
    for (const auto& [body_idx, indices] : pairs_of_body) {
        const Body& body = bodies.bodies[body_idx];
        const FrameProtrusion rest = measured.at_rest(body);
        ++table.bodies;
        table.bodies_intersecting_at_rest += !rest.intersecting.empty();
        for (const std::string& part : measured.intersecting_parts(rest)) ++table.parts_intersecting_at_rest[part];
        table.bodies_protruding_at_rest += rest.protruding_vertices > 0;
        const Points anatomy_rest = anatomy_at_rest(body_template, body);
        for (const int i : indices) {
            progress.advance();
            const PosedBody posed = poser.pose(body, poses[pairs[i].pose_idx], pairs[i]);
            if (parts.collide(posed.skinned_skin())) {
                ++table.colliding_pairs;
                continue;
            }
            for (std::size_t f = 0; f < files.size(); ++f) {
                const FrameProtrusion frame = measured.posed(posed, anatomy_rest, files[f].set.points(samples[f][i]));
                sums[f].add(frame, describe(pairs[i]), measured.deepest_part(frame),
                            measured.intersecting_parts(frame));
            }
        }
    }
    require_input(table.colliding_pairs < table.pairs, "coarse parts of the body collide in all {} pairs", table.pairs);
    for (const ProtrusionSum& sum : sums) table.rows.push_back(sum.row());
    return table;
}

}  // namespace ndg
