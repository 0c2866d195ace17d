// SPDX-License-Identifier: Apache-2.0
// A trunk's bones in another skin: depths measured by closest points of the skin, not by the sections that place them.
#include "ndg/body/skeleton.h"
#include "ndg/body_source/bone_cover.h"
#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/placement/trunk_map.h"
#include "ndg/procedural/body.h"

#include <catch2/catch.hpp>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

const ProceduralBody& people()
{
    static const ProceduralBody body;
    return body;
}

ProceduralParameters person(double sex, double stature_m, double bmi)
{
    ProceduralParameters p;
    p.sex = sex;
    p.stature_m = stature_m;
    p.mass_kg = bmi * stature_m * stature_m;
    return p;
}

TrunkTarget target_of(const ParametricSurface& surface, double sex, double bmi)
{
    return {surface.vertices,
            surface.triangles,
            on_trunk(people().weights()),
            surface.joint_positions,
            stature(surface.vertices),
            bmi,
            sex};
}

const TemplateSource& source()
{
    static const TemplateSource man = people().source(person(1.0, 1.75, 23.5));
    return man;
}

}  // namespace

TEST_CASE("the tips of the spinous processes come as deep under the back as the body mass index says",
          "[placement][slow]")
{
    const TrunkBones bones = trunk_bones(source().anatomy);
    for (const auto& [sex, height, bmi] : {std::tuple(0.0, 1.55, 19.0), std::tuple(0.0, 1.65, 32.0),
                                           std::tuple(1.0, 1.90, 24.0), std::tuple(1.0, 1.70, 34.0)}) {
        const ParametricSurface surface = people().evaluate(person(sex, height, bmi));
        const TrunkTarget target = target_of(surface, sex, bmi);
        const TrunkMap map(bones, source().joint_positions, target);
        const TriangleTree skin(surface.vertices, surface.triangles);
        Points tips(bones.spinous_tips.rows(), 3);
        for (Eigen::Index level = 0; level < tips.rows(); ++level) {
            tips.row(level) = map(bones.spinous_tips.row(level).transpose()).transpose();
            const double depth = -skin.signed_distance(tips.row(level).transpose());
            INFO("level " << level << " of sex " << sex << " with BMI " << bmi << ": " << 1e3 * depth << " mm");
            CHECK(std::abs(depth - spinous_depth(double(level), bmi)) < 0.011);
            if (level > 0) CHECK(tips(level, 1) < tips(level - 1, 1));
        }
        // Depth over breadth of the cage, from the bones as they come out.
        double front = -1.0, half_breadth = 0.0;
        for (const AnatomyMesh& part : source().anatomy) {
            const bool rib = part.name.find(" rib") != std::string::npos, sternum = part.name == "Sternum";
            if (!rib && !sternum) continue;
            for (Eigen::Index v = 0; v < part.vertices.rows(); ++v) {
                const Eigen::Vector3d x = map(part.vertices.row(v).transpose());
                if (rib) half_breadth = std::max(half_breadth, std::abs(x[0]));
                if (sternum) front = std::max(front, x[2]);
                // Beside the midline a rib may touch a thin skin; wraps are pressed under it (press_under_skin).
                CHECK(skin.signed_distance(x) < 0.004);
            }
        }
        const double index = (front - tips.col(2).minCoeff()) / (2.0 * half_breadth);
        CHECK((index > 0.6 && index < 0.85));
        // Hips and clavicles keep the heights of the target's joints, so that placing again changes nothing.
        const Skeleton& skeleton = standard_skeleton();
        for (const char* name : {"left_thigh", "right_clavicle"}) {
            const int j = skeleton.joint(name);
            CHECK(map(source().joint_positions.row(j).transpose())[1] ==
                  Approx(surface.joint_positions(j, 1)).margin(1e-9));
        }
    }
}

TEST_CASE("a spine in the middle of the source's chest comes to the back all the same", "[placement][slow]")
{
    std::vector<AnatomyMesh> forward = source().anatomy;
    for (AnatomyMesh& part : forward)
        if (part.name.find("vertebra") != std::string::npos) part.vertices.col(2).array() += 0.05;
    const ParametricSurface surface = people().evaluate(person(1.0, 1.75, 25.0));
    const TrunkTarget target = target_of(surface, 1.0, 25.0);
    const TrunkBones bones = trunk_bones(forward);
    const TrunkMap map(bones, source().joint_positions, target);
    const TriangleTree skin(surface.vertices, surface.triangles);
    for (Eigen::Index level = 0; level < bones.spinous_tips.rows(); ++level) {
        const double depth = -skin.signed_distance(map(bones.spinous_tips.row(level).transpose()));
        CHECK(std::abs(depth - spinous_depth(double(level), 25.0)) < 0.012);
    }
}

TEST_CASE("what a trunk cannot be placed by is named", "[placement]")
{
    std::vector<AnatomyMesh> parts = source().anatomy;
    parts.erase(std::remove_if(parts.begin(), parts.end(),
                               [](const AnatomyMesh& part) { return part.name == "Eighth thoracic vertebra"; }),
                parts.end());
    CHECK_THROWS_WITH(trunk_bones(parts), Contains("eighth thoracic vertebra"));
    const ParametricSurface surface = people().evaluate(person(1.0, 1.75, 25.0));
    TrunkTarget target = target_of(surface, 1.0, 25.0);
    target.joints.col(1).array() += 3.0;
    CHECK_THROWS_WITH(TrunkMap(trunk_bones(source().anatomy), source().joint_positions, target),
                      Contains("no trunk at a height"));
}

TEST_CASE("published depths grow with level and body mass index", "[placement]")
{
    // Kawchuk 2011, at the mean index of that study.
    CHECK(spinous_depth(level_l1, 27.2) == Approx(0.0228));
    CHECK(spinous_depth(level_l5, 27.2) == Approx(0.0367));
    CHECK(spinous_depth(15.5, 27.2) == Approx(0.5 * (0.0274 + 0.0334)));
    for (int level = 0; level <= level_l5; ++level) {
        CHECK(spinous_depth(level, 40.0) > spinous_depth(level, 30.0) + 0.008);
        CHECK(spinous_depth(level, 14.0) >= 0.006);
    }
}
