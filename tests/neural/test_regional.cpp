// SPDX-License-Identifier: Apache-2.0
// Networks of regions: their gradients, what they see, what they learn, their file.
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/neural/network.h"
#include "ndg/neural/weight_average.h"
#include "synthetic.h"

// libtorch's logging macros share names with Catch2.
#undef CHECK
#include <catch2/catch.hpp>

using namespace ndg;
using namespace ndg::test;
using torch::Tensor;

namespace {

Tensor random_tensor(const std::vector<std::int64_t>& shape, double scale, std::uint64_t index)
{
    Random random(6, "regional", index);
    Tensor tensor = torch::empty(shape);
    for (std::int64_t i = 0; i < tensor.numel(); ++i)
        tensor.data_ptr<float>()[i] = static_cast<float>(scale * random.normal());
    return tensor;
}

/// Two parts with outputs interleaved and an input shared; last layers away from zero.
Network two_parts(bool with_bases)
{
    const std::vector<NetworkColumns> columns = {{{0, 1, 4}, {0, 2, 3, 6}}, {{2, 3, 4}, {1, 4, 5}}};
    std::vector<RowMatrixF> bases;
    if (with_bases)
        for (const auto& [rows, cols] : {std::pair(2, 4), std::pair(3, 3)})
            bases.push_back(TorchNetwork::matrix(random_tensor({rows, cols}, 1.0, 40 + rows)));
    Network network = make_network({8, 6}, 5, 7, columns, bases, 3);
    const torch::NoGradGuard no_grad;
    std::uint64_t index = 0;
    for (const Network::Part& part : network.parts) {
        Tensor weight = part.perceptron.layers.back().weight;
        weight.copy_(random_tensor(weight.sizes().vec(), 0.5, ++index));
    }
    return network;
}

struct KeptGradients : GradientSink {
    explicit KeptGradients(const Network& network)
    {
        for (const Tensor& parameter : network.parameters())
            gradients.push_back(torch::full_like(parameter, 1e9, torch::TensorOptions().requires_grad(false)));
    }
    void take(int parameter, std::int64_t first, std::int64_t count, const float* gradient) override
    {
        std::copy_n(gradient, count, gradients[parameter].data_ptr<float>() + first);
    }
    void take(int parameter, const Tensor& gradient) override { gradients[parameter].copy_(gradient); }

