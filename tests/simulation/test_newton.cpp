// SPDX-License-Identifier: Apache-2.0
// Newton's method on an energy it has never heard of.
#include "ndg/elastic/layered_body.h"
#include "ndg/simulation/local_relaxation.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <map>

using namespace ndg;

namespace {

/// Springs of no length from vertices to points.
class PointSprings : public EnergyTerm {
public:
    PointSprings(const std::map<int, Eigen::Vector3d>& points, double newton_per_metre, int num_vertices)
        : EnergyTerm(stencils_of(points, num_vertices)), stiffness_(newton_per_metre)
    {
        for (const auto& [vertex, point] : points) points_.push_back(point);
    }

    void set_rest(const Eigen::Ref<const Points>&) override {}
    void add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const override
    {
        for (int i = 0; i < places.size(); ++i) {
            sum.parts[i % sum.parts.size()] += 0.5 * stiffness_ * pull(positions, places.element(i)).squaredNorm();
        }
    }
    void add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const override
    {
        for (int i = 0; i < places.size(); ++i) {
            const Eigen::Vector3d force = stiffness_ * pull(positions, places.element(i));
            sum.add<1>(places.unknown(i), force.data());
        }
    }
    void add_hessian(const Points&, const ElementPlaces& places, HessianKind, HessianSum& sum) const override
    {
        const Eigen::Matrix3d block = stiffness_ * Eigen::Matrix3d::Identity();
        for (int i = 0; i < places.size(); ++i) sum.add<1>(places, i, block.data());
    }

private:
    static Stencils stencils_of(const std::map<int, Eigen::Vector3d>& points, int num_vertices)
    {
        std::vector<int> vertices;
        for (const auto& [vertex, point] : points) vertices.push_back(vertex);
        return Stencils(1, vertices, num_vertices);
    }
    Eigen::Vector3d pull(const Points& positions, int element) const
    {
        return positions.row(stencils().corners(element)[0]).transpose() - points_[element];
    }

    double stiffness_;
    std::vector<Eigen::Vector3d> points_;
};

}  // namespace

TEST_CASE("Springs to points are one more term: alone they end at the points, on flesh they balance it")
{
    const Template tube = test::tube_template(6, 8);
    const Points& rest = tube.rest.volume_vertices;
    const int num_vertices = tube.num_volume_vertices(), first_skin = 2 * tube.num_wrap_vertices();
    std::map<int, Eigen::Vector3d> points;
    for (const int v : {first_skin + 3, first_skin + 4, num_vertices - 2}) {
        points[v] = rest.row(v).transpose() + Eigen::Vector3d(0.01, -0.02, 0.03);
    }
    NewtonOptions options;
    options.relative_tolerance = 1e-9;

    ElasticBody springs(num_vertices, tube.num_wrap_vertices());
    springs.add(std::make_unique<PointSprings>(points, 200, num_vertices));
    std::vector<int> vertices;
    for (const auto& [v, point] : points) vertices.push_back(v);
    const Objective alone(springs, vertices);
    Points x = rest;
    const NewtonResult result = NewtonSolver(alone).minimise(x, options);
    REQUIRE(result.converged());
    REQUIRE(result.start_energy_joule == Approx(3 * 0.5 * 200 * 0.0014));
    for (const auto& [v, point] : points) REQUIRE((x.row(v).transpose() - point).norm() < 1e-6);
    for (int v = 0; v < num_vertices; ++v) REQUIRE((points.count(v) == 1 || x.row(v) == rest.row(v)));

    ElasticBody pulled = layered_body(tube, MaterialOptions{});
    pulled.add(std::make_unique<PointSprings>(points, 200, num_vertices));
    const Objective objective(pulled);
    LocalRelaxation relaxation(objective);
    x = rest;
    REQUIRE(NewtonSolver(objective)
                .minimise(x, options,
                          [&](Points& positions, const Eigen::VectorXd& gradient) {
                              return relaxation.relax(positions, gradient);
                          })
                .converged());
    // What the springs pull with is what the flesh alone resists with.
    const ElasticBody flesh = layered_body(tube, MaterialOptions{});
    Eigen::VectorXd resistance, absolute;
    Objective(flesh).gradient(x, resistance, absolute);
    for (int v = tube.num_wrap_vertices(); v < num_vertices; ++v) {
        Eigen::Vector3d spring = Eigen::Vector3d::Zero();
        if (points.count(v) == 1) {
            spring = 200 * (x.row(v).transpose() - points[v]);
            REQUIRE(spring.norm() > 0.1);
            REQUIRE((x.row(v) - rest.row(v)).norm() > 1e-3);
        }
        REQUIRE((resistance.segment<3>(3 * (v - tube.num_wrap_vertices())) + spring).norm() < 1e-6);
    }
}
