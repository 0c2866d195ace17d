// SPDX-License-Identifier: Apache-2.0
// How the anatomy follows from body to body, or from rest into poses: the template's embedding against a warp by radial
// basis functions (Komaritzan et al. 2021; NDG supplement 3). Without --template: a tube.
#include "ndg/body/anatomy.h"
#include "ndg/body/embedding.h"
#include "ndg/body/pose_set.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/deform/posed_body.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/winding_tree.h"
#include "ndg/wraps/bone_interior.h"
#include "report.h"
#include "support/support.h"

#include <Eigen/LU>

#include <fmt/format.h>

#include <ctime>
#include <functional>
#include <limits>
#include <optional>

using namespace ndg;

namespace {

double seconds_of(const std::function<void()>& work)
{
    const auto now = [] {
        timespec time{};
        clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    };
    const double start = now();
    work();
    return now() - start;
}

/// Rows of `points`, each the farthest from those before it.
std::vector<int> farthest_points(const Points& points, int count)
{
    std::vector<int> chosen = {0};
    Eigen::VectorXd distance = (points.rowwise() - points.row(0)).rowwise().squaredNorm();
    while (static_cast<int>(chosen.size()) < count) {
        Eigen::Index next = 0;
        if (distance.maxCoeff(&next) <= 0.0) break;
        chosen.push_back(static_cast<int>(next));
        distance = distance.cwiseMin((points.rowwise() - points.row(next)).rowwise().squaredNorm());
    }
    return chosen;
}

/// Interpolates displacements at the centres by the kernel r^3 and an affine map. The matrix is of the centres at rest
/// and factored once a body.
class RbfWarp {
public:
    explicit RbfWarp(const Points& from) : centres_(from)
    {
        const Eigen::Index n = from.rows();
        Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + 4, n + 4);
        for (Eigen::Index i = 0; i < n; ++i) {
            system.col(i).head(n) = (from.rowwise() - from.row(i)).rowwise().norm().array().cube();
            system(n, i) = system(i, n) = 1.0;
        }
        system.block(n + 1, 0, 3, n) = from.transpose();
        system.block(0, n + 1, n, 3) = from;
        factor_.compute(system);
    }
    void fit(const Points& to)
    {
        const Eigen::Index n = centres_.rows();
        Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n + 4, 3);
        right.topRows(n) = to - centres_;
        coefficients_ = factor_.solve(right);
    }
    Points apply(const Points& points) const
    {
        const Eigen::Index n = centres_.rows();
        Points result(points.rows(), 3);
#pragma omp parallel for schedule(static)
        for (Eigen::Index v = 0; v < points.rows(); ++v) {
            const Eigen::VectorXd kernel = (centres_.rowwise() - points.row(v)).rowwise().norm().array().cube();
            result.row(v) = points.row(v) + kernel.transpose() * coefficients_.topRows(n) + coefficients_.row(n) +
                            points.row(v) * coefficients_.bottomRows(3);
        }
        return result;
    }

private:
    Points centres_;
    Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
    Eigen::MatrixXd coefficients_;
};

/// Vertices that lie inside a wrap at rest and outside of it afterwards.
struct Escapes {
    long inside = 0, escaped = 0;
    double worst = 0.0;  ///< m

    void add(std::optional<double> depth)
    {
        if (!depth) return;
        ++inside;
        escaped += *depth < -1e-6;
        worst = std::max(worst, -*depth);
    }
    std::string text() const
    {
        return fmt::format("{:.3f} % {:.2f} mm",
                           inside > 0 ? 100.0 * static_cast<double>(escaped) / static_cast<double>(inside) : 0.0,
                           1e3 * worst);
    }
};

