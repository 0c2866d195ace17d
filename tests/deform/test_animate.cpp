// SPDX-License-Identifier: Apache-2.0
// Gradient and anatomy files, and reconstruction through them.
#include "ndg/core/error.h"
#include "ndg/dataset/anatomy_file.h"
#include "ndg/deform/baselines.h"
#include "ndg/deform/reconstruct.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;

namespace {

struct Scene {
    Template tube = test::tube_template(5, 6);
    BodySet bodies;
    PoseSet poses;
    std::vector<SamplePair> pairs = {{0, 1}, {1, 0}, {1, 1}};

    Scene()
    {
        Body large = tube.rest;
        large.name = "large";
        for (Points* points :
             {&large.volume_vertices, &large.skin_vertices, &large.interior_vertices, &large.joint_positions}) {
            *points *= 1.1;
        }
        bodies.bodies = {tube.rest, large};
        poses.poses = {test::tube_pose(0.3), test::tube_pose(-0.8)};
    }
};

}  // namespace

TEST_CASE("Gradients written are gradients read; reconstruction from them is gradient skinning")
{
    const Scene scene;
    const test::TemporaryFolder folder;
    const std::string path = folder.file("gradients.h5"), anatomy_path = folder.file("anatomy.h5");
    const BodyPoser poser(scene.tube);
    const int num_prisms = scene.tube.num_prisms();
    {
        GradientWriter writer(path, {"test method", scene.pairs, {"test", "test", "train"}}, num_prisms, Provenance{});
        for (std::size_t i = 0; i < scene.pairs.size(); ++i) {
            const Body& body = scene.bodies.bodies[static_cast<std::size_t>(scene.pairs[i].body_idx)];
            const auto rotations = poser.prism_rotations(
                poser.world_from_rest(body, scene.poses.poses[static_cast<std::size_t>(scene.pairs[i].pose_idx)]));
            std::vector<float> sample;
            for (const Eigen::Matrix3d& rotation : rotations) {
                for (int r = 0; r < 3; ++r) {
                    for (int c = 0; c < 3; ++c) sample.push_back(static_cast<float>(rotation(r, c)));
                }
            }
            writer.write(static_cast<int>(i), sample);
        }
        writer.commit();
    }
    const GradientReader reader(path, num_prisms);
    REQUIRE(reader.size() == 3);
    REQUIRE(reader.index().method == "test method");
    REQUIRE(reader.index().pairs[2].body_idx == 1);
    REQUIRE(reader.index().pairs[2].pose_idx == 1);
    REQUIRE(reader.index().pair_splits[2] == "train");

    const DeformationSet set =
        reconstruct_samples(scene.tube, scene.bodies, scene.poses, reader, anatomy_path, Provenance{});
    const DeformationSet expected =
        animate_baseline(scene.tube, scene.bodies, scene.poses, scene.pairs, "test", Baseline::gradient_skinning);
    REQUIRE(expected.method == "Gradient Skinning");
    const AnatomyReader anatomy(anatomy_path, static_cast<int>(scene.tube.anatomy_vertices.rows()));
    REQUIRE(anatomy.size() == 3);
    REQUIRE(anatomy.triangles() == scene.tube.anatomy_triangles);
    for (int i = 0; i < 3; ++i) {
        REQUIRE((set.points(i) - expected.points(i)).cwiseAbs().maxCoeff() < 1e-5);
        const SamplePair& pair = scene.pairs[static_cast<std::size_t>(i)];
        const Body& body = scene.bodies.bodies[static_cast<std::size_t>(pair.body_idx)];
        const auto world_from_rest =
            poser.world_from_rest(body, scene.poses.poses[static_cast<std::size_t>(pair.pose_idx)]);
        const Points carried =
            apply_embedding(scene.tube.embedding, set.points(i), poser.interior(body, world_from_rest));
        const std::vector<float> stored = anatomy.read(i);
        const Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>> vertices(stored.data(),
                                                                                                  carried.rows(), 3);
        REQUIRE((vertices.cast<double>() - carried).cwiseAbs().maxCoeff() < 1e-5);
    }
}

TEST_CASE("Wrong gradient files are named")
{
    const Scene scene;
    const test::TemporaryFolder folder;
    const std::string path = folder.file("gradients.h5");
    const std::vector<float> zeros(9 * 4, 0.0F);
    {
        GradientWriter writer(path, {"m", {{0, 0}, {0, 7}}, {"test", "test"}}, 4, Provenance{});
        writer.write(0, zeros);
        REQUIRE_THROWS_AS(writer.commit(), Error);
        REQUIRE_THROWS_AS(writer.write(2, zeros), Error);
    }
    REQUIRE_FALSE(std::filesystem::exists(path));
    {
        GradientWriter writer(path, {"m", {{0, 0}, {0, 7}}, {"test", "test"}}, 4, Provenance{});
        writer.write(0, zeros);
        writer.write(1, zeros);
        writer.commit();
    }
    REQUIRE_THROWS_AS(GradientReader(path, 5), InputError);
    REQUIRE_THROWS_AS(GradientReader(folder.file("none.h5")), InputError);
    const GradientReader reader(path);
    REQUIRE_THROWS_AS(reconstruct_samples(scene.tube, scene.bodies, scene.poses, reader, "", Provenance{}), InputError);
    REQUIRE_THROWS_AS(parse_baseline("LBS"), InputError);
    REQUIRE_THROWS_AS(animate_baseline(scene.tube, scene.bodies, scene.poses, {{2, 0}}, "test", parse_baseline("lbs")),
                      InputError);
}
