// SPDX-License-Identifier: Apache-2.0
#include "ndg/estimation/estimate_tissue.h"

#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/parallel_for.h"
#include "ndg/estimation/estimation_checkpoint.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <optional>

namespace ndg {

namespace {

/// Damps as much as Gauss and Newton's matrix has on its diagonal: where little is explained yet, its model is poor.
constexpr double start_radius = 1;
/// Tangential over normal modulus where the estimation of both begins: where they are equal, which of them the law
/// takes as the larger one changes, and derivatives have a kink.
constexpr double start_anisotropy = 1.5;

Eigen::VectorXd by_metric(const MotionVariance& variance, VarianceMetric metric)
{
    return metric == VarianceMetric::isotropic ? variance.total() : variance.stacked();
}

RowMatrix by_metric(const TissueVariance& variance, VarianceMetric metric)
{
    if (metric == VarianceMetric::isotropic) return variance.normal_by_parameter + variance.tangent_by_parameter;
    RowMatrix both(2 * variance.normal_by_parameter.rows(), variance.normal_by_parameter.cols());
    both << variance.normal_by_parameter, variance.tangent_by_parameter;
    return both;
}

/// What the statistical body leaves of one sequence.
double skinned_error(const TargetMotion& motion, VarianceMetric metric)
{
    return by_metric(motion.captured, metric).squaredNorm();
}

/// Residuals of all sequences and their Jacobian, at one set of parameters.
struct Evaluation {
    Eigen::VectorXd parameters, residuals;  ///< without the prior
    RowMatrix jacobian;
    std::vector<double> sequence_errors;  ///< over what the statistical body leaves of each
};

class Residuals {
public:
    Residuals(const VarianceProblem& problem, const std::vector<TargetMotion>& motions, StiffnessField field,
              const EstimationOptions& options)
        : problem_(problem), motions_(motions), field_(std::move(field)), options_(options)
    {
        double whole = 0;
        for (const TargetMotion& motion : motions) whole += skinned_error(motion, options.metric());
        require_input(whole > 0, "the captured skin does not move beyond its skinning");
        scale_ = 1 / std::sqrt(whole);
    }

    const StiffnessField& field() const { return field_; }
    int num_simulations() const { return num_simulations_; }
    void count_before(int simulations) { num_simulations_ = simulations; }

    /// The last one is kept: what is asked for again costs nothing. `jacobian`: otherwise it may have no rows. Throws
    /// Error where a motion cannot be simulated.
    const Evaluation& at(const Eigen::VectorXd& parameters, bool jacobian)
    {
        if (last_ && last_->parameters == parameters && (!jacobian || last_->jacobian.rows() > 0)) return *last_;
        last_.reset();
        std::vector<TissueVariance> variances(motions_.size());
        parallel_for(static_cast<int>(motions_.size()), [&](int s) {
            const auto k = static_cast<std::size_t>(s);
            variances[k] = tissue_variance(problem_, motions_[k], field_, parameters, jacobian);
            const auto frames = static_cast<double>(motions_[k].frame_steps.size());
            require(variances[k].num_unconverged_frames <= options_.largest_unconverged * frames,
                    "motion \"{}\": {} of {} frames did not converge", motions_[k].name,
                    variances[k].num_unconverged_frames, frames);
        });
        ++num_simulations_;
        Evaluation evaluation;
        evaluation.parameters = parameters;
        const VarianceMetric metric = options_.metric();
        const Eigen::Index rows = by_metric(motions_[0].captured, metric).size();
        evaluation.residuals.resize(rows * static_cast<Eigen::Index>(motions_.size()));
        if (jacobian) evaluation.jacobian.resize(evaluation.residuals.size(), field_.num_parameters());
        for (std::size_t s = 0; s < motions_.size(); ++s) {
            const Eigen::Index begin = rows * static_cast<Eigen::Index>(s);
            const Eigen::VectorXd difference =
                by_metric(variances[s].variance, metric) - by_metric(motions_[s].captured, metric);
            evaluation.residuals.segment(begin, rows) = scale_ * difference;
            if (jacobian) evaluation.jacobian.middleRows(begin, rows) = scale_ * by_metric(variances[s], metric);
            evaluation.sequence_errors.push_back(difference.squaredNorm() / skinned_error(motions_[s], metric));
        }
        last_ = std::move(evaluation);
        return *last_;
    }

private:
    const VarianceProblem& problem_;
    const std::vector<TargetMotion>& motions_;
    StiffnessField field_;
    const EstimationOptions& options_;
    double scale_ = 1;
    int num_simulations_ = 0;
    std::optional<Evaluation> last_;
};

/// Residuals and prior as Ceres asks for them.
class StiffnessCost : public ceres::CostFunction {
public:
    /// Throws Error where the start cannot be simulated.
    StiffnessCost(Residuals& residuals, const Eigen::VectorXd& start, const Eigen::VectorXd& expected, double prior)
        : residuals_(residuals), expected_(expected), prior_(prior)
    {
        num_values_ = residuals_.at(start, true).residuals.size();
        set_num_residuals(static_cast<int>(num_values_ + expected.size()));
        mutable_parameter_block_sizes()->push_back(static_cast<int>(expected.size()));
    }