    std::vector<Tensor> gradients;
};

/// Poses of both arms and the spine: the flesh on either side bulges with its own forearm only.
Synthetic two_arms(int num_training, int num_validation)
{
    Synthetic s = two_sided_tube();
    const Skeleton& skeleton = s.tube.skeleton;
    std::vector<Body> bodies = {s.tube.rest, s.tube.rest};
    bodies[1].volume_vertices *= 1.1;
    s.bodies.bodies = bodies;
    s.shape_space = fit_shape_space({&s.bodies.bodies[0].volume_vertices, &s.bodies.bodies[1].volume_vertices}, 1, 1.0);
    DeformationSet set = no_samples(s.tube);
    Random random(8, "two arms");
    for (int i = 0; i < num_training + num_validation; ++i) {
        Pose pose = Pose::rest(skeleton.num_joints());
        const double left = random.uniform(-1, 1), right = random.uniform(-1, 1);
        for (const char* joint : {"spine_2", "left_upper_arm", "right_upper_arm"})
            pose.parent_from_joint[skeleton.joint(joint)] = rotation_about({0, 1, 1}, random.uniform(-0.5, 0.5));
        pose.parent_from_joint[skeleton.joint("left_forearm")] = rotation_about({1, 0, 0}, left);
        pose.parent_from_joint[skeleton.joint("right_forearm")] = rotation_about({1, 0, 0}, right);
        s.poses.poses.push_back(pose);
        const Body& body = s.bodies.bodies[i % 2];
        Points rest = body.volume_vertices;
        for (Eigen::Index v = s.tube.num_wrap_vertices(); v < rest.rows(); ++v)
            rest(v, 2) *= 1.0 + 4 * (rest(v, 0) > 0 ? left * rest(v, 0) : -right * rest(v, 0));
        set.add({i % 2, i}, i < num_training ? "train" : "validation",
                linear_blend_skinning(rest, s.tube.volume_weights(),
                                      forward_kinematics(skeleton, body.joint_positions, pose)));
    }
    s.samples = {set};
    return s;
}

NetworkOptions regional_network(int output_basis)
{
    NetworkOptions options = small_network();
    options.region_reach = 2;
    options.output_basis = output_basis;
    if (output_basis > 0) options.parametrisation = ParametrisationKind::direct;
    return options;
}

/// A matrix a prism that follows from the rotation of the joint that rules it, and from no other.
class OwnJoint : public OutputSpace {
public:
    explicit OwnJoint(const Template& tube) : ruling_(tube.num_prisms())
    {
        for (const BodyRegion& region : find_body_regions(tube.skeleton, tube.prism_weights(), 2))
            for (const int prism : region.elements) ruling_[prism] = region.joint;
    }
    int width() const override { return 9 * static_cast<int>(ruling_.size()); }
    OutputKind kind() const override { return OutputKind::prism_matrices; }
    Points vertices(const PosedBody& posed, RestCache&, const float*) const override { return posed.skinned_volume(); }
    void target(const PosedBody& posed, const RestOperators&, const Eigen::Ref<const PointsF>&,
                float* target) const override
    {
        for (std::size_t p = 0; p < ruling_.size(); ++p) {
            const Eigen::Matrix3d& rotation = posed.pose().parent_from_joint[ruling_[p]];
            const Eigen::Matrix3d matrix = rotation * rotation - Eigen::Matrix3d::Identity();
            for (int k = 0; k < 9; ++k) target[9 * p + k] = static_cast<float>(matrix(k / 3, k % 3));
        }
    }

private:
    std::vector<int> ruling_;
};

NeuralModel trained(const Synthetic& s, const NetworkOptions& options, int epochs = 40, double weight_average = 0,
                    std::shared_ptr<const OutputSpace> space = nullptr)
{
    if (!space) space = make_output_space(s.tube, options);
    NeuralModel model(options, s.shape_space, s.tube, space, 5);
    TrainingOptions training;
    training.epochs = epochs;
    training.learning_rate = 5e-3;
    training.schedule = Schedule::cosine;
    training.weight_average = weight_average;
    train(model, s.set("train", model), s.set("validation", model), training);
    return model;
}

/// Largest change of the predictions of the prisms that `joint` rules when `turned` turns.
double change(const Synthetic& s, const NeuralModel& model, const std::string& joint, const std::string& turned)
{
    Pose pose = s.poses.poses[0];
    const Eigen::VectorXd code = model.input_space().encode(s.bodies.bodies[0]);
    const RowMatrixF before = model.predict({{code, pose}});
    pose.parent_from_joint[s.tube.skeleton.joint(turned)] = rotation_about({1, 2, 3}, 1.0);
    const RowMatrixF difference = model.predict({{code, pose}}) - before;
    double largest = 0;
    for (const BodyRegion& region : find_body_regions(s.tube.skeleton, s.tube.prism_weights(), 2))
        if (region.joint == s.tube.skeleton.joint(joint))
            for (const int prism : region.elements)
                largest = std::max<double>(largest, difference.middleCols(9 * prism, 9).cwiseAbs().maxCoeff());
    return largest;
}

double best_validation_share(const NeuralModel& model)
{
    return model.curve().validation_loss[model.curve().best_epoch - 1] / model.curve().initial_validation_loss;
}

}  // namespace

TEST_CASE("gradients of networks side by side agree with finite differences")
{
    for (const auto& [with_bases, last] : {std::pair(false, LastLayer::outputs), std::pair(true, LastLayer::outputs),
                                           std::pair(true, LastLayer::coefficients)}) {
        CAPTURE(with_bases, int(last));
        Network network = two_parts(with_bases);
        NetworkPass pass(network, Precision::float32, last);
        KeptGradients kept(network);
        const Tensor inputs = random_tensor({11, 5}, 1.0, 10);
        const Tensor outputs = pass.forward(inputs, 0);
        CHECK(outputs.size(1) == (last == LastLayer::outputs ? 7 : 5));
        CHECK(torch::equal(outputs.detach(), network.forward(inputs, last)));
        const Tensor targets = random_tensor(outputs.sizes().vec(), 1.0, 11);
        torch::mse_loss(outputs, targets).backward();
        pass.backward(outputs.grad(), kept);
        const torch::NoGradGuard no_grad;
        const std::vector<Tensor> parameters = network.parameters();
        for (std::size_t i = 0; i < parameters.size(); ++i) {
            const Tensor direction = random_tensor(parameters[i].sizes().vec(), 1.0, 100 + i);
            const Tensor start = parameters[i].clone();
            const double step = 5e-3;
            const auto loss_at = [&](double along) {
                Tensor(parameters[i]).copy_(start + along * direction);
                return torch::mse_loss(network.forward(inputs, last).to(torch::kFloat64), targets.to(torch::kFloat64))
                    .item<double>();
            };
            const double expected = (loss_at(step) - loss_at(-step)) / (2 * step);
            Tensor(parameters[i]).copy_(start);
            const double actual = (kept.gradients[i] * direction).sum().item<double>();
            const double size = kept.gradients[i].norm().item<double>();
            CAPTURE(i, expected, actual, size);
            CHECK(size > 0);
            CHECK(std::abs(actual - expected) < 5e-3 * size);
        }
    }
}