/// A wrap, closed over its cuts. By winding numbers, so that limbs that pass through each other count as inside.
class Wrap {
public:
    Wrap(const Points& wrap, const Triangles& triangles)
        : num_triangles_(static_cast<int>(triangles.rows())),
          closed_(close_bone_wrap(wrap, triangles)),
          tree_(closed_.vertices, closed_.triangles),
          winding_(closed_.vertices, closed_.triangles)
    {
    }
    /// Negative outside, m; nothing where a cap over a cut, which is no part of the wrap, is nearest.
    std::optional<double> depth(const Eigen::Vector3d& point) const
    {
        const ClosestPoint closest = tree_.closest(point);
        if (closest.triangle_idx >= num_triangles_) return std::nullopt;
        return winding_.winding_number(point) > 0.5 ? closest.distance : -closest.distance;
    }

private:
    int num_triangles_;
    ClosedBoneWrap closed_;
    TriangleTree tree_;
    WindingTree winding_;
};

/// A body's rest state, its anatomy there, and a state that the anatomy is to follow to.
struct Case {
    Points rest_volume, rest_anatomy, volume, interior;
};

/// Other bodies in the place of the template's.
std::vector<Case> cases_of_bodies(const Template& t, const std::vector<Body>& bodies)
{
    std::vector<Case> cases;
    for (const Body& body : bodies)
        cases.push_back({t.rest.volume_vertices, t.anatomy_vertices, body.volume_vertices, body.interior_vertices});
    return cases;
}

