// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/fit_part.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"
#include "ndg/registration/fit_report.h"

#include <nlohmann/json.hpp>

namespace ndg {
namespace {

FitReport parse_report(const std::string& path, const std::string& text)
{
    FitReport r;
    try {
        const auto json = nlohmann::json::parse(text);
        json.at("name").get_to(r.name);
        json.at("file").get_to(r.file);
        json.at("unit").get_to(r.unit);
        json.at("up").get_to(r.up);
        json.at("unit_guessed").get_to(r.unit_guessed);
        json.at("up_guessed").get_to(r.up_guessed);
        json.at("file_points").get_to(r.file_points);
        json.at("points").get_to(r.points);
        json.at("heading_degrees").get_to(r.heading_degrees);
        json.at("scan_to_skin_mean_m").get_to(r.scan_to_skin_mean);
        json.at("scan_to_skin_p95_m").get_to(r.scan_to_skin_p95);
        json.at("scan_to_skin_max_m").get_to(r.scan_to_skin_max);
        json.at("skin_to_scan_mean_m").get_to(r.skin_to_scan_mean);
        json.at("skin_to_scan_p95_m").get_to(r.skin_to_scan_p95);
        json.at("skin_to_scan_max_m").get_to(r.skin_to_scan_max);
        json.at("coverage").get_to(r.coverage);
        json.at("seen").get_to(r.seen);
        json.at("stature_m").get_to(r.stature);
        json.at("flipped_triangles").get_to(r.flipped_triangles);
        json.at("smallest_area_ratio").get_to(r.smallest_area_ratio);
        json.at("worst_triangles").get_to(r.worst_triangles);
        json.at("fit_height_m").get_to(r.fit_height);
        json.at("scan_height_m").get_to(r.scan_height);
        json.at("shoulder_breadth_m").get_to(r.shoulder_breadth);
        for (int s = 0; s < num_skin_segments; ++s) {
            const std::string& name = segment_name(static_cast<SkinSegment>(s));
            const nlohmann::json& segment = json.at("segments").at(name);
            r.segments.push_back(
                {name, segment.at("seen"), segment.at("coverage"), segment.at("mean_m"), segment.at("covered")});
        }
        json.at("notes").get_to(r.notes);
        json.at("warnings").get_to(r.warnings);
        json.at("seconds").get_to(r.seconds);
        json.at("defects").get_to(r.defects);
    } catch (const nlohmann::json::exception& error) {
        throw InputError(fmt::format("{}: its report is damaged: {}", path, error.what()));
    }
    return r;
}

}  // namespace

void write_fit(H5Writer& writer, const FittedBody& fitted)
{
    writer.write("/report", std::vector<std::string>{report_json(fitted.report)}, "report of the fit, JSON");
    writer.write("/skin_vertices", fitted.body.skin_vertices, "skin at rest, m", Storage::float64);
    writer.write("/joint_positions", fitted.body.joint_positions, "joints at rest, m", Storage::float64);
    writer.write("/posed_skin", fitted.posed_skin, "skin in the scan's place, m", Storage::float64);
    writer.write("/posed_joints", fitted.posed_joints, "joints in the scan's place, m", Storage::float64);
    RowMatrix rotations(static_cast<Eigen::Index>(fitted.pose.parent_from_joint.size()), 9);
    for (Eigen::Index j = 0; j < rotations.rows(); ++j) {
        for (int k = 0; k < 9; ++k) {
            rotations(j, k) = fitted.pose.parent_from_joint[j](k / 3, k % 3);
        }
    }
    writer.write("/rotations", rotations, "of the joints, 3 x 3 row-major", Storage::float64);
    const Eigen::Vector3d& t = fitted.pose.root_translation;
    writer.write("/root_translation", std::vector<double>{t[0], t[1], t[2]}, "of the root joint, m");
}

FittedBody read_fit(const H5Reader& reader)
{
    FittedBody result;
    result.report = parse_report(reader.path(), reader.read_strings("/report", 1).front());
    result.body.name = result.report.name;
    result.body.skin_vertices = reader.read_matrix("/skin_vertices", -1, 3);
    result.body.joint_positions = reader.read_matrix("/joint_positions", num_standard_joints, 3);
    result.posed_skin = reader.read_matrix("/posed_skin", result.body.skin_vertices.rows(), 3);
    result.posed_joints = reader.read_matrix("/posed_joints", num_standard_joints, 3);
    const RowMatrix rotations = reader.read_matrix("/rotations", num_standard_joints, 9);
    result.pose = Pose::rest(num_standard_joints);
    for (Eigen::Index j = 0; j < rotations.rows(); ++j) {
        for (int k = 0; k < 9; ++k) {
            result.pose.parent_from_joint[j](k / 3, k % 3) = rotations(j, k);
        }
    }
    const std::vector<double> translation = reader.read_doubles("/root_translation", 3);
    result.pose.root_translation = {translation[0], translation[1], translation[2]};
    return result;
}

}  // namespace ndg