TEST_CASE("a part sees its inputs and gives its outputs, no others")
{
    const Network network = two_parts(false);
    const Tensor inputs = random_tensor({1, 5}, 1.0, 12), before = network.forward(inputs);
    Tensor changed = inputs.clone();
    changed[0][1] += 1.0;  // of the first part alone
    const Tensor moved = (network.forward(changed) - before).abs();
    for (const int output : {0, 2, 3, 6}) CHECK(moved[0][output].item<double>() > 1e-4);
    for (const int output : {1, 4, 5}) CHECK(moved[0][output].item<double>() == 0);
}

TEST_CASE("regional networks learn, each from the joints near it, and with few samples better than one network")
{
    const Synthetic s = two_arms(40, 20);
    const auto space = std::make_shared<OwnJoint>(s.tube);
    for (const int output_basis : {0, 12}) {
        CAPTURE(output_basis);
        const NeuralModel model = trained(s, regional_network(output_basis), 40, 0, space);
        CHECK(best_validation_share(model) < 0.05);
        NetworkOptions whole = regional_network(output_basis);
        whole.region_reach = 0;
        const NeuralModel global = trained(s, whole, 40, 0, space);
        CHECK(best_validation_share(model) < best_validation_share(global));
        // The right forearm is far from the left one's flesh, also for what it learned; the global network sees it.
        CHECK(change(s, model, "left_forearm", "right_forearm") == 0);
        CHECK(change(s, model, "left_forearm", "left_forearm") > 0.01);
        CHECK(change(s, model, "right_forearm", "right_forearm") > 0.01);
        CHECK(change(s, global, "left_forearm", "right_forearm") > 1e-3);
    }
}

TEST_CASE("a saved regional model predicts the same; of other regions it is refused")
{
    const TemporaryFolder folder;
    const Synthetic s = two_arms(24, 8);
    for (const int output_basis : {0, 5}) {
        const NeuralModel model = trained(s, regional_network(output_basis), 3);
        const std::string path = folder.file(fmt::format("model_{}.h5", output_basis));
        model.save(path, Provenance{});
        const NeuralModel loaded = NeuralModel::load(path, s.tube);
        const std::vector<PoseInput> inputs = {s.input(model, 0, 0), s.input(model, 1, 5)};
        CHECK(model.predict(inputs) == loaded.predict(inputs));
        CHECK(loaded.options().region_reach == 2);
        CHECK(loaded.num_parameters() == model.num_parameters());
        CHECK(method_name(loaded.options()).rfind("NDG regional", 0) == 0);
        Synthetic other = s;
        other.tube.prisms.row(0).swap(other.tube.prisms.row(other.tube.num_prisms() / 2 - 1));
        CHECK_THROWS_WITH(NeuralModel::load(path, other.tube), Catch::Contains("does not fit the regions"));
    }
}

TEST_CASE("the average of weights is the exponential one, and forgets the first steps sooner")
{
    Network network = two_parts(false);
    WeightAverage average(network, 0.75);
    const Tensor weight = network.parameters()[0];
    Tensor expected = weight.detach().clone();
    const torch::NoGradGuard no_grad;
    for (int step = 1; step <= 60; ++step) {
        Tensor(weight).copy_(random_tensor(weight.sizes().vec(), 1.0, 200 + step));
        average.update(step);
        const double decay = step < 27 ? step / (step + 9.0) : 0.75;
        expected = decay * expected + (1 - decay) * weight;
    }
    CHECK((average.network().parameters()[0] - expected).abs().max().item<double>() < 1e-5);
    CHECK((average.network().parameters()[0] - weight).abs().max().item<double>() > 0.1);
}

TEST_CASE("the model of a training with an average has the average, and its loss")
{
    const Synthetic s = two_arms(40, 20);
    const NeuralModel plain = trained(s, regional_network(0), 20), averaged = trained(s, regional_network(0), 20, 0.9);
    CHECK(plain.curve().train_loss == averaged.curve().train_loss);  // training goes the same way
    CHECK(plain.curve().validation_loss != averaged.curve().validation_loss);
    const TrainingSet validation = s.set("validation", averaged);
    double sum = 0;
    for (int i = 0; i < validation.size(); ++i) {
        Eigen::RowVectorXf target(validation.width());
        validation.target(i, target.data());
        const SamplePair& pair = validation.pair(i);
        const RowMatrixF prediction = averaged.predict({s.input(averaged, pair.body_idx, pair.pose_idx)});
        sum += (prediction - target).squaredNorm() / target.size();
    }
    CHECK(sum / validation.size() ==
          Approx(averaged.curve().validation_loss[averaged.curve().best_epoch - 1]).epsilon(1e-4));
}
