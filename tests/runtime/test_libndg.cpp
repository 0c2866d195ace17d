// SPDX-License-Identifier: Apache-2.0
// The C interface against the classes behind it.
#include "ndg/runtime/ndg.h"

#include "ndg/body/template.h"
#include "ndg/runtime/runtime.h"
#include "support/random_network.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cstring>
#include <limits>
#include <string>

using namespace ndg;

namespace {

struct Files {
    test::TemporaryFolder folder;
    std::string template_path = folder.file("template.h5"), bodies_path = folder.file("bodies.h5");
    std::string model_path = folder.file("model.ndg");

    Files()
    {
        write_template(template_path, test::tube_template(7, 8), Provenance{});
        const Template tube = read_template(template_path);
        BodySet bodies;
        bodies.template_sha256 = tube.file_sha256;
        bodies.bodies = {tube.rest, tube.rest};
        bodies.bodies[1].name = "thick";
        bodies.bodies[1].volume_vertices *= 1.1;
        write_bodies(bodies_path, bodies, Provenance{});
        test::RandomNetwork network;
        network.traits.posing = test::bending;
        test::write_random_network(model_path, tube, network);
    }
};

std::vector<double> quaternions(const Pose& pose, double length)
{
    std::vector<double> values;
    for (const Eigen::Matrix3d& rotation : pose.parent_from_joint) {
        const Eigen::Vector4d q = length * Eigen::Quaterniond(rotation).coeffs();
        values.insert(values.end(), q.data(), q.data() + 4);
    }
    return values;
}

}  // namespace

TEST_CASE("libndg gives what the runtime gives")
{
    const Files files;
    ndg_runtime* runtime = nullptr;
    REQUIRE(ndg_load(files.template_path.c_str(), files.bodies_path.c_str(), files.model_path.c_str(), &runtime) ==
            NDG_DONE);
    CHECK(ndg_num_bodies(runtime) == 2);
    CHECK(std::string(ndg_body_name(runtime, 1)) == "thick");
    CHECK(ndg_body_name(runtime, 2) == nullptr);
    REQUIRE(ndg_num_joints(runtime) == 60);
    CHECK(std::string(ndg_joint_name(runtime, 0)) == "pelvis");
    CHECK(ndg_joint_parent(runtime, 0) == -1);

    const Template tube = read_template(files.template_path);
    const std::vector<Body> bodies = read_bodies(files.bodies_path, tube).bodies;
    const RuntimeModel model(files.model_path);
    Runtime expected(tube, model);
    expected.set_body(bodies[1]);
    Pose pose = test::tube_pose(0.9);
    pose.root_translation = {0.1, 0.2, 0.3};
    expected.set_pose(pose);
    REQUIRE(ndg_set_body(runtime, 1) == NDG_DONE);
    REQUIRE(ndg_set_pose(runtime, quaternions(pose, 2.0).data(), pose.root_translation.data()) == NDG_DONE);
    const int num_wrap = tube.num_wrap_vertices();
    const auto check = [&](ndg_surface surface, const Eigen::Ref<const PointsF>& points, const Triangles& triangles) {
        REQUIRE(ndg_num_vertices(runtime, surface) == points.rows());
        REQUIRE(ndg_num_triangles(runtime, surface) == triangles.rows());
        const Eigen::Map<const PointsF> vertices(ndg_vertices(runtime, surface), points.rows(), 3);
        CHECK((vertices - points).cwiseAbs().maxCoeff() < 1e-6F);
        CHECK(std::memcmp(ndg_triangles(runtime, surface), triangles.data(),
                          sizeof(int) * std::size_t(triangles.size())) == 0);
    };
    check(NDG_SKIN, expected.skin(), tube.skin_triangles);
    check(NDG_BONE_WRAP, expected.volume().topRows(num_wrap), tube.wrap_triangles);
    check(NDG_MUSCLE_WRAP, expected.volume().middleRows(num_wrap, num_wrap), tube.wrap_triangles);
    check(NDG_ANATOMY, expected.anatomy(), tube.anatomy_triangles);

    REQUIRE(ndg_num_parts(runtime) == 2);
    ndg_part part;
    REQUIRE(ndg_get_part(runtime, 1, &part) == NDG_DONE);
    CHECK(std::string(part.name) == "muscle");
    CHECK(part.is_bone == 0);
    CHECK(part.vertex_end == ndg_num_vertices(runtime, NDG_ANATOMY));
    ndg_free(runtime);
}

TEST_CASE("libndg tells what is wrong and goes on")
{
    const Files files;
    ndg_runtime* runtime = nullptr;
    CHECK(ndg_load(files.template_path.c_str(), files.bodies_path.c_str(), "no.ndg", &runtime) == NDG_BAD_INPUT);
    CHECK(runtime == nullptr);
    CHECK_THAT(std::string(ndg_error()), Catch::Contains("no.ndg"));
    CHECK(ndg_load(nullptr, nullptr, nullptr, &runtime) == NDG_BAD_INPUT);
    ndg_free(nullptr);
    REQUIRE(ndg_load(files.template_path.c_str(), files.bodies_path.c_str(), files.model_path.c_str(), &runtime) ==
            NDG_DONE);
    std::vector<double> rotations = quaternions(test::tube_pose(0.3), 1.0);
    const double displacement[3] = {};
    CHECK(ndg_set_pose(runtime, rotations.data(), displacement) == NDG_BAD_INPUT);
    CHECK_THAT(std::string(ndg_error()), Catch::Contains("body"));
    CHECK(ndg_set_body(runtime, 2) == NDG_BAD_INPUT);
    REQUIRE(ndg_set_body(runtime, 0) == NDG_DONE);
    for (const double wrong : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
        std::fill_n(rotations.begin() + 4, 4, wrong);
        CHECK(ndg_set_pose(runtime, rotations.data(), displacement) == NDG_BAD_INPUT);
        CHECK_THAT(std::string(ndg_error()), Catch::Contains("spine_1"));
    }
    rotations[7] = 1.0;
    std::fill_n(rotations.begin() + 4, 3, 0.0);
    CHECK(ndg_set_pose(runtime, rotations.data(), displacement) == NDG_DONE);
    ndg_part part;
    CHECK(ndg_get_part(runtime, -1, &part) == NDG_BAD_INPUT);
    CHECK(ndg_vertices(runtime, static_cast<ndg_surface>(7)) == nullptr);
    ndg_free(runtime);
}