    bool Evaluate(double const* const* parameters, double* values, double** jacobians) const override
    {
        const Eigen::Index count = expected_.size();
        const Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXd>(parameters[0], count);
        try {
            const bool wants_jacobian = jacobians != nullptr && jacobians[0] != nullptr;
            const Evaluation& evaluation = residuals_.at(at, wants_jacobian);
            Eigen::Map<Eigen::VectorXd> residuals(values, num_values_ + count);
            residuals << evaluation.residuals, prior_ * (at - expected_);
            if (wants_jacobian) {
                Eigen::Map<RowMatrix> jacobian(jacobians[0], num_values_ + count, count);
                jacobian << evaluation.jacobian, prior_ * RowMatrix::Identity(count, count);
            }
        } catch (const Error& error) {
            log_warning("a trial is given up: {}", error.what());
            return false;
        }
        return true;
    }

private:
    Residuals& residuals_;
    Eigen::VectorXd expected_;
    double prior_;
    Eigen::Index num_values_ = 0;
};

/// Keeps what lowers the cost.
class Recorder : public ceres::IterationCallback {
public:
    /// `keep`: false ends the solve.
    explicit Recorder(const std::function<bool(const ceres::IterationSummary&)>& keep) : keep_(keep) {}
    ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override
    {
        if (summary.iteration > 0 && !summary.step_is_successful) return ceres::SOLVER_CONTINUE;
        return keep_(summary) ? ceres::SOLVER_CONTINUE : ceres::SOLVER_ABORT;
    }

private:
    const std::function<bool(const ceres::IterationSummary&)>& keep_;
};

class Estimation {
public:
    Estimation(const VarianceProblem& problem, const std::vector<TargetMotion>& motions,
               const EstimationOptions& options, const EstimationRun& run)
        : problem_(problem), motions_(motions), options_(options), run_(run), begin_(std::chrono::steady_clock::now())
    {
        if (!run.checkpoint.empty()) before_ = read_checkpoint(run.checkpoint, run.key, run.force);
        if (!before_.empty()) {
            seconds_before_ = before_.back().seconds;
            simulations_ = before_.back().simulations;
        }
    }

