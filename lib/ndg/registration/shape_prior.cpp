// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/shape_prior.h"

#include "ndg/geometry/triangle_mesh.h"
#include "ndg/registration/articulated_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <utility>

namespace ndg {
namespace {

constexpr int max_rows = 3000;
/// Model error along the normal and across it, m: across it vertices slide.
constexpr double normal_deviation = 0.004, tangential_deviation = 0.02;
/// How many independent distances a skin is worth: neighbouring ones err together.
constexpr double effective_rows = 600.0;
/// Components with less than this share of the variance are noise.
constexpr double least_variance = 1e-5;
/// A group of segments is dressed if it lies this far outside in the mean, m, and this many standard deviations of
/// what the rest of the body leaves open, to which a model error of `segment_deviation` (m) is added.
constexpr double least_cover = 0.005, least_deviations = 3.5, segment_deviation = 0.0015;
/// Of a dressed segment, skin that lies farther outside than this is covered, m.
constexpr double cover_limit = 0.003;
constexpr int robust_rounds = 4;

/// What people wear together; each row is tried as a whole.
const std::vector<std::vector<SegmentPair>>& garments()
{
    using S = SegmentPair;
    static const std::vector<std::vector<S>> sets = {
        {S::feet},
        {S::head},
        {S::shins},
        {S::forearms},
        {S::shins, S::feet},
        {S::hips, S::thighs},
        {S::thighs, S::shins},
        {S::hips, S::thighs, S::shins},
        {S::hips, S::thighs, S::shins, S::feet},
        {S::chest, S::belly},
        {S::chest, S::belly, S::upper_arms},
        {S::chest, S::belly, S::hips, S::upper_arms},
        {S::chest, S::belly, S::hips, S::upper_arms, S::forearms},
        {S::chest, S::belly, S::hips, S::upper_arms, S::forearms, S::thighs, S::shins},
        {S::chest, S::belly, S::hips, S::upper_arms, S::forearms, S::thighs, S::shins, S::feet}};
    return sets;
}

std::size_t index(SegmentPair pair)
{
    return static_cast<std::size_t>(pair);
}

}  // namespace

/// Normal equations of the vertices of a pair of segments: unknowns are coefficients, then translation.
struct ShapePrior::Evidence {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd vector;
    Eigen::VectorXd along;  ///< sum of weights times the derivative of the distance along the normal
    double outside = 0.0;   ///< sum of weights times that distance from the mean shape
    double weight = 0.0;
};

ShapePrior::ShapePrior(const SkinnedSurface& skin, const std::vector<JointExample>& examples) : skin_(skin)
{
    if (examples.size() < 3) return;
    for (const SkinSegment segment : skin_segments(skin.weights)) pairs_.push_back(pair_of(segment));
    const Eigen::Index num_skin = skin.vertices.rows(), num_joints = skin.joint_positions.rows();
    const auto count = static_cast<Eigen::Index>(examples.size());
    Eigen::MatrixXd all(3 * (num_skin + num_joints), count);
    for (Eigen::Index e = 0; e < count; ++e) {
        const JointExample& example = examples[e];
        const Eigen::RowVector3d centre = example.skin_vertices.colwise().mean();
        const Points centred_skin = example.skin_vertices.rowwise() - centre;
        const Points centred_joints = example.joint_positions.rowwise() - centre;
        all.col(e) << Eigen::Map<const Eigen::VectorXd>(centred_skin.data(), 3 * num_skin),
            Eigen::Map<const Eigen::VectorXd>(centred_joints.data(), 3 * num_joints);
    }
    mean_ = all.rowwise().mean();
    all.colwise() -= mean_;
    all /= std::sqrt(static_cast<double>(count - 1));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(all.transpose() * all);
    const double total = solver.eigenvalues().sum();
    Eigen::Index kept = 0;
    while (kept < count - 1 && solver.eigenvalues()[count - 1 - kept] > least_variance * total) ++kept;
    modes_ = all * solver.eigenvectors().rightCols(kept);
}

Points ShapePrior::positions(const Eigen::VectorXd& unknowns) const
{
    const Eigen::VectorXd flat = mean_ + modes_ * unknowns.head(modes_.cols());
    Points result = Eigen::Map<const Points>(flat.data(), flat.size() / 3, 3);
    result.rowwise() += unknowns.tail<3>().transpose();
    return result;
}

std::array<ShapePrior::Evidence, num_segment_pairs> ShapePrior::gather(const Eigen::Ref<const Points>& rest_skin,
                                                                       const Points& normals,
                                                                       const Eigen::VectorXd& weights) const
{
    const Eigen::Index size = modes_.cols() + 3;
    std::array<Evidence, num_segment_pairs> result;
    for (Evidence& e : result) {
        e.matrix = Eigen::MatrixXd::Zero(size, size);
        e.vector = e.along = Eigen::VectorXd::Zero(size);
    }
    const Eigen::Index step = std::max<Eigen::Index>(1, rest_skin.rows() / max_rows);
    double sum = 0.0;
    for (Eigen::Index v = 0; v < rest_skin.rows(); v += step) sum += weights[v];
    const double scale = effective_rows / std::max(sum, 1e-300);
    Eigen::MatrixXd derivative(3, size);
    derivative.rightCols<3>().setIdentity();
    for (Eigen::Index v = 0; v < rest_skin.rows(); v += step) {
        if (!(weights[v] > 0)) continue;
        Evidence& e = result[index(pairs_[v])];
        const double weight = scale * weights[v];
        const Eigen::Vector3d normal = normals.row(v).transpose();
        derivative.leftCols(modes_.cols()) = modes_.middleRows<3>(3 * v);
        const Eigen::Vector3d offset = rest_skin.row(v).transpose() - mean_.segment<3>(3 * v);
        const Eigen::VectorXd along = derivative.transpose() * normal;
        const double outside = normal.dot(offset);
        const double across = weight / (tangential_deviation * tangential_deviation);
        const double extra = weight / (normal_deviation * normal_deviation) - across;
        e.matrix.selfadjointView<Eigen::Lower>().rankUpdate(derivative.transpose(), across);
        e.matrix.selfadjointView<Eigen::Lower>().rankUpdate(along, extra);
        e.vector += across * (derivative.transpose() * offset) + (extra * outside) * along;
        e.along += weight * along;
        e.outside += weight * outside;
        e.weight += weight;
    }
    return result;
}

ShapePrior::Explanation ShapePrior::explain(const Eigen::Ref<const Points>& rest_skin,
                                            const Eigen::VectorXd& evidence) const
{
    const Points normals = vertex_normals(rest_skin, skin_.triangles);
    const Eigen::Index num_skin = rest_skin.rows(), size = modes_.cols() + 3;
    const auto solve = [&](const std::array<Evidence, num_segment_pairs>& pairs,
                           const std::array<bool, num_segment_pairs>& left_out, Eigen::VectorXd& unknowns) {
        Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(size, size);
        matrix.bottomRightCorner<3, 3>() *= 1e-6;
        Eigen::VectorXd vector = Eigen::VectorXd::Zero(size);
        for (std::size_t p = 0; p < pairs.size(); ++p) {
            if (left_out[p]) continue;
            matrix += pairs[p].matrix;
            vector += pairs[p].vector;
        }
        Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower> factor(matrix);
        unknowns = factor.solve(vector);
        return factor;
    };

    Explanation result;
    const auto pairs = gather(rest_skin, normals, evidence);
    Eigen::VectorXd unknowns;
    // The garment that stands out most, then the next one beside it.
    for (bool found = true; found;) {
        found = false;
        double most = least_deviations;
        std::array<bool, num_segment_pairs> best = result.dressed;
        for (const std::vector<SegmentPair>& garment : garments()) {
            std::array<bool, num_segment_pairs> left_out = result.dressed;
            for (const SegmentPair pair : garment) left_out[index(pair)] = true;
            const auto factor = solve(pairs, left_out, unknowns);
            Eigen::VectorXd along = Eigen::VectorXd::Zero(size);
            double outside = 0.0, weight = 0.0;
            for (const SegmentPair pair : garment) {
                const Evidence& e = pairs[index(pair)];
                if (result.dressed[index(pair)]) continue;
                along += e.along;
                outside += e.outside - e.along.dot(unknowns);
                weight += e.weight;
            }
            if (!(weight > 0)) continue;
            outside /= weight;
            along /= weight;
            const double variance = along.dot(factor.solve(along)) + segment_deviation * segment_deviation;
            const double deviations = outside / std::sqrt(variance);
            if (outside < least_cover || deviations <= most) continue;
            most = deviations;
            found = true;
            best = result.dressed;
            for (const SegmentPair pair : garment) {
                const Evidence& e = pairs[index(pair)];
                best[index(pair)] |= e.weight > 0 && e.outside - e.along.dot(unknowns) > 0.5 * least_cover * e.weight;
            }
        }
        found = found && best != result.dressed;
        if (found) result.dressed = best;
    }

    // Skin that shows beside the clothes counts.
    solve(pairs, result.dressed, unknowns);
    Points shape = positions(unknowns);
    const std::array<bool, num_segment_pairs> none{};
    const bool any = result.dressed != none;
    for (int round = 0; any && round < robust_rounds; ++round) {
        Eigen::VectorXd weights = evidence;
        for (Eigen::Index v = 0; v < num_skin; ++v) {
            if (!result.dressed[index(pairs_[v])]) continue;
            const double outside = normals.row(v).dot(rest_skin.row(v) - shape.row(v));
            weights[v] *= pairs_[v] == SegmentPair::feet ? 0.0 : geman_mcclure(outside, cover_limit);
        }
        solve(gather(rest_skin, normals, weights), none, unknowns);
        shape = positions(unknowns);
    }
    result.shape = skin_;
    result.shape.vertices = shape.topRows(num_skin);
    result.shape.joint_positions = shape.bottomRows(shape.rows() - num_skin);
    result.outside = (normals.cwiseProduct(rest_skin - result.shape.vertices)).rowwise().sum();
    result.covered.assign(num_skin, 0);
    for (Eigen::Index v = 0; v < num_skin; ++v) {
        result.covered[v] =
            result.dressed[index(pairs_[v])] && (pairs_[v] == SegmentPair::feet || result.outside[v] > cover_limit);
    }
    return result;
}

}  // namespace ndg
