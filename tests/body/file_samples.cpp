// SPDX-License-Identifier: Apache-2.0
#include "file_samples.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <fstream>

namespace ndg::test {

Provenance example_provenance()
{
    Provenance provenance;
    provenance.tool = "test-body";
    provenance.config_json = R"({"rings": 5})";
    provenance.inputs = {{"base.obj", std::string(64, 'a'), ""}};
    provenance.licences = "tube: CC0";
    return provenance;
}

BodySet example_bodies(const Template& tube)
{
    BodySet set;
    set.parameter_names = {"stature_m", "mass_kg"};
    set.parameters.resize(3, 2);
    set.parameters << 1.6, 55.5, 1.7, 70.25, 1.8, 90.0;
    for (int i = 0; i < 3; ++i) {
        Body body = tube.rest;
        body.name = "body_" + std::to_string(i);
        const Eigen::RowVector3d scale(1.0 + 0.1 * i, 1.0 + 0.05 * i, 1.0 + 0.02 * i * i);
        for (Points* points :
             {&body.skin_vertices, &body.volume_vertices, &body.interior_vertices, &body.joint_positions}) {
            points->array().rowwise() *= scale.array();
        }
        set.bodies.push_back(body);
    }
    return set;
}

SkinSet skins_of(const BodySet& bodies)
{
    return {{bodies.bodies.begin(), bodies.bodies.end()},
            bodies.parameter_names,
            bodies.parameters,
            bodies.template_sha256};
}

PoseSet example_poses()
{
    PoseSet set;
    set.poses = {Pose::rest(num_standard_joints), tube_pose(0.5), tube_pose(-2.0)};
    Random random(31, "poses");
    for (Eigen::Matrix3d& rotation : set.poses[2].parent_from_joint) {
        rotation = Eigen::AngleAxisd(random.uniform(-3.0, 3.0),
                                     Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized())
                       .toRotationMatrix();
    }
    set.poses[1].root_translation = {0.125, -0.1, 3.3};
    set.clip_idx = {0, 1, 1};
    set.frame_idx = {0, 12, 90};
    set.clip_names = {"walk", "run"};
    set.clip_frame_rates = {120.0, 59.94};
    set.covering_radius = {3.5, 2.25, 0.0};
    return set;
}

Splits example_splits()
{
    Splits splits;
    splits.bodies = {{"train", {0, 3}}, {"validation", {1}}, {"test", {2}}};
    splits.poses = {{"train", {4, 0, 1}}, {"validation", {2}}, {"test", {3}}};
    splits.pairs = {{"train", {{0, 4}, {3, 1}, {0, 0}}}, {"validation", {{1, 2}}}, {"test", {}}};
    return splits;
}

DeformationSet example_deformations()
{
    DeformationSet set;
    set.method = "FEM";
    Random random(32, "deformations");
    for (int i = 0; i < 3; ++i) {
        Points points(4, 3);
        for (Eigen::Index k = 0; k < points.size(); ++k) points.data()[k] = random.normal();
        set.add({i, 2 - i}, split_names[static_cast<std::size_t>(i)], points);
    }
    set.statistics = {{"seconds", {0.5, 0.25, 0.125}}, {"converged", {1, 1, 0}}};
    return set;
}

ShapeSpace example_shape_space(const BodySet& bodies)
{
    std::vector<const Points*> shapes;
    for (const Body& body : bodies.bodies) shapes.push_back(&body.volume_vertices);
    return fit_shape_space(shapes, 300, 1.0);
}

void write_example_shape_space(const std::string& path, const BodySet& bodies)
{
    const ShapeSpace space = example_shape_space(bodies);
    RowMatrix codes(static_cast<Eigen::Index>(bodies.bodies.size()), space.dimension());
    for (Eigen::Index i = 0; i < codes.rows(); ++i) {
        codes.row(i) = space.encode(bodies.bodies[static_cast<std::size_t>(i)].volume_vertices).transpose();
    }
    write_shape_space(path, space, codes, std::vector<double>(bodies.bodies.size(), 0.0), example_provenance());
}

void run_python(const std::string& script)
{
    const TemporaryFolder folder;
    std::ofstream(folder.file("script.py")) << "import shutil\nimport h5py\nimport numpy as np\n" << script;
    const CommandResult result = run_command("/usr/bin/python3 " + folder.file("script.py"));
    INFO(result.output);
    REQUIRE(result.exit_code == 0);
}

void check_damages(const std::string& path, const std::vector<Damage>& damages,
                   const std::function<void(const std::string&)>& read)
{
    REQUIRE_NOTHROW(read(path));
    const auto copy = [&](std::size_t i) { return path + "." + std::to_string(i) + ".h5"; };
    std::string script =
        "def put(name, data):\n"
        "    del f[name]\n"
        "    f[name] = data\n";
    for (std::size_t i = 0; i < damages.size(); ++i) {
        script += "shutil.copy('" + path + "', '" + copy(i) + "')\n";
        script += "with h5py.File('" + copy(i) + "', 'r+') as f:\n    " + damages[i].python + "\n";
    }
    run_python(script);
    for (std::size_t i = 0; i < damages.size(); ++i) {
        INFO(damages[i].python);
        std::string message;
        try {
            read(copy(i));
        } catch (const InputError& error) {
            message = error.what();
        }
        INFO("message: " << message);
        CHECK(message.find(copy(i)) != std::string::npos);
        for (const std::string& word : damages[i].expected) CHECK(message.find(word) != std::string::npos);
    }
}

}  // namespace ndg::test