    /// One stage from `start`, or from where the checkpoint is; `start` is what the prior expects too.
    Eigen::VectorXd solve(int stage, const RowMatrix& weights, const Eigen::VectorXd& start, double prior)
    {
        std::vector<EstimationIteration> done;
        bool later = false;
        for (const EstimationIteration& iteration : before_) {
            if (iteration.stage == stage) done.push_back(iteration);
            later |= iteration.stage > stage;
        }
        iterations_.insert(iterations_.end(), done.begin(), done.end());
        if (later) return done.back().parameters;
        Residuals residuals(problem_, motions_, {weights, options_.material()}, options_);
        residuals.count_before(simulations_);
        Eigen::VectorXd parameters = done.empty() ? start : done.back().parameters;
        require_input(parameters.size() == start.size(), "{}: holds {} parameters instead of {}", run_.checkpoint,
                      parameters.size(), start.size());
        ceres::Problem::Options problem_options;
        problem_options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
        StiffnessCost cost(residuals, parameters, start, prior);
        ceres::Problem least_squares(problem_options);
        least_squares.AddResidualBlock(&cost, nullptr, parameters.data());
        for (int p = 0; p < static_cast<int>(parameters.size()); ++p) {
            least_squares.SetParameterLowerBound(parameters.data(), p, std::log(options_.least_young_pascal));
            least_squares.SetParameterUpperBound(parameters.data(), p, std::log(options_.largest_young_pascal));
        }
        const int first = done.empty() ? 0 : done.back().iteration;
        bool stopped = false;
        const std::function<bool(const ceres::IterationSummary&)> keep = [&](const ceres::IterationSummary& summary) {
            if (!done.empty() && summary.iteration == 0) return true;  // where the checkpoint was written
            EstimationIteration iteration;
            iteration.stage = stage;
            iteration.iteration = first + summary.iteration;
            iteration.cost = summary.cost;
            iteration.error = residuals.at(parameters, false).residuals.squaredNorm();
            iteration.radius = summary.trust_region_radius;
            iteration.simulations = residuals.num_simulations();
            iteration.seconds = seconds();
            iteration.parameters = parameters;
            iterations_.push_back(iteration);
            if (!run_.checkpoint.empty()) write_checkpoint(run_.checkpoint, run_.key, iterations_);
            if (run_.tell) run_.tell(iteration);
            stopped = run_.stop();
            return !stopped;
        };
        Recorder recorder(keep);
        ceres::Solver::Options solver;
        solver.trust_region_strategy_type = ceres::LEVENBERG_MARQUARDT;
        solver.linear_solver_type = ceres::DENSE_QR;
        // Scales made where a run goes on would be others than those made where it began.
        solver.jacobi_scaling = false;
        solver.initial_trust_region_radius = done.empty() ? start_radius : done.back().radius;
        solver.max_num_iterations = std::max(0, options_.max_iterations - first);
        solver.function_tolerance = options_.cost_tolerance;
        solver.num_threads = 1;
        solver.logging_type = ceres::SILENT;
        solver.update_state_every_iteration = true;
        solver.callbacks.push_back(&recorder);
        ceres::Solver::Summary summary;
        ceres::Solve(solver, &least_squares, &summary);
        if (stopped) throw Interrupted("interrupted; the same command goes on from the last iteration");
        require(summary.IsSolutionUsable(), "stage {} found no estimate: {}", stage, summary.message);
        last_sequence_errors = residuals.at(parameters, false).sequence_errors;
        last_error = residuals.at(parameters, false).residuals.squaredNorm();
        simulations_ = residuals.num_simulations();
        return parameters;
    }

    std::vector<EstimationIteration> take_iterations() { return std::move(iterations_); }
    double error_of_stage(int stage) const
    {
        double error = 1;
        for (const EstimationIteration& iteration : iterations_) {
            if (iteration.stage == stage) error = iteration.error;
        }
        return error;
    }

    std::vector<double> last_sequence_errors;
    double last_error = 1;

private:
    double seconds() const
    {
        return seconds_before_ + std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    }

