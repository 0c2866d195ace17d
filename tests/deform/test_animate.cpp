// SPDX-License-Identifier: Apache-2.0
// Samples through methods: files written and read, what is computed once a body, and the table of methods.
#include "ndg/deform/animate.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/dataset/anatomy_file.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/deform/gradient_skinning.h"
#include "ndg/deform/lbs_deformer.h"
#include "ndg/deform/projective_skinning.h"
#include "ndg/deform/rest_cache.h"
#include "ndg/deform/rigid_parts.h"
#include "ndg/deform/stored_gradients.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <filesystem>

using namespace ndg;

namespace {

/// Two tubes in two bends; bodies alternate, as they do in splits.
struct Scene : SampleInputs {
    test::TemporaryFolder folder;

    Scene()
    {
        body_template = test::tube_template(5, 6);
        Body large = body_template.rest;
        large.name = "large";
        for (Points* points :
             {&large.volume_vertices, &large.skin_vertices, &large.interior_vertices, &large.joint_positions}) {
            *points *= 1.1;
        }
        bodies.bodies = {body_template.rest, large};
        poses.poses = {test::tube_pose(0.3), test::tube_pose(-0.8)};
        samples.pairs = {{1, 0}, {0, 1}, {1, 1}};
        samples.posing = test::bending;
        samples.pair_splits = {"test", "test", "train"};
    }

    PosedBody posed(const BodyPoser& poser, const SamplePair& pair) const
    {
        return poser.pose(bodies.bodies[pair.body_idx], poses.poses[pair.pose_idx], pair);
    }

    /// Gradient file of the samples with F_p = R_p.
    std::string write_rotations() const
    {
        const std::string path = folder.file("gradients.h5");
        SampleIndex index = samples;
        index.method = "test method";
        GradientWriter writer(path, index, body_template.num_prisms(), Provenance{});
        const BodyPoser poser(body_template, test::bending);
        for (int i = 0; i < samples.size(); ++i) {
            GradientsF gradients(body_template.num_prisms(), 9);
            for (int p = 0; p < gradients.rows(); ++p) {
                Eigen::Map<Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>(gradients.row(p).data()) =
                    posed(poser, samples.pairs[i]).prism_rotations()[p].cast<float>();
            }
            writer.write(i, gradients);
        }
        writer.commit();
        return path;
    }
};

MethodTable methods_without_options()
{
    MethodTable table;
    register_gradient_skinning(table);
    register_lbs(table);
    register_projective_skinning(table);
    register_rigid_parts(table);
    return table;
}

}  // namespace

TEST_CASE_METHOD(Scene, "Every sample of a file is what its method gives the posed body, in the order asked for")
{
    const BodyPoser poser(body_template, test::bending);
    for (const std::string& flag : methods_without_options().flags()) {
        INFO(flag);
        const DeformationMethod method = methods_without_options().find(flag);
        const std::string path = folder.file(flag + ".h5");
        animate_samples(*this, *method.make(BodyPoser(body_template, test::bending)), method.table_name, {path, ""},
                        Provenance{});
        const DeformationSet set = open_deformations(path, body_template.num_volume_vertices());
        REQUIRE(set.method == method.table_name);
        REQUIRE(set.pairs == samples.pairs);
        REQUIRE(set.pair_splits == samples.pair_splits);
        for (int i = 0; i < set.size(); ++i) {
            const Points expected =
                method.make(BodyPoser(body_template, test::bending))->deform(posed(poser, samples.pairs[i]));
            CHECK(set.points(i).cast<float>() == expected.cast<float>());
        }
    }
}

TEST_CASE_METHOD(Scene, "Stored gradients give the vertices of Gradient Skinning where they are the rotations")
{
    StoredGradients gradients(body_template, write_rotations());
    REQUIRE(gradients.name() == "test method");
    const std::string path = folder.file("ndg.h5"), anatomy_path = folder.file("anatomy.h5");
    animate_samples(*this, gradients, gradients.name(), {path, anatomy_path}, Provenance{});
    const DeformationSet set = open_deformations(path, body_template.num_volume_vertices());
    REQUIRE(set.method == "test method");
    const AnatomyReader anatomy(anatomy_path, int(body_template.anatomy_vertices.rows()));
    REQUIRE(anatomy.size() == 3);
    REQUIRE(anatomy.triangles() == body_template.anatomy_triangles);
    const BodyPoser poser(body_template, test::bending);
    const auto skinning =
        methods_without_options().find("gradient-skinning").make(BodyPoser(body_template, test::bending));
    for (int i = 0; i < set.size(); ++i) {
        const PosedBody body = posed(poser, samples.pairs[i]);
        CHECK((set.points(i) - skinning->deform(body)).cwiseAbs().maxCoeff() < 1e-5);
        const Points carried = apply_embedding(body_template.embedding, set.points(i), body.bone_interior());
        const std::vector<float> stored = anatomy.read(i);
        const Eigen::Map<const PointsF> vertices(stored.data(), carried.rows(), 3);
        CHECK((vertices.cast<double>() - carried).cwiseAbs().maxCoeff() < 1e-5);
    }
    CHECK_THROWS_WITH(gradients.deform(posed(poser, {0, 0})), Catch::Contains("gradients.h5"));
    CHECK_THROWS_AS(gradients.deform(poser.pose(bodies.bodies[0], poses.poses[0])), InputError);
}

