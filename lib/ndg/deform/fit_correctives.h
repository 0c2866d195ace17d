// SPDX-License-Identifier: Apache-2.0
// Linear correctives by ridge regression on simulated samples.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/core/options.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/deform/linear_correctives.h"

#include <Eigen/Cholesky>

#include <vector>

namespace ndg {

/// The normal equations of y = f B over samples, summed up block by block: no more than a few samples are held.
class NormalEquations {
public:
    NormalEquations(Eigen::Index num_features, Eigen::Index num_outputs);

    /// One sample a row.
    void add(const Eigen::Ref<const RowMatrix>& features, const Eigen::Ref<const RowMatrix>& outputs);
    int num_samples() const { return num_samples_; }

    /// Minimises sum |y - f B|^2 + num_samples ridge |B|^2; features x outputs. Throws SolverError where that leaves B
    /// open.
    Eigen::MatrixXd solve(double ridge) const;
    /// Root mean square of an output over these samples, with the B that `fitted` gives for each of the ridges.
    std::vector<double> errors(const NormalEquations& fitted, const std::vector<double>& ridges) const;
    /// The same with B = 0.
    double error_without() const;

private:
    Eigen::LLT<Eigen::MatrixXd> factor(double ridge) const;
    double root_mean(double squares) const;

    int num_samples_ = 0;
    Eigen::MatrixXd gram_;   ///< f^T f, lower triangle
    Eigen::MatrixXd cross_;  ///< f^T y
    double squares_ = 0;     ///< |y|^2
};

struct CorrectivesOptions {
    /// 0: of ten powers of ten from 1e-8 on, the one with the least error on the validation split.
    double ridge = 0;
};
void describe(OptionList& list, CorrectivesOptions& options);

/// Correctives and how well they fit: root mean square of a coordinate of the offsets, m.
struct CorrectivesFit {
    LinearCorrectives correctives;
    int num_train = 0, num_validation = 0, num_unconverged = 0;
    double train_without = 0, train_error = 0;            ///< of linear blend skinning alone, and with correctives
    double validation_without = 0, validation_error = 0;  ///< 0 where there is no such sample
};

/// Fits to the samples of the train split whose simulation converged (statistic "converged", where the set has it).
/// Throws InputError when a body or pose is not there, when no sample is left, or when the ridge shall be chosen and no
/// sample of the validation split is there.
CorrectivesFit fit_correctives(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                               const DeformationSet& samples, const CorrectivesOptions& options);

}  // namespace ndg
