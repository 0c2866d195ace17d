// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/fit_correctives.h"

#include "ndg/core/error.h"
#include "ndg/core/parallel_for.h"
#include "ndg/core/progress.h"

#include <algorithm>
#include <cmath>

namespace ndg {

namespace {

/// Samples whose offsets are held together.
constexpr std::size_t block_size = 64;

std::vector<double> powers_of_ten()
{
    std::vector<double> powers;
    for (int exponent = -8; exponent <= 1; ++exponent) powers.push_back(std::pow(10.0, exponent));
    return powers;
}

/// Sums up the samples listed.
NormalEquations sum_up(const LinearCorrectives& correctives, const BodyPoser& poser, const BodySet& bodies,
                       const PoseSet& poses, const DeformationSet& samples, const std::vector<int>& chosen,
                       Progress& progress)
{
    const RestOffsets at_rest(poser.body_template());
    const Eigen::Index num_features = 9 * Eigen::Index(correctives.joints.size());
    NormalEquations equations(num_features, 3 * at_rest.num_vertices());
    for (std::size_t begin = 0; begin < chosen.size(); begin += block_size) {
        const int count = int(std::min(block_size, chosen.size() - begin));
        RowMatrix features(count, num_features), outputs(count, 3 * at_rest.num_vertices());
        parallel_for(count, [&](int i) {
            const int sample = chosen[begin + i];
            const SamplePair& pair = samples.pairs[sample];
            const PosedBody posed = poser.pose(bodies.bodies[pair.body_idx], poses.poses[pair.pose_idx], pair);
            const std::vector<float> stored = samples.coordinates(sample);
            const Points offsets =
                at_rest.offsets(posed, Eigen::Map<const PointsF>(stored.data(), samples.num_volume_vertices, 3));
            features.row(i) = correctives.features(posed.pose()).cast<double>();
            outputs.row(i) = Eigen::Map<const Eigen::RowVectorXd>(offsets.data(), offsets.size());
        });
        equations.add(features, outputs);
        progress.advance(count);
    }
    return equations;
}

}  // namespace

NormalEquations::NormalEquations(Eigen::Index num_features, Eigen::Index num_outputs)
    : gram_(Eigen::MatrixXd::Zero(num_features, num_features)), cross_(Eigen::MatrixXd::Zero(num_features, num_outputs))
{
}

void NormalEquations::add(const Eigen::Ref<const RowMatrix>& features, const Eigen::Ref<const RowMatrix>& outputs)
{
    require(features.rows() == outputs.rows() && features.cols() == gram_.cols() && outputs.cols() == cross_.cols(),
            "{} x {} features and {} x {} outputs were added to equations of {} and {}", features.rows(),
            features.cols(), outputs.rows(), outputs.cols(), gram_.cols(), cross_.cols());
    gram_.selfadjointView<Eigen::Lower>().rankUpdate(features.transpose());
    cross_.noalias() += features.transpose() * outputs;
    squares_ += outputs.squaredNorm();
    num_samples_ += int(features.rows());
}

Eigen::LLT<Eigen::MatrixXd> NormalEquations::factor(double ridge) const
{
    Eigen::MatrixXd matrix = gram_;
    matrix.diagonal().array() += num_samples_ * ridge;
    Eigen::LLT<Eigen::MatrixXd> factor(matrix);
    if (factor.info() != Eigen::Success)
        throw SolverError(fmt::format("{} samples with a ridge of {} do not determine {} blend shapes", num_samples_,
                                      ridge, gram_.cols()));
    return factor;
}

Eigen::MatrixXd NormalEquations::solve(double ridge) const
{
    return factor(ridge).solve(cross_);
}

double NormalEquations::root_mean(double squares) const
{
    return std::sqrt(std::max(squares, 0.0) / (double(num_samples_) * double(cross_.cols())));
}

std::vector<double> NormalEquations::errors(const NormalEquations& fitted, const std::vector<double>& ridges) const
{
    // B = A^-1 C: |y - f B|^2 = |y|^2 - 2 tr(A^-1 C C_here^T) + tr(A^-1 G_here A^-1 C C^T), without B itself.
    const Eigen::MatrixXd gram = gram_.selfadjointView<Eigen::Lower>();
    const Eigen::MatrixXd mixed = fitted.cross_ * cross_.transpose(), own = fitted.cross_ * fitted.cross_.transpose();
    std::vector<double> errors;
    for (const double ridge : ridges) {
        const Eigen::LLT<Eigen::MatrixXd> factor = fitted.factor(ridge);
        errors.push_back(root_mean(squares_ - 2 * factor.solve(mixed).trace() +
                                   factor.solve(gram).cwiseProduct(factor.solve(own).transpose()).sum()));
    }
    return errors;
}

double NormalEquations::error_without() const
{
    return root_mean(squares_);
}

void describe(OptionList& list, CorrectivesOptions& options)
{
    list.add(
        "ridge", options.ridge,
        "weight of squared blend shapes a sample; 0: the power of ten with the least error on the validation split", 0,
        1e6);
}

CorrectivesFit fit_correctives(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                               const DeformationSet& samples, const CorrectivesOptions& options)
{
    check_options(options);
    CorrectivesFit fit;
    std::vector<int> train, validation;
    const auto converged = samples.statistics.find("converged");
    for (int i = 0; i < samples.size(); ++i) {
        require_pair(samples.pairs[i], bodies.bodies.size(), poses.poses.size());
        const std::string& split = samples.pair_splits[i];
        if (split != "train" && split != "validation") continue;
        if (converged != samples.statistics.end() && converged->second[i] == 0) {
            ++fit.num_unconverged;
        } else {
            (split == "train" ? train : validation).push_back(i);
        }
    }
    require_input(!train.empty(), "the samples hold no converged simulation of the split \"train\"");
    require_input(options.ridge > 0 || !validation.empty(),
                  "the samples hold no converged simulation of the split \"validation\", which --ridge 0 needs");
    fit.num_train = int(train.size());
    fit.num_validation = int(validation.size());

    LinearCorrectives& correctives = fit.correctives;
    correctives.joints = corrective_joints(body_template);
    correctives.posing = samples.posing;
    correctives.template_sha256 = body_template.file_sha256;
    const BodyPoser poser(body_template, samples.posing);
    Progress progress("summing up offsets", train.size() + validation.size());
    const NormalEquations fitted = sum_up(correctives, poser, bodies, poses, samples, train, progress);
    const NormalEquations held_out = sum_up(correctives, poser, bodies, poses, samples, validation, progress);

    std::vector<double> ridges = {options.ridge};
    if (options.ridge == 0) ridges = powers_of_ten();
    const bool validated = fit.num_validation > 0;
    const std::vector<double> errors = (validated ? held_out : fitted).errors(fitted, ridges);
    const auto best = std::min_element(errors.begin(), errors.end());
    correctives.ridge = ridges[best - errors.begin()];
    correctives.blend_shapes = fitted.solve(correctives.ridge).cast<float>();
    fit.train_without = fitted.error_without();
    fit.train_error = fitted.errors(fitted, {correctives.ridge}).front();
    if (validated) {
        fit.validation_without = held_out.error_without();
        fit.validation_error = *best;
    }
    return fit;
}

}  // namespace ndg