TEST_CASE_METHOD(Scene, "Anatomy files hold what the method makes of the anatomy")
{
    RigidParts parts(body_template);
    const std::string path = folder.file("parts.h5"), anatomy_path = folder.file("anatomy.h5");
    animate_samples(*this, parts, "Rigid parts", {path, anatomy_path}, Provenance{});
    const AnatomyReader anatomy(anatomy_path);
    CHECK(anatomy.index().method == "Rigid parts");
    const BodyPoser poser(body_template, test::bending);
    for (int i = 0; i < samples.size(); ++i) {
        const PosedBody body = posed(poser, samples.pairs[i]);
        const Points at_rest = anatomy_at_rest(body_template, body.body());
        const Points expected = parts.anatomy(body, at_rest, parts.deform(body));
        const std::vector<float> stored = anatomy.read(i);
        const Eigen::Map<const PointsF> vertices(stored.data(), expected.rows(), 3);
        CHECK(vertices == expected.cast<float>());
        CHECK((expected - body.anatomy(at_rest, parts.deform(body))).norm() > 1e-3);
    }
}

TEST_CASE_METHOD(Scene, "Batches hold every sample once, body by body")
{
    std::vector<int> seen, bodies_in_turn;
    for_each_posed_batch(*this, 2, "posing", [&](const std::vector<int>& indices, const std::vector<PosedBody>& batch) {
        REQUIRE(indices.size() <= 2);
        REQUIRE(batch.size() == indices.size());
        for (std::size_t k = 0; k < indices.size(); ++k) {
            seen.push_back(indices[k]);
            REQUIRE(batch[k].pair() == samples.pairs[indices[k]]);
            bodies_in_turn.push_back(batch[k].pair().body_idx);
        }
    });
    CHECK(seen == std::vector<int>{1, 0, 2});
    CHECK(bodies_in_turn == std::vector<int>{0, 1, 1});
}

TEST_CASE_METHOD(Scene, "What does not fit together is an input error and leaves no file")
{
    const std::string path = folder.file("lbs.h5");
    samples.pairs[2] = {2, 0};
    const auto lbs = methods_without_options().find("lbs").make(BodyPoser(body_template, test::bending));
    CHECK_THROWS_AS(animate_samples(*this, *lbs, "LBS", {path, ""}, Provenance{}), InputError);
    CHECK_FALSE(std::filesystem::exists(path));
    samples.pairs[2] = samples.pairs[1];
    CHECK_THROWS_WITH(StoredGradients(body_template, write_rotations()), Catch::Contains("twice"));
    CHECK_THROWS_AS(StoredGradients(test::tube_template(6, 6), folder.file("gradients.h5")), InputError);
}

TEST_CASE_METHOD(Scene, "Rest data follow the body")
{
    RestCache rest(body_template);
    for (const int body_idx : {0, 1, 0}) {
        const Body& body = bodies.bodies[body_idx];
        const RestOperators fresh(body_template.prisms, body.volume_vertices);
        const RestOperators& operators = rest.operators(body);
        CHECK(&rest.operators(body) == &operators);
        CHECK(operators.volume(3) == fresh.volume(3));
        CHECK(rest.anatomy(body) == anatomy_at_rest(body_template, body));
        const BodyPoser poser(body_template, test::bending);
        const PosedBody posed = poser.pose(body, poses.poses[1]);
        const PoissonReconstruction poisson(fresh, body_template.num_wrap_vertices());
        CHECK(gradient_skinning(posed, rest.poisson(body)) == gradient_skinning(posed, poisson));
    }
}

TEST_CASE("The table of methods holds every name once and knows what is missing")
{
    MethodTable table = methods_without_options();
    register_stored_gradients(table);
    CHECK(table.flags() ==
          std::vector<std::string>{"gradient-skinning", "lbs", "projective-skinning", "rigid-parts", "gradients"});
    CHECK(table.find("lbs").table_name == "LBS");
    for (const std::string& flag : table.flags()) CHECK_THAT(table.help(), Catch::Contains(flag + ": "));
    CHECK_THROWS_AS(table.find("LBS"), InputError);
    CHECK_THROWS_AS(register_lbs(table), Error);
    CHECK_THROWS_AS(table.add({"other", "", "no name in tables", {}, {}}), Error);
    const Template tube = test::tube_template(4, 5);
    CHECK_THROWS_WITH(table.find("gradients").make(BodyPoser(tube, test::bending)), Catch::Contains("--gradients"));
}
