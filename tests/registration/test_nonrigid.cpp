// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/nonrigid_fit.h"
#include "registration/person.h"

#include <catch2/catch.hpp>

#include <map>

using namespace ndg;

namespace {

/// Octahedron, every triangle split into four `rounds` times, on the unit sphere.
TriangleMesh sphere(int rounds)
{
    TriangleMesh mesh;
    mesh.vertices.resize(6, 3);
    mesh.vertices << 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1;
    mesh.triangles.resize(8, 3);
    mesh.triangles << 0, 2, 4, 2, 1, 4, 1, 3, 4, 3, 0, 4, 2, 0, 5, 1, 2, 5, 3, 1, 5, 0, 3, 5;
    for (int round = 0; round < rounds; ++round) {
        std::map<std::pair<int, int>, int> middles;
        Triangles split(4 * mesh.triangles.rows(), 3);
        const auto middle = [&](int a, int b) {
            const auto [found, is_new] = middles.emplace(std::minmax(a, b), static_cast<int>(mesh.vertices.rows()));
            if (is_new) {
                const Eigen::RowVector3d between = (mesh.vertices.row(a) + mesh.vertices.row(b)).normalized();
                mesh.vertices.conservativeResize(mesh.vertices.rows() + 1, 3);
                mesh.vertices.bottomRows(1) = between;
            }
            return found->second;
        };
        for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
            const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
            const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            split.row(4 * t) << a, ab, ca;
            split.row(4 * t + 1) << ab, b, bc;
            split.row(4 * t + 2) << ca, bc, c;
            split.row(4 * t + 3) << ab, bc, ca;
        }
        mesh.triangles = split;
    }
    return mesh;
}

/// Points and normals of a much finer sphere, scaled along the axes.
ScanTarget ellipsoid_scan(const Eigen::RowVector3d& half_axes)
{
    const TriangleMesh fine = sphere(5);
    Points points = fine.vertices, normals = fine.vertices;
    for (int k = 0; k < 3; ++k) {
        points.col(k) *= half_axes[k];
        normals.col(k) /= half_axes[k];
    }
    normals.rowwise().normalize();
    return {points, normals, 0.3 * half_axes.mean() / 16.0};
}

double largest_ellipsoid_error(const Points& points, const Eigen::RowVector3d& half_axes)
{
    double largest = 0.0;
    for (Eigen::Index v = 0; v < points.rows(); ++v) {
        const Eigen::RowVector3d unit = points.row(v).cwiseQuotient(half_axes);
        largest = std::max(largest, std::abs(unit.norm() - 1.0) * half_axes.minCoeff());
    }
    return largest;
}

}  // namespace

TEST_CASE("a surface takes the shape of the scan, less where it is stiff")
{
    const TriangleMesh mesh = sphere(4);
    const Points reference = 0.3 * mesh.vertices;
    const Eigen::RowVector3d axes(0.32, 0.30, 0.285);
    const ScanTarget scan = ellipsoid_scan(axes);
    const Eigen::VectorXd soft = Eigen::VectorXd::Ones(reference.rows());
    const Points fitted = fit_nonrigid(reference, mesh.triangles, scan, reference, soft, {});
    CHECK(largest_ellipsoid_error(reference, axes) > 0.012);
    CHECK(largest_ellipsoid_error(fitted, axes) < 0.001);
    // Around +x, where the scan stands off by 20 mm, a patch 1e4 times as stiff.
    Eigen::VectorXd stiff = soft;
    for (Eigen::Index v = 0; v < stiff.size(); ++v) {
        if (mesh.vertices(v, 0) > 0.8) stiff[v] = 1e4;
    }
    const Points patched = fit_nonrigid(reference, mesh.triangles, scan, reference, stiff, {});
    // Its Laplacian, turned with it, stays: |L x| of the patch changes less than that of the soft one.
    const Eigen::SparseMatrix<double> laplacian = cotangent_laplacian(reference, mesh.triangles);
    const Eigen::VectorXd before = Eigen::MatrixXd(laplacian * reference).rowwise().norm();
    const auto change = [&](const Points& vertices) {
        const Eigen::VectorXd after = Eigen::MatrixXd(laplacian * vertices).rowwise().norm();
        double sum = 0.0;
        for (Eigen::Index v = 0; v < after.size(); ++v) {
            if (mesh.vertices(v, 0) > 0.9) sum += std::abs(after[v] - before[v]);
        }
        return sum;
    };
    CHECK(change(patched) < 0.3 * change(fitted));
}

TEST_CASE("a rigid motion costs the surface nothing")
{
    const SkinnedSurface& skin = test::template_skin();
    Eigen::Isometry3d motion = Eigen::Isometry3d::Identity();
    motion.rotate(Eigen::AngleAxisd(0.02, Eigen::Vector3d(1, 2, 3).normalized()));
    motion.translation() = Eigen::Vector3d(0.006, -0.004, 0.008);
    const Points moved = (skin.vertices * motion.linear().transpose()).rowwise() + motion.translation().transpose();
    const ScanTarget scan(moved, vertex_normals(moved, skin.triangles), 0.02);
    const Eigen::VectorXd stiffness = stiffness_weights(skin, 1e4, 0.04);
    NonrigidFitOptions options;
    options.iterations = 20;
    const Points fitted = fit_nonrigid(skin.vertices, skin.triangles, scan, skin.vertices, stiffness, options);
    CHECK((moved - skin.vertices).rowwise().norm().mean() > 0.01);
    CHECK((fitted - moved).rowwise().norm().mean() < 0.002);
}

TEST_CASE("neighbourhoods turn as the surface does")
{
    const TriangleMesh mesh = sphere(3);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -1, 0.5).normalized()).toRotationMatrix();
    const auto rotations = neighbourhood_rotations(cotangent_laplacian(mesh.vertices, mesh.triangles), mesh.vertices,
                                                   1.3 * mesh.vertices * turn.transpose());
    for (const Eigen::Matrix3d& rotation : rotations) CHECK((rotation - turn).norm() < 1e-9);
}

TEST_CASE("the regulariser weighs 1e4 at the armpits and more at hands than on the thigh")
{
    const SkinnedSurface& skin = test::template_skin();
    const SkinPlaces places = find_skin_places(skin);
    const Eigen::VectorXd stiffness = stiffness_weights(skin, 1e4, 0.04);
    const auto nearest_to = [&](const Eigen::Vector3d& place) {
        Eigen::Index v = 0;
        (skin.vertices.rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&v);
        return stiffness[v];
    };
    CHECK(nearest_to(places.left_armpit) == Approx(1e4));
    CHECK(nearest_to(places.right_armpit) == Approx(1e4));
    const auto joint = [&](const char* name) -> Eigen::Vector3d {
        return skin.joint_positions.row(standard_skeleton().joint(name)).transpose();
    };
    CHECK(nearest_to(0.5 * (joint("left_thigh") + joint("left_shin"))) == Approx(1.0));
    CHECK(nearest_to(joint("right_middle_2")) == Approx(100.0));
    CHECK(stiffness.minCoeff() >= 1.0);
}
