// SPDX-License-Identifier: Apache-2.0
#include "ndg/measures/segment_measures.h"

#include "ndg/body/closed_wrap.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace ndg {
namespace {

constexpr double muscle_density = 1060.0, fat_density = 900.0, bone_density = 1300.0, trunk_organ_density = 970.0;
constexpr double head_density = 1110.0, hand_density = 1160.0, toes_density = 1100.0;

const std::vector<std::string>& segment_names()
{
    static const std::vector<std::string> names = {
        "head",       "trunk",      "left_upper_arm", "right_upper_arm", "left_forearm", "right_forearm", "left_hand",
        "right_hand", "left_thigh", "right_thigh",    "left_shin",       "right_shin",   "left_foot",     "right_foot"};
    return names;
}

std::size_t segment_index(const std::string& name)
{
    const auto& names = segment_names();
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

/// The segment of every joint: its own or that of the nearest ancestor which has one; the rest is trunk.
std::vector<std::size_t> segments_of_joints(const Skeleton& skeleton)
{
    std::vector<std::size_t> segments;
    for (int j = 0; j < skeleton.num_joints(); ++j) {
        const auto own = segment_index(skeleton.joint_names[j]);
        const int parent = skeleton.parents[j];
        segments.push_back(own < segment_names().size() ? own
                           : parent >= 0                ? segments[parent]
                                                        : segment_index("trunk"));
    }
    return segments;
}

/// The segment with most of the weight in a row.
class Segmentation {
public:
    explicit Segmentation(const Skeleton& skeleton) : of_joint_(segments_of_joints(skeleton)) {}

    void add(const SkinningWeights& weights, Eigen::Index row, std::vector<double>& shares) const
    {
        for (int k = 0; k < max_influences; ++k) shares[of_joint_[weights.joints(row, k)]] += weights.weights(row, k);
    }
    std::vector<double> none() const { return std::vector<double>(segment_names().size(), 0.0); }
    static std::size_t greatest(const std::vector<double>& shares)
    {
        return static_cast<std::size_t>(std::max_element(shares.begin(), shares.end()) - shares.begin());
    }

private:
    std::vector<std::size_t> of_joint_;
};

/// Volumes of the regions beyond the cuts, closed over those.
void add_surfaces(const Template& body_template, const Body& body, const Segmentation& segmentation,
                  std::vector<SegmentMeasure>& segments)
{
    for (std::size_t region = 1; region < body_template.skin_region_names.size(); ++region) {
        std::vector<int> rows;
        for (std::size_t t = 0; t < body_template.skin_regions.size(); ++t)
            if (body_template.skin_regions[t] == static_cast<int>(region)) rows.push_back(static_cast<int>(t));
        if (rows.empty()) continue;
        const Triangles triangles = body_template.skin_triangles(rows, Eigen::all);
        const ClosedBoneWrap closed = close_bone_wrap(body.skin_vertices, triangles);
        auto shares = segmentation.none();
        for (Eigen::Index t = 0; t < triangles.rows(); ++t)
            for (int k = 0; k < 3; ++k) segmentation.add(body_template.skin_weights, triangles(t, k), shares);
        segments[Segmentation::greatest(shares)].surface += enclosed_volume(closed.vertices, closed.triangles);
    }
}

/// Volumes of bones, of those that lie in the volume for more than half.
void add_bones(const Template& body_template, const Eigen::Ref<const Points>& anatomy, const Segmentation& segmentation,
               std::vector<SegmentMeasure>& segments)
{
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        if (part.layer != AnatomyLayer::bone || part.vertex_end == part.vertex_begin) continue;
        auto shares = segmentation.none();
        int embedded = 0;
        for (int v = part.vertex_begin; v < part.vertex_end; ++v) {
            embedded += body_template.embedding.elements[v] >= 0 ? 1 : 0;
            segmentation.add(body_template.anatomy_weights, v, shares);
        }
        if (2 * embedded <= part.vertex_end - part.vertex_begin) continue;
        const Triangles triangles =
            body_template.anatomy_triangles.middleRows(part.triangle_begin, part.triangle_end - part.triangle_begin)
                .array() -
            part.vertex_begin;
        segments[Segmentation::greatest(shares)].bones += std::abs(
            enclosed_volume(anatomy.middleRows(part.vertex_begin, part.vertex_end - part.vertex_begin), triangles));
    }
}

double mass_of(const SegmentMeasure& segment)
{
    const double bones = std::min(segment.bones, segment.interior);
    const bool trunk = segment.name == "trunk";
    const double whole = segment.name == "head"                            ? head_density
                         : segment.name.find("_hand") != std::string::npos ? hand_density
                                                                           : toes_density;
    return bones * bone_density + (segment.interior - bones) * (trunk ? trunk_organ_density : muscle_density) +
           segment.muscle * muscle_density + segment.fat * fat_density + segment.surface * whole;
}

}  // namespace

