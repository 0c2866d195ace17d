// SPDX-License-Identifier: Apache-2.0
// How the anatomy follows from body to body: the template's embedding against a warp by radial basis functions
// (Komaritzan et al. 2021; NDG supplement 3). Without --template: a tube.
#include "ndg/body/embedding.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/wraps/bone_interior.h"
#include "report.h"
#include "support/support.h"

#include <Eigen/LU>

#include <fmt/format.h>

#include <ctime>
#include <functional>
#include <limits>

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

/// Interpolates displacements at the centres by the kernel r^3 and an affine map.
class RbfWarp {
public:
    RbfWarp(const Points& from, const Points& to) : centres_(from)
    {
        const Eigen::Index n = from.rows();
        Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + 4, n + 4);
        for (Eigen::Index i = 0; i < n; ++i) {
            system.col(i).head(n) = (from.rowwise() - from.row(i)).rowwise().norm().array().cube();
            system(n, i) = system(i, n) = 1.0;
        }
        system.block(n + 1, 0, 3, n) = from.transpose();
        system.block(0, n + 1, n, 3) = from;
        Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n + 4, 3);
        right.topRows(n) = to - from;
        coefficients_ = system.partialPivLu().solve(right);
    }
    Points apply(const Points& points) const
    {
        const Eigen::Index n = centres_.rows();
        Points result(points.rows(), 3);
        for (Eigen::Index v = 0; v < points.rows(); ++v) {
            const Eigen::VectorXd kernel = (centres_.rowwise() - points.row(v)).rowwise().norm().array().cube();
            result.row(v) = points.row(v) + kernel.transpose() * coefficients_.topRows(n) + coefficients_.row(n) +
                            points.row(v) * coefficients_.bottomRows(3);
        }
        return result;
    }

private:
    Points centres_;
    Eigen::MatrixXd coefficients_;
};

/// Vertices that lay inside a wrap of the template and lie outside of it in the body.
struct Escapes {
    long inside = 0, escaped = 0;
    double worst = 0.0;  ///< m

    std::string text() const
    {
        return fmt::format("{:.3f} % {:.2f} mm",
                           inside > 0 ? 100.0 * static_cast<double>(escaped) / static_cast<double>(inside) : 0.0,
                           1e3 * worst);
    }
};

class Wrap {
public:
    Wrap(const Points& wrap, const Triangles& triangles)
        : closed_(close_bone_wrap(wrap, triangles)), tree_(closed_.vertices, closed_.triangles)
    {
    }
    double depth(const Eigen::Vector3d& point) const { return -tree_.signed_distance(point); }

private:
    ClosedBoneWrap closed_;
    TriangleTree tree_;
};

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench_anatomy_transfer", "How the anatomy follows to other bodies: embedding or RBF warp.",
              "bench_anatomy_transfer --template template.h5 --bodies bodies.h5 --output anatomy_transfer.json");
    std::string template_path, bodies_path, output;
    int num_bodies = 3, stride = 10, few = 600, many = 5000;
    tool.input("template", template_path, "template; without it a tube", false);
    tool.input("bodies", bodies_path, "its bodies", false);
    tool.output("output", output, "JSON file to write", false);
    tool.parameter("count", num_bodies, "bodies to measure, spread over the file", 1, 1000);
    tool.parameter("stride", stride, "every so many anatomy vertices are checked", 1, 10000);
    tool.parameter("few-centres", few, "of the coarse warp", 10, 20000);
    tool.parameter("many-centres", many, "of the fine warp", 10, 20000);
    return tool.run(argc, argv, [&] {
        const Template t = template_path.empty() ? test::tube_template(9, 12) : read_template(template_path);
        std::vector<Body> bodies;
        if (bodies_path.empty()) {
            bodies = {t.rest};
            for (Points* points : {&bodies[0].volume_vertices, &bodies[0].interior_vertices})
                points->leftCols<1>() *= 1.3;
        } else {
            const BodySet set = read_bodies(bodies_path, t);
            const auto last = static_cast<int>(set.bodies.size());
            for (int i = 0; i < std::min(num_bodies, last); ++i)
                bodies.push_back(set.bodies[i * last / std::min(num_bodies, last)]);
        }
        const int num_wrap = t.num_wrap_vertices();
        const auto wrap_of = [&](const Body& body, int layer) {
            return Wrap(body.volume_vertices.middleRows(layer * num_wrap, num_wrap), t.wrap_triangles);
        };
        // Which checked vertices are held by which wrap of the template: bones by 0, muscles by 1.
        struct Checked {
            Eigen::Index vertex;
            int layer;
        };
        std::vector<Checked> checked;
        const Wrap template_wraps[2] = {wrap_of(t.rest, 0), wrap_of(t.rest, 1)};
        for (const AnatomyPart& part : t.anatomy_parts)
            for (int v = part.vertex_begin; v < part.vertex_end; v += stride) {
                const int layer = part.layer == AnatomyLayer::bone ? 0 : 1;
                if (t.embedding.elements[v] < 0) continue;
                if (template_wraps[layer].depth(t.anatomy_vertices.row(v).transpose()) > 0.0)
                    checked.push_back({v, layer});
            }
        const std::vector<int> order = farthest_points(t.rest.volume_vertices, many);
        const auto centres_of = [&](const Points& volume, int count) {
            const auto rows = std::min<Eigen::Index>(count, static_cast<Eigen::Index>(order.size()));
            Points result(rows, 3);
            for (Eigen::Index i = 0; i < rows; ++i) result.row(i) = volume.row(order[i]);
            return result;
        };
        fmt::print("{:<22}{:>12}{:>26}{:>28}\n", "", "core-s/body", "bones out of bone wrap",
                   "muscles out of muscle wrap");
        bench::Report report("anatomy_transfer");
        for (const int centres : {0, few, many}) {
            Escapes escapes[2];
            double seconds = 0.0;
            for (const Body& body : bodies) {
                Points anatomy;
                seconds += seconds_of([&] {
                    anatomy = centres == 0 ? apply_embedding(t.embedding, body.volume_vertices, body.interior_vertices)
                                           : RbfWarp(centres_of(t.rest.volume_vertices, centres),
                                                     centres_of(body.volume_vertices, centres))
                                                 .apply(t.anatomy_vertices);
                });
                const Wrap wraps[2] = {wrap_of(body, 0), wrap_of(body, 1)};
                for (const Checked& c : checked) {
                    Escapes& e = escapes[c.layer];
                    const double depth = wraps[c.layer].depth(anatomy.row(c.vertex).transpose());
                    ++e.inside;
                    e.escaped += depth < -1e-6;
                    e.worst = std::max(e.worst, -depth);
                }
            }
            seconds /= static_cast<double>(bodies.size());
            const std::string name = centres == 0 ? "embedding" : fmt::format("RBF {} centres", centres);
            fmt::print("{:<22}{:>12.3f}{:>26}{:>28}\n", name, seconds, escapes[0].text(), escapes[1].text());
            const std::string key = centres == 0 ? "embedding" : centres == few ? "rbf_few" : "rbf_many";
            report.add(key + "_core_seconds", seconds);
            report.add(key + "_worst_bone_mm", 1e3 * escapes[0].worst);
            report.add(key + "_worst_muscle_mm", 1e3 * escapes[1].worst);
        }
        report.print();
        if (!output.empty()) report.write(output);
    });
}
