// SPDX-License-Identifier: Apache-2.0
// The anatomical source on real data; skipped without it.
#include "ndg/anatomical/registration.h"
#include "ndg/anatomical/skin_fit.h"
#include "ndg/anatomical/source.h"
#include "ndg/body/skeleton.h"
#include "ndg/body_source/skin_depth.h"
#include "ndg/core/error.h"
#include "ndg/geometry/simplify.h"
#include "ndg/geometry/triangle_mesh.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <map>

using namespace ndg;

namespace {

const AnatomyMesh& part(const std::vector<AnatomyMesh>& parts, const std::string& name)
{
    const auto found =
        std::find_if(parts.begin(), parts.end(), [&](const AnatomyMesh& mesh) { return mesh.name == name; });
    INFO(name);
    REQUIRE(found != parts.end());
    return *found;
}

Eigen::RowVector3d middle(const AnatomyMesh& mesh)
{
    return mesh.vertices.colwise().mean();
}

void check_parts(const std::vector<AnatomyMesh>& parts)
{
    std::map<AnatomyLayer, int> counts, vertices;
    for (const AnatomyMesh& mesh : parts) {
        ++counts[mesh.layer];
        vertices[mesh.layer] += int(mesh.vertices.rows());
        INFO(mesh.name);
        CHECK(count_open_edges(mesh.triangles) == 0);
        CHECK(mesh.fma_id > 0);
        CHECK(enclosed_volume(mesh.vertices, mesh.triangles) > 0.0);
    }
    CHECK(counts[AnatomyLayer::bone] == 239);
    CHECK(counts[AnatomyLayer::muscle] == 276);
    // Small parts that collapse no further keep a few more.
    CHECK(vertices[AnatomyLayer::bone] == Approx(12000).epsilon(0.03));
    CHECK(vertices[AnatomyLayer::muscle] == Approx(24000).epsilon(0.12));
    // Volumes of a man's bones (cm^3) within what is known of adults: nothing was lost in repair.
    const AnatomyMesh& femur = part(parts, "Left femur");
    CHECK(femur.fma_id == 24475);
    CHECK(femur.side == BodySide::left);
    CHECK(enclosed_volume(femur.vertices, femur.triangles) == Approx(480e-6).epsilon(0.1));
    CHECK(middle(femur)[0] > 0.0);
    for (const std::string muscle : {"external oblique", "soleus", "gluteus maximus"}) {
        const AnatomyMesh &left = part(parts, "Left " + muscle), &right = part(parts, "Right " + muscle);
        INFO(muscle);
        CHECK(enclosed_volume(left.vertices, left.triangles) ==
              Approx(enclosed_volume(right.vertices, right.triangles)).epsilon(0.15));
    }
}

/// The standing man's joints, against each other.
void check_points(const BonePoints& points)
{
    for (const std::string joint : {"thigh", "shin", "foot", "upper_arm", "forearm", "hand", "index_1", "clavicle"}) {
        const Eigen::Vector3d left = points.at("left_" + joint), right = points.at("right_" + joint);
        INFO(joint);
        CHECK((left - Eigen::Vector3d(-right[0], right[1], right[2])).norm() < 0.007);  // he is not quite symmetric
    }
    const auto length = [&](const char* a, const char* b) { return (points.at(a) - points.at(b)).norm(); };
    CHECK(length("left_thigh", "left_shin") / length("left_shin", "left_foot") == Approx(1.02).epsilon(0.08));
    CHECK(length("left_upper_arm", "left_forearm") / length("left_forearm", "left_hand") == Approx(1.05).epsilon(0.1));
    CHECK(points.at("neck_1")[1] > points.at("spine_5")[1]);
}

void check_registered(std::vector<AnatomyMesh> parts, const MakeHuman& body, double sex)
{
    INFO("sex " << sex);
    MakeHumanParameters person;
    person.sex = sex;
    const ParametricSurface surface = body.evaluate(person);
    AnatomyTarget target{surface.vertices, surface.triangles, body.weights(), surface.joint_positions, sex < 0.5};
    Points joints = register_anatomy(parts, target);
    const SkinFitReport fit = fit_to_skin(parts, joints, target);
    joints = symmetric_joints(joints);
    CHECK(fit.outside_before < 0.10);
    CHECK(fit.outside_after < 0.004);
    CHECK(fit.bone_displacement < 0.008);
    const Skeleton& skeleton = standard_skeleton();
    for (const std::string joint : {"upper_arm", "forearm", "hand", "shin", "foot", "index_2", "pinky_3"}) {
        const int j = skeleton.joint("left_" + joint);
        INFO(joint);
        CHECK((joints.row(j) - target.joints.row(j)).norm() < 0.012);
    }
    // What lies where: kneecap before the thigh bone, shoulder blade behind the ribs, ulna on the little finger's side.
    CHECK(middle(part(parts, "Left patella"))[2] > joints(skeleton.joint("left_shin"), 2));
    CHECK(middle(part(parts, "Left scapula"))[2] < middle(part(parts, "Left third rib"))[2]);
    CHECK(part(parts, "Left femur").joint == "left_thigh");
    CHECK(part(parts, "Mandible").joint == "jaw");
    CHECK(part(parts, "Distal phalanx of right index finger").joint == "right_index_3");
    // Attachments stay on bones: the end of the biceps that was nearest to the radius still is near it.
    const AnatomyMesh& radius = part(parts, "Left radius");
    const TriangleTree tree(radius.vertices, radius.triangles);
    double nearest = 1.0;
    for (const auto& row : part(parts, "Long head of left biceps brachii").vertices.rowwise())
        nearest = std::min(nearest, tree.closest(row.transpose()).distance);
    CHECK(nearest < 0.012);
    for (const AnatomyMesh& mesh : parts) {
        INFO(mesh.name);
        CHECK(mesh.vertices.allFinite());
        CHECK((mesh.layer != AnatomyLayer::bone || !mesh.joint.empty()));
    }
}

}  // namespace

TEST_CASE("Real bones and muscles are read whole, closed and named, and come to lie in male and female skins", "[slow]")
{
    const std::string folder = test::data_folder();
    if (folder.empty()) return;
    BodyParts3DOptions options;
    options.bone_vertices = 12000;
    options.muscle_vertices = 24000;
    const std::vector<AnatomyMesh> parts = read_bodyparts3d(folder + "/bodyparts3d", options);
    check_parts(parts);
    check_points(bone_points(parts));
    const MakeHuman body(folder + "/makehuman");
    for (const double sex : {1.0, 0.0}) check_registered(parts, body, sex);
}

TEST_CASE("Anatomy that is missing is named")
{
    const test::TemporaryFolder folder;
    CHECK_THROWS_WITH(read_bodyparts3d(folder.path(), {}), Catch::Matchers::Contains("no folder 'bones'"));
    AnatomyMesh stone;
    stone.name = "Philosopher's stone";
    CHECK_THROWS_WITH(bone_group(stone), Catch::Matchers::Contains("Philosopher's stone"));
    CHECK_THROWS_WITH(bone_points({stone}), Catch::Matchers::Contains("intervertebral disk"));
}
