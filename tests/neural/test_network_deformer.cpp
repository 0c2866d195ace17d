// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/network_deformer.h"

#include "ndg/core/error.h"
#include "ndg/deform/gradient_skinning.h"
#include "synthetic.h"

#include <catch2/catch.hpp>

using namespace ndg;

namespace {

double largest_difference(const Points& a, const Points& b)
{
    return (a - b).cwiseAbs().maxCoeff();
}

/// Bodies 0, 6 and 0 again, posed.
std::vector<PosedBody> some_posed(const test::Synthetic& s, const BodyPoser& poser)
{
    std::vector<PosedBody> posed;
    for (const int body_idx : {0, 6, 0}) {
        posed.push_back(poser.pose(s.bodies.bodies[body_idx], s.poses.poses[posed.size() + 1]));
    }
    return posed;
}

}  // namespace

TEST_CASE("An untrained network poses bodies as Gradient Skinning does")
{
    const test::Synthetic s = test::make_synthetic(4, 2);
    const test::TemporaryFolder folder;
    NetworkInputs inputs;
    inputs.model_path = folder.file("model.h5");
    s.model(test::small_network()).save(inputs.model_path, Provenance{});
    NetworkDeformer network(BodyPoser(s.tube, test::bending), inputs);
    const BodyPoser poser(s.tube, test::bending);
    RestCache rest(s.tube);
    for (const PosedBody& posed : some_posed(s, poser)) {
        CHECK(largest_difference(network.deform(posed), gradient_skinning(posed, rest.poisson(posed.body()))) < 1e-5);
    }
}

TEST_CASE("Several bodies at once are what they are one by one, and what their gradients reconstruct")
{
    const test::Synthetic s = test::make_synthetic();
    const test::TemporaryFolder folder;
    NetworkInputs inputs;
    inputs.model_path = folder.file("model.h5");
    test::moved_model(s, test::small_network()).save(inputs.model_path, Provenance{});
    NetworkDeformer network(BodyPoser(s.tube, test::bending), inputs);
    CHECK(network.name() == "NDG");
    const BodyPoser poser(s.tube, test::bending);
    const std::vector<PosedBody> posed = some_posed(s, poser);
    const std::vector<Points> vertices = network.deform_batch(posed);
    const std::vector<GradientsF> gradients = network.gradients(posed);
    RestCache rest(s.tube);
    for (std::size_t i = 0; i < posed.size(); ++i) {
        const PoissonReconstruction& poisson = rest.poisson(posed[i].body());
        CHECK(vertices[i] == poisson.reconstruct(gradients[i], posed[i].bone_wrap()));
        CHECK(largest_difference(vertices[i], network.deform(posed[i])) < 1e-5);
        CHECK(largest_difference(vertices[i], gradient_skinning(posed[i], poisson)) > 1e-4);
    }
}

TEST_CASE("A vertex network poses bodies by its offsets, and has no gradients")
{
    const test::Synthetic s = test::make_synthetic(24, 8);
    const test::TemporaryFolder folder;
    NetworkInputs inputs;
    inputs.model_path = folder.file("model.h5");
    NetworkOptions options = test::small_network();
    options.output_space = "vertex-offsets";
    options.output_basis = 12;
    const NeuralModel model = test::moved_model(s, options);
    model.save(inputs.model_path, Provenance{});
    NetworkDeformer network(BodyPoser(s.tube, test::bending), inputs);
    CHECK(network.name() == "VertexNet");
    const BodyPoser poser(s.tube, test::bending);
    RestCache rest(s.tube);
    const std::vector<PosedBody> posed = some_posed(s, poser);
    const Points deformed = network.deform(posed[1]);
    const RowMatrixF prediction = model.predict({{model.input_space().encode(posed[1].body()), posed[1].pose()}});
    CHECK(largest_difference(deformed, model.output_space().vertices(posed[1], rest, prediction.data())) < 1e-6);
    CHECK(largest_difference(deformed, posed[1].skinned_volume()) > 1e-4);
    CHECK(deformed.topRows(s.tube.num_wrap_vertices()) == posed[1].bone_wrap());
    CHECK_THROWS_WITH(network.gradients(posed), Catch::Contains("no deformation gradients"));
}

TEST_CASE("A method without its model, or with another template's, is an input error")
{
    MethodTable table;
    register_network_deformer(table);
    const test::Synthetic s = test::make_synthetic(4, 2);
    CHECK_THROWS_WITH(table.find("ndg").make(BodyPoser(s.tube, test::bending)), Catch::Contains("--model"));
    const test::TemporaryFolder folder;
    NetworkInputs inputs;
    inputs.model_path = folder.file("model.h5");
    s.model(test::small_network()).save(inputs.model_path, Provenance{});
    Template another = s.tube;
    another.file_sha256 = "another";
    CHECK_THROWS_AS(NetworkDeformer(BodyPoser(another, test::bending), inputs), InputError);
    // What it was trained on is kept, and bodies posed otherwise are refused.
    NetworkOptions options = test::small_network();
    options.posing.bone_wrap = BoneWrap::rigid;
    s.model(options).save(inputs.model_path, Provenance{});
    CHECK_THROWS_WITH(NetworkDeformer(BodyPoser(s.tube, test::bending), inputs), Catch::Contains("bone-wrap rigid"));
    CHECK_NOTHROW(NetworkDeformer(BodyPoser(s.tube, {BoneWrap::rigid}), inputs));
}