    const VarianceProblem& problem_;
    const std::vector<TargetMotion>& motions_;
    const EstimationOptions& options_;
    const EstimationRun& run_;
    std::chrono::steady_clock::time_point begin_;
    std::vector<EstimationIteration> before_, iterations_;
    double seconds_before_ = 0;
    int simulations_ = 0;
};

std::vector<double> list_of(const Eigen::VectorXd& values)
{
    return {values.data(), values.data() + values.size()};
}

}  // namespace

TissueMaterial EstimationOptions::material() const
{
    return configuration == EstimationConfiguration::cc ? TissueMaterial::anisotropic : TissueMaterial::isotropic;
}

VarianceMetric EstimationOptions::metric() const
{
    return configuration == EstimationConfiguration::ca ? VarianceMetric::isotropic : VarianceMetric::anisotropic;
}

void describe(OptionList& list, EstimationOptions& options)
{
    list.add("configuration", options.configuration,
             "CA: isotropic material and metric; CB: isotropic material, anisotropic metric; CC: both anisotropic");
    list.add("start-young", options.start_young_pascal, "Young's modulus where the estimation begins, Pa", 1, 1e9);
    list.add("least-young", options.least_young_pascal, "least modulus, Pa", 1, 1e9);
    list.add("largest-young", options.largest_young_pascal, "largest modulus, Pa", 1, 1e9);
    list.add("prior", options.prior,
             "weight of a modulus's distance from the one that fits the whole body, for what no motion shows", 0, 1e3);
    list.add("max-iterations", options.max_iterations, "iterations of each stage", 1, 1000);
    list.add("cost-tolerance", options.cost_tolerance, "a stage ends where an iteration lowers the cost by less", 0, 1);
    list.add("largest-unconverged", options.largest_unconverged, "share of frames that may have failed to converge", 0,
             1);
}

TissueEstimate estimate_tissue(const VarianceProblem& problem, const std::vector<TargetMotion>& motions,
                               const RowMatrix& control_weights, const EstimationOptions& options,
                               const EstimationRun& run)
{
    check_options(options);
    require_input(!motions.empty(), "there is no motion to estimate from");
    require_input(options.least_young_pascal < options.start_young_pascal &&
                      options.start_young_pascal < options.largest_young_pascal,
                  "--start-young {} does not lie between --least-young {} and --largest-young {}",
                  options.start_young_pascal, options.least_young_pascal, options.largest_young_pascal);
    Estimation estimation(problem, motions, options, run);
    const bool isotropic = options.material() == TissueMaterial::isotropic;
    const RowMatrix everywhere = RowMatrix::Ones(control_weights.rows(), 1);
    Eigen::VectorXd start(isotropic ? 1 : 2);
    start.setConstant(std::log(options.start_young_pascal));
    if (!isotropic) start[1] += std::log(start_anisotropy);
    const Eigen::VectorXd uniform = estimation.solve(0, everywhere, start, 0);

    const Eigen::Index points = control_weights.cols();
    Eigen::VectorXd at_points(isotropic ? points : 2 * points);
    at_points.head(points).setConstant(uniform[0]);
    at_points.tail(points).setConstant(uniform[uniform.size() - 1]);
    const Eigen::VectorXd found = estimation.solve(1, control_weights, at_points, options.prior);

    TissueEstimate estimate;
    estimate.uniform_error = estimation.error_of_stage(0);
    estimate.error = estimation.last_error;
    estimate.sequence_errors = estimation.last_sequence_errors;
    for (const TargetMotion& motion : motions) estimate.sequence_names.push_back(motion.name);
    estimate.iterations = estimation.take_iterations();
    const StiffnessField field{control_weights, options.material()};
    estimate.young_normal_pascal = list_of(field.young_normal(found));
    estimate.young_tangent_pascal = list_of(field.young_tangent(found));
    estimate.uniform_normal_pascal = std::exp(uniform[0]);
    estimate.uniform_tangent_pascal = std::exp(uniform[uniform.size() - 1]);
    return estimate;
}

std::vector<double> estimated_errors(const VarianceProblem& problem, const std::vector<TargetMotion>& motions,
                                     const RowMatrix& control_weights, const std::vector<double>& young_normal_pascal,
                                     const std::vector<double>& young_tangent_pascal, VarianceMetric metric)
{
    const auto points = control_weights.cols();
    require(static_cast<Eigen::Index>(young_normal_pascal.size()) == points &&
                static_cast<Eigen::Index>(young_tangent_pascal.size()) == points,
            "{} and {} moduli for {} control points", young_normal_pascal.size(), young_tangent_pascal.size(), points);
    Eigen::VectorXd parameters(2 * points);
    for (Eigen::Index c = 0; c < points; ++c) {
        parameters[c] = std::log(young_normal_pascal[static_cast<std::size_t>(c)]);
        parameters[points + c] = std::log(young_tangent_pascal[static_cast<std::size_t>(c)]);
    }
    const StiffnessField field{control_weights, TissueMaterial::anisotropic};
    std::vector<double> errors(motions.size());
    parallel_for(static_cast<int>(motions.size()), [&](int s) {
        const auto k = static_cast<std::size_t>(s);
        const TissueVariance found = tissue_variance(problem, motions[k], field, parameters, false);
        errors[k] = variance_error(found.variance, motions[k].captured, metric) / skinned_error(motions[k], metric);
    });
    return errors;
}

}  // namespace ndg
