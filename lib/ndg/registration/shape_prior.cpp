// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/shape_prior.h"

#include "ndg/geometry/triangle_mesh.h"
#include "ndg/registration/articulated_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <optional>
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
/// what bare skin does, to which `segment_deviation` (m) is added for errors of the registration.
constexpr double least_cover = 0.005, least_deviations = 4.0, segment_deviation = 0.0015;
/// Where people differ by more than this, m, they differ in more ways than examples tell: clothes there must stand out
/// by so many deviations, or have a hem.
constexpr double fleshy_deviation = 0.0025, least_fleshy_deviations = 6.0;
/// Examples are explained by the others in this many folds.
constexpr std::size_t num_folds = 4;
/// Of a dressed segment, skin that lies farther outside than this is covered, m.
constexpr double cover_limit = 0.003;
constexpr int robust_rounds = 4;

/// What people wear together; each row is tried as a whole.
const std::vector<std::vector<SegmentPair>>& garments()
{
    using S = SegmentPair;
    static const std::vector<std::vector<S>> sets = {
        {S::feet},
        {S::scalp},
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

namespace {

/// Unknowns from the evidence of the segments that are not left out.
template <typename Pairs, typename Flags>
Eigen::VectorXd solve_unknowns(const Pairs& pairs, const Flags& left_out)
{
    const Eigen::Index size = pairs.front().vector.size();
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Identity(size, size);
    matrix.bottomRightCorner<3, 3>() *= 1e-6;
    Eigen::VectorXd vector = Eigen::VectorXd::Zero(size);
    for (std::size_t p = 0; p < pairs.size(); ++p) {
        if (left_out[p]) continue;
        matrix += pairs[p].matrix;
        vector += pairs[p].vector;
    }
    return Eigen::LDLT<Eigen::MatrixXd, Eigen::Lower>(matrix).solve(vector);
}

/// Mean distance of a garment's segments outside the person that all others tell of, those of `left_out` excepted; none
/// where the scan shows none of it.
template <typename Pairs, typename Flags>
std::optional<double> garment_outside(const Pairs& pairs, const std::vector<SegmentPair>& garment, Flags left_out,
                                      Eigen::VectorXd& unknowns)
{
    const Flags dressed = left_out;
    for (const SegmentPair pair : garment) left_out[index(pair)] = true;
    unknowns = solve_unknowns(pairs, left_out);
    double outside = 0.0, weight = 0.0;
    for (const SegmentPair pair : garment) {
        const auto& e = pairs[index(pair)];
        if (dressed[index(pair)]) continue;
        outside += e.outside - e.along.dot(unknowns);
        weight += e.weight;
    }
    if (!(weight > 0)) return std::nullopt;
    return outside / weight;
}

}  // namespace

ShapePrior::ShapePrior(const SkinnedSurface& skin, const std::vector<JointExample>& examples) : skin_(skin)
{
    if (examples.size() <= 2 * num_folds) return;
    for (const SkinSegment segment : skin_segments(skin.weights)) pairs_.push_back(pair_of(segment));
    const std::vector<char> scalp = scalp_vertices(skin);
    for (std::size_t v = 0; v < pairs_.size(); ++v) {
        if (scalp[v]) pairs_[v] = SegmentPair::scalp;
    }
    learn_deviations(examples);
    components_ = find_components(examples);
}

ShapePrior::Components ShapePrior::find_components(const std::vector<JointExample>& examples)
{
    const auto count = static_cast<Eigen::Index>(examples.size());
    const Eigen::Index skin_size = examples.front().skin_vertices.size();
    const Eigen::Index joint_size = examples.front().joint_positions.size();
    Eigen::MatrixXd all(skin_size + joint_size, count);
    for (Eigen::Index e = 0; e < count; ++e) {
        const JointExample& example = examples[e];
        const Eigen::RowVector3d centre = example.skin_vertices.colwise().mean();
        const Points skin = example.skin_vertices.rowwise() - centre;
        const Points joints = example.joint_positions.rowwise() - centre;
        all.col(e) << Eigen::Map<const Eigen::VectorXd>(skin.data(), skin_size),
            Eigen::Map<const Eigen::VectorXd>(joints.data(), joint_size);
    }
    Components result;
    result.mean = all.rowwise().mean();
    all.colwise() -= result.mean;
    all /= std::sqrt(static_cast<double>(count - 1));
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(all.transpose() * all);
    const double total = solver.eigenvalues().sum();
    Eigen::Index kept = 0;
    while (kept < count - 1 && solver.eigenvalues()[count - 1 - kept] > least_variance * total) ++kept;
    result.modes = all * solver.eigenvectors().rightCols(kept);
    return result;
}

/// How far bare skin lies off what the rest of the body tells: examples explained by others.
void ShapePrior::learn_deviations(const std::vector<JointExample>& examples)
{
    deviations_.assign(garments().size(), 0.0);
    for (std::size_t fold = 0; fold < num_folds; ++fold) {
        std::vector<JointExample> others;
        for (std::size_t e = 0; e < examples.size(); ++e) {
            if (e % num_folds != fold) others.push_back(examples[e]);
        }
        const Components components = find_components(others);
        for (std::size_t e = fold; e < examples.size(); e += num_folds) {
            const Points& skin = examples[e].skin_vertices;
            const PairEvidence pairs =
                gather(components, skin, vertex_normals(skin, skin_.triangles), vertex_areas(skin, skin_.triangles));
            Eigen::VectorXd unknowns;
            for (std::size_t g = 0; g < garments().size(); ++g) {
                const double outside = *garment_outside(pairs, garments()[g], PairFlags{}, unknowns);
                deviations_[g] += outside * outside / static_cast<double>(examples.size());
            }
        }
    }
    for (double& deviation : deviations_) deviation = std::sqrt(deviation);
}

Points ShapePrior::Components::positions(const Eigen::VectorXd& unknowns) const
{
    const Eigen::VectorXd flat = mean + modes * unknowns.head(modes.cols());
    Points result = Eigen::Map<const Points>(flat.data(), flat.size() / 3, 3);
    result.rowwise() += unknowns.tail<3>().transpose();
    return result;
}

ShapePrior::PairEvidence ShapePrior::gather(const Components& components, const Eigen::Ref<const Points>& rest_skin,
                                            const Points& normals, const Eigen::VectorXd& weights) const
{
    const Eigen::Index size = components.modes.cols() + 3;
    PairEvidence result;
    for (Evidence& e : result) {
        e.matrix = Eigen::MatrixXd::Zero(size, size);
        e.vector = e.along = Eigen::VectorXd::Zero(size);
    }
    const Eigen::Index step = std::max<Eigen::Index>(1, rest_skin.rows() / max_rows);
    double sum = 0.0;
    for (Eigen::Index v = 0; v < rest_skin.rows(); v += step) sum += weights[v];
    const double scale = effective_rows / std::max(sum, 1e-300);
    // Four rows a vertex: three of its position, one more along the normal.
    std::array<std::vector<Eigen::Index>, num_segment_pairs> vertices;
    for (Eigen::Index v = 0; v < rest_skin.rows(); v += step) {
        if (weights[v] > 0) vertices[index(pairs_[v])].push_back(v);
    }
    for (std::size_t p = 0; p < result.size(); ++p) {
        Evidence& e = result[p];
        RowMatrix rows(4 * static_cast<Eigen::Index>(vertices[p].size()), size);
        Eigen::VectorXd residuals(rows.rows());
        Eigen::Index row = 0;
        for (const Eigen::Index v : vertices[p]) {
            const double weight = scale * weights[v];
            const double across = weight / (tangential_deviation * tangential_deviation);
            const double extra = weight / (normal_deviation * normal_deviation) - across;
            const Eigen::RowVector3d normal = normals.row(v);
            const Eigen::Vector3d offset = rest_skin.row(v).transpose() - components.mean.segment<3>(3 * v);
            rows.block(row, 0, 3, size - 3) = components.modes.middleRows<3>(3 * v);
            rows.block<3, 3>(row, size - 3).setIdentity();
            const Eigen::RowVectorXd along = normal * rows.middleRows<3>(row);
            const double outside = normal * offset;
            rows.middleRows<3>(row) *= std::sqrt(across);
            rows.row(row + 3) = std::sqrt(extra) * along;
            residuals.segment<4>(row) << std::sqrt(across) * offset, std::sqrt(extra) * outside;
            e.along += weight * along.transpose();
            e.outside += weight * outside;
            e.weight += weight;
            row += 4;
        }
        e.matrix.selfadjointView<Eigen::Lower>().rankUpdate(rows.transpose());
        e.vector = rows.transpose() * residuals;
    }
    return result;
}

ShapePrior::Explanation ShapePrior::explain(const Eigen::Ref<const Points>& rest_skin, const Eigen::VectorXd& evidence,
                                            const HemCover& hems) const
{
    const Points normals = vertex_normals(rest_skin, skin_.triangles);
    const Eigen::Index num_skin = rest_skin.rows();
    Explanation result;
    result.dressed = hems.dressed;
    const PairEvidence pairs = gather(components_, rest_skin, normals, evidence);
    Eigen::VectorXd unknowns;
    // The garment that stands out most, then the next one beside it.
    for (bool found = true; found;) {
        double most = 0.0;
        PairFlags best = result.dressed;
        for (std::size_t g = 0; g < garments().size(); ++g) {
            const auto outside = garment_outside(pairs, garments()[g], result.dressed, unknowns);
            const double deviations = outside.value_or(0.0) / std::hypot(deviations_[g], segment_deviation);
            const double least = deviations_[g] > fleshy_deviation ? least_fleshy_deviations : least_deviations;
            if (!outside || *outside < least_cover || deviations <= std::max(most, least)) continue;
            most = deviations;
            best = result.dressed;
            for (const SegmentPair pair : garments()[g]) {
                const Evidence& e = pairs[index(pair)];
                best[index(pair)] |= e.weight > 0 && e.outside - e.along.dot(unknowns) > 0.5 * least_cover * e.weight;
            }
        }
        found = best != result.dressed;
        result.dressed = best;
    }

    // Skin that shows beside the clothes counts.
    unknowns = solve_unknowns(pairs, result.dressed);
    Points shape = components_.positions(unknowns);
    const bool any = result.dressed != PairFlags{};
    for (int round = 0; any && round < robust_rounds; ++round) {
        Eigen::VectorXd weights = evidence;
        for (Eigen::Index v = 0; v < num_skin; ++v) {
            if (!result.dressed[index(pairs_[v])]) continue;
            const double outside = normals.row(v).dot(rest_skin.row(v) - shape.row(v));
            const bool hidden = pairs_[v] == SegmentPair::feet || hems.covered[v];
            // Under clothes there is room, but none outside them.
            weights[v] *= outside < 0 ? 1.0 : hidden ? 0.0 : geman_mcclure(outside, cover_limit);
        }
        shape = components_.positions(solve_unknowns(gather(components_, rest_skin, normals, weights), PairFlags{}));
    }
    result.shape = skin_;
    result.shape.vertices = shape.topRows(num_skin);
    result.shape.joint_positions = shape.bottomRows(shape.rows() - num_skin);
    result.outside = (normals.cwiseProduct(rest_skin - result.shape.vertices)).rowwise().sum();
    result.covered.assign(num_skin, 0);
    for (Eigen::Index v = 0; v < num_skin; ++v) {
        result.covered[v] = result.dressed[index(pairs_[v])] &&
                            (pairs_[v] == SegmentPair::feet || hems.covered[v] || result.outside[v] > cover_limit);
    }
    return result;
}

}  // namespace ndg
