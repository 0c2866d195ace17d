// SPDX-License-Identifier: Apache-2.0
// Frames of the runtime against the same network in double, step by step, and what animate does with it.
#include "ndg/runtime/runtime.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/core/threads.h"
#include "ndg/deform/poisson.h"
#include "ndg/deform/posed_body.h"
#include "support/random_network.h"
#include "support/support.h"

#include <catch2/catch.hpp>
#include <unsupported/Eigen/MatrixFunctions>

#include <algorithm>
#include <cmath>
#include <memory>

using namespace ndg;

namespace {

/// As animate and infer-ndg with reconstruct are asked to agree, m.
constexpr double tolerance = 1e-5;

Eigen::VectorXd forward(const RuntimeDescription& model, const BlockSource& blocks, std::size_t p,
                        const Eigen::RowVectorXf& features)
{
    const RuntimePart& part = model.parts[p];
    Eigen::VectorXd x(part.inputs.size());
    for (std::size_t i = 0; i < part.inputs.size(); ++i) x[Eigen::Index(i)] = double(features[part.inputs[i]]);
    for (std::size_t i = 0; i < part.layers.size(); ++i) {
        const RuntimeLayer& layer = part.layers[i];
        RowMatrixF weights = RowMatrixF::Zero(num_weight_blocks(layer.num_rows) * weight_rows, layer.num_columns);
        Eigen::VectorXf biases = Eigen::VectorXf::Zero(weights.rows());
        for (int b = 0; b < num_weight_blocks(layer.num_rows); ++b)
            blocks(int(p), int(i), b, weights.row(b * weight_rows).data(), biases.data() + b * weight_rows);
        const Eigen::VectorXd all = weights.cast<double>() * x + biases.cast<double>();
        x = all.head(layer.num_rows);
        if (layer.norm_weight.empty()) continue;
        const double mean = x.mean(), variance = (x.array() - mean).square().mean();
        for (Eigen::Index k = 0; k < x.size(); ++k) {
            const double y = (x[k] - mean) / std::sqrt(variance + 1e-5) * double(layer.norm_weight[std::size_t(k)]) +
                             double(layer.norm_bias[std::size_t(k)]);
            x[k] = 0.5 * y * std::erfc(-y / std::sqrt(2.0));
        }
    }
    return x;
}

/// F of all prisms.
Gradients gradients(const Template& tube, const test::RandomNetwork& network, const PosedBody& posed)
{
    const RuntimeDescription model = test::describe_random_network(tube, network);
    const BlockSource blocks = test::random_blocks(model, network);
    const InputSpace space(tube, model.shape_space, network.traits.shape);
    const Eigen::RowVectorXf features = space.features({space.encode(posed.body()), posed.pose()});
    Gradients result(tube.num_prisms(), 9);
    for (std::size_t p = 0; p < model.parts.size(); ++p) {
        const Eigen::VectorXd outputs = forward(model, blocks, p, features);
        for (std::size_t slot = 0; slot < model.parts[p].prisms.size(); ++slot) {
            const int prism = model.parts[p].prisms[slot];
            if (prism < 0) continue;
            Eigen::Matrix3d q;
            for (int e = 0; e < 9; ++e)
                q(e / 3, e % 3) = outputs[Eigen::Index(144 * (slot / group_prisms) + group_prisms * std::size_t(e) +
                                                       slot % group_prisms)];
            const bool direct = network.traits.parametrisation == ParametrisationKind::direct;
            const Eigen::Matrix3d residual =
                direct ? Eigen::Matrix3d(q + Eigen::Matrix3d::Identity()) : Eigen::Matrix3d(q.exp());
            const Eigen::Matrix3d rotation =
                network.traits.rotation ? posed.prism_rotations()[prism] : posed.pose().parent_from_joint[0];
            Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(result.row(prism).data()) = rotation * residual;
        }
    }
    return result;
}

Pose some_pose(double bend)
{
    Pose pose = test::tube_pose(bend);
    pose.parent_from_joint[0] = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 0.5).normalized()).toRotationMatrix();
    pose.parent_from_joint[standard_skeleton().joint("left_upper_arm")] =
        Eigen::AngleAxisd(-0.4, Eigen::Vector3d::UnitX()).toRotationMatrix();
    pose.root_translation = {0.3, 0.9, -0.2};
    return pose;
}

struct Fixture {
    Template tube = test::tube_template(9, 8);
    test::TemporaryFolder folder;
    std::unique_ptr<RuntimeModel> model;

    explicit Fixture(const test::RandomNetwork& network)
    {
        tube.file_sha256 = "tube";
        test::write_random_network(folder.file("model.ndg"), tube, network);
        model = std::make_unique<RuntimeModel>(folder.file("model.ndg"));
    }
};

template <typename A, typename B>
double difference(const A& a, const B& b)
{
    return (a.template cast<double>() - b.template cast<double>()).cwiseAbs().maxCoeff();
}

