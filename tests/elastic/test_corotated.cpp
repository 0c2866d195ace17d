// SPDX-License-Identifier: Apache-2.0
#include "derivatives.h"

#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/elastic/corotated_term.h"
#include "ndg/elastic/layered_body.h"
#include "ndg/geometry/rotation.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <Eigen/Eigenvalues>

using namespace ndg;

namespace {

struct Scene {
    Template tube = test::tube_template(3, 5);
    std::vector<Lame> materials = prism_materials(tube, MaterialOptions());
    ElasticBody body{tube.num_volume_vertices(), tube.num_wrap_vertices()};
    CorotatedTerm* term;

    Scene()
    {
        auto made = std::make_unique<CorotatedTerm>(tube.prisms, materials, tube.num_volume_vertices());
        term = made.get();
        body.add(std::move(made));
        body.set_rest(tube.rest.volume_vertices);
    }
    Points moved(double spread) const
    {
        Points x = tube.rest.volume_vertices;
        Random random(12, "moved");
        for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] += spread * random.normal();
        return x;
    }
    std::vector<Eigen::Matrix3d> turns() const
    {
        Random random(13, "turns");
        std::vector<Eigen::Matrix3d> rotations;
        for (int v = 0; v < tube.num_volume_vertices(); ++v)
            rotations.push_back(rotation_of(Eigen::Vector3d(random.normal(), random.normal(), random.normal())));
        return rotations;
    }
};

}  // namespace

TEST_CASE_METHOD(Scene, "The co-rotated energy is that of equation 22 at every corner, in the corner's frame")
{
    CHECK(materials.front().mu == Approx(45e3 / 2.94));
    CHECK(materials.back().lambda == Approx(15e3 * 0.47 / (1.47 * 0.06)));
    const std::vector<Eigen::Matrix3d> rotations = turns();
    term->set_rotations(rotations);
    const Points x = moved(0.005);
    double expected = 0;
    for (int p = 0; p < tube.num_prisms(); ++p) {
        const PrismVertices rest = gather_prism(tube.rest.volume_vertices, tube.prisms, p);
        const Eigen::Matrix3d f = (prism_gradient_operator(rest) * gather_prism(x, tube.prisms, p)).transpose();
        for (int a = 0; a < 6; ++a) {
            const Eigen::Matrix3d local = rotations[tube.prisms(p, a)].transpose() * f;
            const Eigen::Matrix3d strain = 0.5 * (local + local.transpose()) - Eigen::Matrix3d::Identity();
            expected +=
                prism_volume(rest) / 6 *
                (0.5 * materials[p].lambda * std::pow(strain.trace(), 2) + materials[p].mu * (strain * strain).trace());
        }
    }
    const Objective objective(body);
    REQUIRE(expected > 1);
    CHECK(objective.energy(x) == Approx(expected).epsilon(1e-12));
    test::require_derivatives(objective, x);
}

TEST_CASE_METHOD(Scene, "The co-rotated energy is quadratic, definite, and blind to a motion of the whole body")
{
    const Objective objective(body);
    const Points x = moved(0.004), rest = tube.rest.volume_vertices;
    CHECK(objective.energy(rest) < 1e-20);
    const Eigen::MatrixXd hessian = test::hessian_of(objective, x, HessianKind::exact);
    CHECK((hessian - test::hessian_of(objective, rest, HessianKind::projected)).norm() < 1e-12 * hessian.norm());
    CHECK(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(hessian).eigenvalues()[0] > 1e-6 * hessian.norm());

    const double energy = objective.energy(x);
    const Eigen::Matrix3d turn = about_z(2.0) * about_x(-1.2);
    const Points turned = (x * turn.transpose()).rowwise() + Eigen::RowVector3d(0.4, -2, 1);
    CHECK(objective.energy(turned) > 2 * energy);
    term->set_rotations(std::vector<Eigen::Matrix3d>(tube.num_volume_vertices(), turn));
    CHECK(objective.energy(turned) == Approx(energy).epsilon(1e-9));
    CHECK_THROWS_AS(term->set_rotations({turn}), Error);
    Points flat = rest;
    flat.col(1).setZero();
    CHECK_THROWS_AS(body.set_rest(flat), Error);
}