/// Samples of one file, spread over it: each body at rest, and as a method posed it (NDG supplement 3).
std::vector<Case> cases_of_samples(const Template& t, const std::vector<Body>& bodies, const PoseSet& poses,
                                   const DeformationSet& set, int count)
{
    const BodyPoser poser(t, set.posing);
    std::vector<Case> cases;
    for (int i = 0; i < std::min(count, set.size()); ++i) {
        const int sample = i * set.size() / std::min(count, set.size());
        const SamplePair& pair = set.pairs[sample];
        require_pair(pair, bodies.size(), poses.poses.size());
        const Body& body = bodies[pair.body_idx];
        const PosedBody posed = poser.pose(body, poses.poses[pair.pose_idx], pair);
        cases.push_back({body.volume_vertices, anatomy_at_rest(t, body), set.points(sample), posed.bone_interior()});
    }
    return cases;
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench_anatomy_transfer",
              "How the anatomy follows: embedding or RBF warp, to other bodies or, with --deformations, to posed ones.",
              "bench_anatomy_transfer --template template.h5 --bodies bodies.h5 --output anatomy_transfer.json");
    std::string template_path, bodies_path, poses_path, deformations_path, output;
    int count = 3, stride = 10, few = 600, many = 5000;
    tool.input("template", template_path, "template; without it a tube", false);
    tool.input("bodies", bodies_path, "its bodies", false);
    tool.input("poses", poses_path, "poses of the samples", false);
    tool.input("deformations", deformations_path, "samples of a method (simulate-fem, animate)", false);
    tool.output("output", output, "JSON file to write", false);
    tool.parameter("count", count, "bodies or samples to measure, spread over the file", 1, 1000);
    tool.parameter("stride", stride, "every so many anatomy vertices are checked", 1, 10000);
    tool.parameter("few-centres", few, "of the coarse warp", 10, 20000);
    tool.parameter("many-centres", many, "of the fine warp", 10, 20000);
    return tool.run(argc, argv, [&] {
        const Template t = template_path.empty() ? test::tube_template(9, 12) : read_template(template_path);
        std::vector<Case> cases;
        if (bodies_path.empty()) {
            Body body = t.rest;
            for (Points* points : {&body.volume_vertices, &body.interior_vertices}) points->leftCols<1>() *= 1.3;
            cases = cases_of_bodies(t, {body});
        } else {
            const BodySet set = read_bodies(bodies_path, t);
            if (deformations_path.empty()) {
                const auto all = static_cast<int>(set.bodies.size());
                std::vector<Body> bodies;
                for (int i = 0; i < std::min(count, all); ++i)
                    bodies.push_back(set.bodies[i * all / std::min(count, all)]);
                cases = cases_of_bodies(t, bodies);
            } else {
                require_input(!poses_path.empty(), "--deformations needs --poses");
                cases = cases_of_samples(t, set.bodies, read_poses(poses_path),
                                         open_deformations(deformations_path, t.num_volume_vertices()), count);
            }
        }
        const int num_wrap = t.num_wrap_vertices();
        const auto wrap_of = [&](const Points& volume, int layer) {
            return Wrap(volume.middleRows(layer * num_wrap, num_wrap), t.wrap_triangles);
        };
        const std::vector<int> order = farthest_points(t.rest.volume_vertices, many);
        const auto centres_of = [&](const Points& volume, int centres) {
            const auto rows = std::min<Eigen::Index>(centres, static_cast<Eigen::Index>(order.size()));
            Points result(rows, 3);
            for (Eigen::Index i = 0; i < rows; ++i) result.row(i) = volume.row(order[i]);
            return result;
        };
        fmt::print("{:<18}{:>12}{:>10}{:>12}{:>24}{:>27}{:>21}\n", "core-s", "matrix", "fit", "evaluation",
                   "bones out of bone wrap", "muscles out of muscle wrap", "anatomy out of skin");
        bench::Report report("anatomy_transfer");
        for (const int centres : {0, few, many}) {
            Escapes escapes[3];
            double matrix = 0.0, fit = 0.0, evaluation = 0.0;
            for (const Case& c : cases) {
                Points anatomy;
                if (centres == 0) {
                    evaluation += seconds_of([&] { anatomy = apply_embedding(t.embedding, c.volume, c.interior); });
                } else {
                    std::optional<RbfWarp> warp;
                    matrix += seconds_of([&] { warp.emplace(centres_of(c.rest_volume, centres)); });
                    fit += seconds_of([&] { warp->fit(centres_of(c.volume, centres)); });
                    evaluation += seconds_of([&] { anatomy = warp->apply(c.rest_anatomy); });
                }
                // A vertex is looked at where the wrap holds it at rest: bones by the first, muscles by the second, all
                // by the skin.
                for (int layer = 0; layer < 3; ++layer) {
                    const Wrap rest = wrap_of(c.rest_volume, layer), deformed = wrap_of(c.volume, layer);
                    for (const AnatomyPart& part : t.anatomy_parts) {
                        if (layer < 2 && layer != (part.layer == AnatomyLayer::bone ? 0 : 1)) continue;
                        for (int v = part.vertex_begin; v < part.vertex_end; v += stride)
                            if (t.embedding.elements[v] >= 0 &&
                                rest.depth(c.rest_anatomy.row(v).transpose()).value_or(-1.0) > 0.0)
                                escapes[layer].add(deformed.depth(anatomy.row(v).transpose()));
                    }
                }
            }
            const auto each = 1.0 / static_cast<double>(cases.size());
            const std::string name = centres == 0 ? "embedding" : fmt::format("RBF {} centres", centres);
            fmt::print("{:<18}{:>12.3f}{:>10.4f}{:>12.4f}{:>24}{:>27}{:>21}\n", name, each * matrix, each * fit,
                       each * evaluation, escapes[0].text(), escapes[1].text(), escapes[2].text());
            const std::string key = centres == 0 ? "embedding" : centres == few ? "rbf_few" : "rbf_many";
            report.add(key + "_matrix_core_seconds", each * matrix);
            report.add(key + "_fit_core_seconds", each * fit);
            report.add(key + "_evaluation_core_seconds", each * evaluation);
            report.add(key + "_worst_bone_mm", 1e3 * escapes[0].worst);
            report.add(key + "_worst_muscle_mm", 1e3 * escapes[1].worst);
            report.add(key + "_worst_skin_mm", 1e3 * escapes[2].worst);
        }
        report.print();
        if (!output.empty()) report.write(output);
    });
}
