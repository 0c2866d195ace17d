// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/scan_truth.h"

#include "ndg/core/error.h"
#include "ndg/io/h5.h"

namespace ndg {
namespace {

constexpr const char* format_name = "ndg-scan-truth";
constexpr int format_version = 1;

using Member = Points TrueBody::*;

void write_member(H5Writer& writer, const std::string& name, const ScanTruth& truth, Member member,
                  const std::string& description)
{
    const auto rows = static_cast<std::size_t>((truth.bodies.front().*member).rows());
    writer.create(name, {truth.bodies.size(), rows, 3}, description);
    for (std::size_t b = 0; b < truth.bodies.size(); ++b) {
        const RowMatrixF values = (truth.bodies[b].*member).cast<float>();
        writer.write_slice(name, b, values.data());
    }
}

void read_member(const H5Reader& reader, const std::string& name, Eigen::Index rows, ScanTruth& truth, Member member)
{
    const std::vector<std::size_t> expected = {truth.bodies.size(), static_cast<std::size_t>(rows), 3};
    require_input(reader.shape(name) == expected, "{}: {} does not hold {} bodies of {} points", reader.path(), name,
                  truth.bodies.size(), rows);
    for (std::size_t b = 0; b < truth.bodies.size(); ++b) {
        const std::vector<float> values = reader.read_slice(name, b);
        truth.bodies[b].*member =
            Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>>(values.data(), rows, 3)
                .cast<double>();
    }
}

}  // namespace

const TrueBody* ScanTruth::find(const std::string& name) const
{
    for (const TrueBody& body : bodies) {
        if (body.name == name) return &body;
    }
    return nullptr;
}

void write_scan_truth(const std::string& path, const ScanTruth& truth, const Provenance& provenance)
{
    require(!truth.bodies.empty(), "There are no scans whose truth could be written to {}", path);
    H5Writer writer(path, format_name, format_version, provenance);
    std::vector<std::string> names;
    for (const TrueBody& body : truth.bodies) names.push_back(body.name);
    writer.write("/bodies/names", names, "names of the bodies, as the scans' files have them");
    write_member(writer, "/bodies/posed_skin", truth, &TrueBody::posed_skin, "true skin in the scan's pose and place");
    write_member(writer, "/bodies/posed_joints", truth, &TrueBody::posed_joints, "true joints in the scan's pose");
    write_member(writer, "/bodies/rest_skin", truth, &TrueBody::rest_skin, "the skin that was posed and scanned");
    write_member(writer, "/bodies/rest_joints", truth, &TrueBody::rest_joints, "its joints");
    writer.commit();
}

ScanTruth read_scan_truth(const std::string& path, const Template& body_template)
{
    const H5Reader reader(path, format_name, format_version);
    ScanTruth truth;
    for (const std::string& name : reader.read_strings("/bodies/names")) {
        truth.bodies.emplace_back();
        truth.bodies.back().name = name;
    }
    const Eigen::Index skin = body_template.rest.skin_vertices.rows(), joints = body_template.skeleton.num_joints();
    read_member(reader, "/bodies/posed_skin", skin, truth, &TrueBody::posed_skin);
    read_member(reader, "/bodies/posed_joints", joints, truth, &TrueBody::posed_joints);
    read_member(reader, "/bodies/rest_skin", skin, truth, &TrueBody::rest_skin);
    read_member(reader, "/bodies/rest_joints", joints, truth, &TrueBody::rest_joints);
    return truth;
}

}  // namespace ndg