std::vector<SegmentMeasure> segment_measures(const Template& body_template, const Body& body,
                                             const Eigen::Ref<const Points>& anatomy)
{
    const Segmentation segmentation(body_template.skeleton);
    std::vector<SegmentMeasure> segments;
    for (const std::string& name : segment_names()) {
        segments.emplace_back();
        segments.back().name = name;
    }
    const SkinningWeights volume_weights = body_template.volume_weights();
    const Eigen::VectorXd prisms = prism_volumes(body.volume_vertices, body_template.prisms);
    for (Eigen::Index p = 0; p < prisms.size(); ++p) {
        auto shares = segmentation.none();
        for (int k = 0; k < 6; ++k) segmentation.add(volume_weights, body_template.prisms(p, k), shares);
        SegmentMeasure& segment = segments[Segmentation::greatest(shares)];
        (p < body_template.fat_begin() ? segment.muscle : segment.fat) += prisms[p];
    }
    const int num_wrap = body_template.num_wrap_vertices();
    for (Eigen::Index t = 0; t < body_template.tetrahedra.rows(); ++t) {
        auto shares = segmentation.none();
        std::array<Eigen::Vector3d, 4> corners;
        for (int k = 0; k < 4; ++k) {
            const int v = body_template.tetrahedra(t, k);
            corners[k] = v < num_wrap ? body.volume_vertices.row(v) : body.interior_vertices.row(v - num_wrap);
            segmentation.add(v < num_wrap ? volume_weights : body_template.interior_weights,
                             v < num_wrap ? v : v - num_wrap, shares);
        }
        segments[Segmentation::greatest(shares)].interior +=
            tetrahedron_volume(corners[0], corners[1], corners[2], corners[3]);
    }
    add_surfaces(body_template, body, segmentation, segments);
    add_bones(body_template, anatomy, segmentation, segments);
    SegmentMeasure whole;
    whole.name = "whole body";
    for (SegmentMeasure& segment : segments) {
        segment.mass = mass_of(segment);
        whole.interior += segment.interior;
        whole.muscle += segment.muscle;
        whole.fat += segment.fat;
        whole.surface += segment.surface;
        whole.bones += segment.bones;
        whole.mass += segment.mass;
    }
    segments.push_back(whole);
    return segments;
}

double worst_asymmetry(const std::vector<SegmentMeasure>& segments, std::string& segment)
{
    double worst = 0.0;
    for (const SegmentMeasure& left : segments) {
        if (left.name.rfind("left_", 0) != 0) continue;
        const std::string name = left.name.substr(5);
        for (const SegmentMeasure& right : segments) {
            const double mean = 0.5 * (left.volume() + right.volume());
            if (right.name != "right_" + name || !(mean > 0.0)) continue;
            const double difference = std::abs(left.volume() - right.volume()) / mean;
            if (difference <= worst) continue;
            worst = difference;
            segment = name;
        }
    }
    return worst;
}

}  // namespace ndg
