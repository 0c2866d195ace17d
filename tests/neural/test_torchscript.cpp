// SPDX-License-Identifier: Apache-2.0
// TorchScript gives what the model gives.
#include "ndg/neural/torchscript.h"

#include "ndg/core/error.h"
#include "synthetic.h"

#include <torch/csrc/jit/serialization/import.h>
#include <torch/types.h>
#include <nlohmann/json.hpp>

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;

namespace {

/// Rows of what the file's module predicts, and its metadata.
struct Loaded {
    torch::jit::Module module;
    nlohmann::json metadata;

    explicit Loaded(const std::string& path)
    {
        std::unordered_map<std::string, std::string> files = {{"metadata.json", ""}};
        module = torch::jit::load(path, c10::nullopt, files);
        metadata = nlohmann::json::parse(files.at("metadata.json"));
    }

    torch::Tensor predict(const std::vector<Pose>& poses, const std::vector<const Body*>& bodies)
    {
        const auto count = static_cast<std::int64_t>(poses.size());
        const auto num_joints = static_cast<std::int64_t>(poses[0].parent_from_joint.size());
        const std::int64_t num_vertices = bodies[0]->volume_vertices.rows();
        torch::Tensor rotations = torch::empty({count, num_joints, 3, 3});
        torch::Tensor rest = torch::empty({count, num_vertices, 3});
        float *rotation = rotations.data_ptr<float>(), *vertex = rest.data_ptr<float>();
        for (std::int64_t i = 0; i < count; ++i) {
            for (const Eigen::Matrix3d& joint : poses[i].parent_from_joint)
                for (int k = 0; k < 9; ++k) *rotation++ = static_cast<float>(joint(k / 3, k % 3));
            for (Eigen::Index k = 0; k < 3 * num_vertices; ++k)
                *vertex++ = static_cast<float>(bodies[i]->volume_vertices.data()[k]);
        }
        return module.forward({rotations, rest}).toTensor();
    }
};

}  // namespace

TEST_CASE("TorchScript of every kind of network gives what the model gives")
{
    const TemporaryFolder folder;
    const Synthetic s = make_synthetic(40, 8);
    NetworkOptions network = small_network();
    std::vector<std::int64_t> shape = {-1, 3, 3};
    SECTION("exponential") {}
    SECTION("direct")
    {
        network.parametrisation = ParametrisationKind::direct;
    }
    SECTION("LU")
    {
        network.parametrisation = ParametrisationKind::lu;
    }
    SECTION("QR")
    {
        network.parametrisation = ParametrisationKind::qr;
    }
    SECTION("no body shape")
    {
        network.shape = false;
    }
    SECTION("a fixed basis")
    {
        network.output_basis = 8;
    }
    SECTION("a network for each region")
    {
        network.region_reach = 1;
    }
    SECTION("vertices")
    {
        network.output_space = "vertex-offsets";
        shape = {-1, 3};
    }
    NeuralModel model = moved_model(s, network);
    const std::string path = folder.file("model.pt");
    Provenance provenance;
    provenance.licences = "a licence";
    write_torchscript(path, model, provenance);

    Loaded loaded(path);
    Pose turned = s.poses.poses[45];  // the root's turn changes nothing
    turned.parent_from_joint[0] = rotation_about({1, 2, 3}, 0.7);
    const std::vector<Pose> poses = {s.poses.poses[3], s.poses.poses[45], turned};
    const std::vector<const Body*> bodies = {&s.bodies.bodies[1], &s.bodies.bodies[7], &s.bodies.bodies[7]};
    const torch::Tensor predicted = loaded.predict(poses, bodies);
    shape.insert(shape.begin(), 3);
    CHECK(predicted.sizes() == predicted.reshape(shape).sizes());
    const RowMatrixF rows =
        model.predict({s.input(model, 1, 3), s.input(model, 7, 45), {s.input(model, 7, 45).shape_code, turned}});
    const Eigen::Map<const RowMatrixF> scripted(predicted.data_ptr<float>(), 3, rows.cols());
    const float unit = network.output_space == "vertex-offsets" ? 1e3F : 1.0F;  // mm to m
    const float scale = (rows.row(0) - rows.row(1)).cwiseAbs().maxCoeff();
    CHECK(scale > 1e-2F);
    CHECK((unit * scripted - rows).cwiseAbs().maxCoeff() < 1e-3F * scale);

    CHECK(loaded.metadata.at("method") == method_name(network));
    CHECK(loaded.metadata.at("template_sha256") == "tube");
    CHECK(loaded.metadata.at("licences") == "a licence");
    CHECK(loaded.metadata.at("joint_names").size() == poses[0].parent_from_joint.size());
}

TEST_CASE("TorchScript that cannot be written leaves nothing behind")
{
    const Synthetic s = make_synthetic(12, 4);
    NeuralModel model = s.model(small_network());
    CHECK_THROWS_AS(write_torchscript("/nonexistent/model.pt", model, {}), Error);
}