void check_frames(const test::RandomNetwork& network)
{
    Fixture f(network);
    Body thick = f.tube.rest;
    for (Points* points : {&thick.skin_vertices, &thick.volume_vertices, &thick.interior_vertices})
        *points *= Eigen::Vector3d(1.2, 1.0, 1.1).asDiagonal();
    Runtime runtime(f.tube, *f.model);
    const BodyPoser poser(f.tube, network.traits.posing);
    for (const Body* body : {&f.tube.rest, &thick}) {
        runtime.set_body(*body);
        PoissonReconstruction poisson(RestOperators(f.tube.prisms, body->volume_vertices), f.tube.num_wrap_vertices());
        const Points anatomy_rest = anatomy_at_rest(f.tube, *body);
        for (const double bend : {0.0, 1.1, -0.6}) {
            INFO(body->name << " bent by " << bend);
            runtime.set_pose(some_pose(bend));
            const PosedBody posed = poser.pose(*body, some_pose(bend));
            const Points volume = poisson.reconstruct(gradients(f.tube, network, posed), posed.bone_wrap());
            CHECK(difference(runtime.volume(), volume) < tolerance);
            CHECK(difference(runtime.skin(), posed.display_skin(volume)) < tolerance);
            CHECK(difference(runtime.anatomy(), posed.anatomy(anatomy_rest, volume)) < tolerance);
            // Not trivial: the flesh is not where the rotations alone would leave it.
            CHECK(difference(volume, poisson.reconstruct(posed.prism_rotations(), posed.bone_wrap())) >
                  100 * tolerance);
        }
    }
}

}  // namespace

TEST_CASE("Frames are those of the same network in double")
{
    test::RandomNetwork network;
    network.traits.posing = GENERATE(test::bending, PosingOptions{BoneWrap::rigid});
    check_frames(network);
}

TEST_CASE("So are those of regional networks, fixed bases and ablations")
{
    test::RandomNetwork network;
    network.traits.posing = test::bending;
    SECTION("regional")
    {
        network.num_parts = 3;
        network.widths = {16};
    }
    SECTION("regional with fixed bases")
    {
        network.num_parts = 2;
        network.output_basis = 5;
    }
    SECTION("direct")
    {
        network.traits.parametrisation = ParametrisationKind::direct;
    }
    SECTION("no rotation, no shape")
    {
        network.traits.rotation = false;
        network.traits.shape = false;
    }
    SECTION("no hidden layer")
    {
        network.widths = {};
    }
    check_frames(network);
}

TEST_CASE("Weights of 16 and 8 bits stay near those of 32")
{
    test::RandomNetwork network;
    network.traits.posing = test::bending;
    Fixture exact(network);
    Runtime expected(exact.tube, *exact.model);
    expected.set_body(exact.tube.rest);
    expected.set_pose(some_pose(1.0));
    for (const auto& [storage, bound] :
         {std::pair(WeightStorage::bfloat16, 1e-3), std::pair(WeightStorage::int8, 3e-3)}) {
        network.weights = {storage, WeightStorage::bfloat16};
        Fixture rounded(network);
        Runtime runtime(rounded.tube, *rounded.model);
        runtime.set_body(rounded.tube.rest);
        runtime.set_pose(some_pose(1.0));
        INFO(to_name(storage));
        CHECK(difference(runtime.volume(), expected.volume()) < bound);
        CHECK(difference(runtime.volume(), expected.volume()) > 0);
    }
}

TEST_CASE("Every set of instructions gives the same frames, to 0.01 mm")
{
    for (const WeightKernel& kernel : weight_kernels()) {
        if (!kernel.is_available) continue;
        INFO(kernel.name << " with " << to_name(kernel.storage));
        test::RandomNetwork network;
        network.traits.posing = test::bending;
        network.weights = {kernel.storage, kernel.storage};
        Fixture f(network);
        Runtime fastest(f.tube, *f.model), other(f.tube, *f.model);
        other.network().use(kernel);
        other.forces().use_wide_registers(false);
        for (Runtime* runtime : {&fastest, &other}) {
            runtime->set_body(f.tube.rest);
            runtime->set_pose(some_pose(1.2));
        }
        CHECK(difference(other.volume(), fastest.volume()) < tolerance);
    }
}

TEST_CASE("Frames do not depend on the number of threads, nor on the frames before")
{
    test::RandomNetwork network;
    network.traits.posing = test::bending;
    network.weights = {WeightStorage::int8, WeightStorage::bfloat16};
    Fixture f(network);
    const auto last_of = [&](int threads, const std::vector<double>& bends) {
        set_num_threads(threads);
        Runtime runtime(f.tube, *f.model);
        runtime.set_body(f.tube.rest);
        for (const double bend : bends) runtime.set_pose(some_pose(bend));
        set_num_threads(0);
        return std::pair(PointsF(runtime.skin()), PointsF(runtime.anatomy()));
    };
    const auto expected = last_of(1, {0.8});
    CHECK(last_of(1, {-0.5, 0.8}) == expected);
    CHECK(last_of(3, {0.1, 0.8}) == expected);
}

TEST_CASE("What does not fit is refused")
{
    test::RandomNetwork network;
    network.traits.posing = test::bending;
    Fixture f(network);
    Template other = test::tube_template(9, 8);
    other.file_sha256 = "other";
    CHECK_THROWS_AS(Runtime(other, *f.model), InputError);
    other = test::tube_template(9, 6);
    other.file_sha256 = "tube";
    CHECK_THROWS_AS(Runtime(other, *f.model), InputError);
    Runtime runtime(f.tube, *f.model);
    CHECK_THROWS_AS(runtime.set_pose(some_pose(0)), InputError);
    CHECK_THROWS_AS(runtime.set_body(other.rest), InputError);
    runtime.set_body(f.tube.rest);
    CHECK_THROWS_AS(runtime.set_pose(Pose::rest(3)), InputError);
}
