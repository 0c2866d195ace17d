// SPDX-License-Identifier: Apache-2.0
#include "ndg/neural/coefficients.h"

#include "ndg/core/parallel_for.h"

#include <algorithm>

namespace ndg {
namespace {

constexpr int rows_at_once = 32;  ///< of targets, a thread

std::vector<int> output_columns(const Network& network, const Network::Part& part)
{
    std::vector<int> columns(part.perceptron.basis.size(1));
    const torch::Tensor given = part.outputs.defined() ? part.outputs.cpu() : torch::arange(network.num_outputs);
    std::copy_n(given.data_ptr<std::int64_t>(), columns.size(), columns.begin());
    return columns;
}

}  // namespace

Coefficients::Coefficients(const TrainingSet& set, const Augmentation* augmentation, const OutputSpace& output_space,
                           const Network& network)
{
    Eigen::Index num_coefficients = 0;
    for (const Network::Part& part : network.parts) num_coefficients += part.perceptron.num_coefficients();
    squared_norms_.resize(num_coefficients);
    Eigen::Index first = 0;
    for (const Network::Part& part : network.parts) {
        const RowMatrixF basis = TorchNetwork::matrix(part.perceptron.basis);
        squared_norms_.segment(first, basis.rows()) = basis.cast<double>().rowwise().squaredNorm();
        first += basis.rows();
    }
    if (augmentation) num_regions_ = augmentation->num_regions();
    const std::vector<Projection> projections = find_projections(augmentation, network);
    const int num_places = augmentation && augmentation->mirrors() ? 2 * num_regions_ : num_regions_;
    kept_.resize(set.size(), num_places * num_coefficients);
    kept_.setZero();

    Eigen::VectorXd remainders(set.size());
    parallel_for((set.size() + rows_at_once - 1) / rows_at_once, [&](int block) {
        const int begin = block * rows_at_once, count = std::min(rows_at_once, set.size() - begin);
        RowMatrixF outputs(count, output_space.width()), selected;
        std::vector<float> target(output_space.width());
        for (int i = 0; i < count; ++i) {
            set.target(begin + i, target.data());
            output_space.approximate_inverse(target.data(), outputs.row(i).data());
        }
        for (const Projection& projection : projections) {
            selected.resize(count, static_cast<Eigen::Index>(projection.columns.size()));
            for (int i = 0; i < count; ++i)
                for (Eigen::Index k = 0; k < selected.cols(); ++k) selected(i, k) = outputs(i, projection.columns[k]);
            kept_.block(begin, projection.first, count, projection.rows.rows()).noalias() =
                selected * projection.rows.transpose();
        }
        std::vector<float> held(num_coefficients);
        for (int i = 0; i < count; ++i) {
            of_sample(begin + i, {}, held.data());
            const auto coefficients = Eigen::Map<const Eigen::VectorXf>(held.data(), num_coefficients).cast<double>();
            remainders[begin + i] =
                outputs.row(i).cast<double>().squaredNorm() - coefficients.cwiseAbs2().dot(squared_norms_);
        }
    });
    mean_remainder_ = std::max(0.0, remainders.mean());
}

std::vector<Coefficients::Projection> Coefficients::find_projections(const Augmentation* augmentation,
                                                                     const Network& network) const
{
    std::vector<Projection> projections;
    const int num_images = augmentation && augmentation->mirrors() ? 2 : 1;
    for (int image = 0; image < num_images; ++image)
        for (int region = 0; region < num_regions_; ++region) {
            int first = place(region, image == 1) * width();
            int coefficient = 0;
            for (const Network::Part& part : network.parts) {
                const RowMatrixF basis = TorchNetwork::matrix(part.perceptron.basis);
                const std::vector<int> outputs = output_columns(network, part);
                // Row by row onto all columns, and as the change's transpose moves them; most columns are empty.
                Eigen::RowVectorXf whole = Eigen::RowVectorXf::Zero(network.num_outputs), moved = whole;
                const auto move = [&](const auto& values) {
                    for (std::size_t k = 0; k < outputs.size(); ++k) whole[outputs[k]] = values[k];
                    moved = whole;
                    if (augmentation) augmentation->transpose(region, image == 1, whole.data(), moved.data());
                };
                move(Eigen::RowVectorXf::Ones(basis.cols()));
                Projection projection;
                for (Eigen::Index k = 0; k < moved.size(); ++k)
                    if (moved[k] != 0) projection.columns.push_back(static_cast<int>(k));
                projection.first = first;
                projection.rows.resize(basis.rows(), static_cast<Eigen::Index>(projection.columns.size()));
                for (Eigen::Index i = 0; i < basis.rows(); ++i) {
                    move(basis.row(i));
                    const double norm = squared_norms_[coefficient + i];
                    const auto scale = static_cast<float>(norm > 0 ? 1 / norm : 0.0);
                    for (Eigen::Index k = 0; k < projection.rows.cols(); ++k)
                        projection.rows(i, k) = scale * moved[projection.columns[k]];
                }
                first += static_cast<int>(basis.rows());
                coefficient += static_cast<int>(basis.rows());
                if (!projection.columns.empty()) projections.push_back(std::move(projection));
            }
        }
    return projections;
}

void Coefficients::of_sample(int sample_idx, const SampleChange& change, float* coefficients) const
{
    Eigen::Map<Eigen::RowVectorXf> sum(coefficients, width());
    sum.setZero();
    for (int region = 0; region < num_regions_; ++region) {
        const bool from_other = change.other_idx >= 0 && (change.from_other >> region & 1U) != 0;
        const int source = from_other ? change.other_idx : sample_idx;
        sum += kept_.row(source).segment(Eigen::Index(place(region, change.mirrored)) * width(), width());
    }
}

}  // namespace ndg
