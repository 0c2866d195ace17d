// SPDX-License-Identifier: Apache-2.0
// The stiffness of a person's soft tissue from captured motions (Romero et al. 2020, section 5.3).
#pragma once

#include "ndg/core/options.h"
#include "ndg/estimation/tissue_variance.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// To be raised whenever the same inputs and options come to give other estimates.
inline constexpr int estimation_method_version = 1;

/// The paper's: ca: isotropic material and metric. cb: isotropic material, anisotropic metric. cc: both anisotropic.
enum class EstimationConfiguration { ca, cb, cc };
template <>
inline constexpr EnumName<EstimationConfiguration> enum_table<EstimationConfiguration>[] = {
    {EstimationConfiguration::ca, "CA"}, {EstimationConfiguration::cb, "CB"}, {EstimationConfiguration::cc, "CC"}};

struct EstimationOptions {
    EstimationConfiguration configuration = EstimationConfiguration::cc;
    double start_young_pascal = 10e3;  ///< everywhere, where the first stage begins
    double least_young_pascal = 500, largest_young_pascal = 500e3;
    /// How much a modulus that is e times that of the uniform stage costs beside the error, whose unit is what the
    /// statistical body leaves: keeps what no motion shows where it is.
    double prior = 0.02;
    int max_iterations = 15;       ///< of each stage
    double cost_tolerance = 1e-3;  ///< a stage ends where an iteration lowers the cost by a smaller share
    double largest_unconverged =
        0.05;  ///< share of frames with a step that did not converge, above which a trial fails

    TissueMaterial material() const;
    VarianceMetric metric() const;
};
void describe(OptionList& list, EstimationOptions& options);

struct EstimationIteration {
    int stage = 0;               ///< 0: one stiffness for the body, 1: at the control points
    int iteration = 0;           ///< of the stage, 0: where it starts
    double cost = 0;             ///< half of error + prior
    double error = 0;            ///< sum of squares of equation 8, over what the statistical body leaves
    double radius = 0;           ///< of the trust region after it
    int simulations = 0;         ///< of all sequences, so far
    double seconds = 0;          ///< so far, of the run
    Eigen::VectorXd parameters;  ///< logarithms of moduli, Pa
};

struct TissueEstimate {
    std::vector<double> young_normal_pascal, young_tangent_pascal;  ///< at the C control points
    double uniform_normal_pascal = 0, uniform_tangent_pascal = 0;   ///< of the first stage
    std::vector<EstimationIteration> iterations;                    ///< that lowered the cost, and where stages start
    double uniform_error = 0, error = 0;                            ///< shares of the statistical body's error
    std::vector<double> sequence_errors;                            ///< the same of each sequence alone
    std::vector<std::string> sequence_names;
};

/// What a run may do besides: go on from a checkpoint, be stopped.
struct EstimationRun {
    std::string checkpoint;  ///< file that holds iterations as they come; empty: none
    std::string key;         ///< of inputs and options; a checkpoint of another key is refused
    bool force = false;      ///< or, with this, discarded
    std::function<bool()> stop = [] { return false; };          ///< asked after every iteration
    std::function<void(const EstimationIteration&)> tell = {};  ///< of every new iteration
};

/// Levenberg-Marquardt within bounds (Ceres), first one stiffness for the whole body, then from there one at each
/// control point, whose weights (M x C) `control_weights` are. Residuals are differences of motion variances of
/// simulated and captured skin, by the configuration's metric. Sequences are simulated on threads of their own. A run
/// that was stopped goes on from its checkpoint to the same result, bit for bit. Throws Interrupted where `stop` asks
/// for it, InputError for a checkpoint of another run or no sequences, Error where not even the start can be simulated.
TissueEstimate estimate_tissue(const VarianceProblem& problem, const std::vector<TargetMotion>& motions,
                               const RowMatrix& control_weights, const EstimationOptions& options,
                               const EstimationRun& run = {});

/// Of a simulation with these moduli at the control points, over what the statistical body leaves: each sequence's.
std::vector<double> estimated_errors(const VarianceProblem& problem, const std::vector<TargetMotion>& motions,
                                     const RowMatrix& control_weights, const std::vector<double>& young_normal_pascal,
                                     const std::vector<double>& young_tangent_pascal, VarianceMetric metric);

/// JSON with the convergence curve and all figures; and as simulate-dynamics --stiffness-field takes moduli.
std::string estimate_json(const TissueEstimate& estimate, const EstimationOptions& options,
                          const std::vector<std::string>& test_names, const std::vector<double>& test_errors);
std::string stiffness_field_json(const TissueEstimate& estimate);

}  // namespace ndg
