// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/fit_statistical_body.h"

#include "ndg/avatar/soft_region.h"
#include "ndg/core/error.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

namespace ndg {

namespace {

constexpr double local_reach = 2.5;
constexpr std::size_t least_local = 32;
/// Of the bodies, every so many is left out to see how well a regressor does on others.
constexpr std::size_t held_out_every = 5;

std::vector<int> local_vertices(const Points& vertices, const Eigen::RowVector3d& joint)
{
    std::vector<std::pair<double, int>> order;
    for (Eigen::Index v = 0; v < vertices.rows(); ++v) order.emplace_back((vertices.row(v) - joint).norm(), int(v));
    std::sort(order.begin(), order.end());
    std::vector<int> local;
    for (const auto& [distance, v] : order) {
        if (local.size() >= least_local && distance > local_reach * order.front().first) break;
        local.push_back(v);
    }
    std::sort(local.begin(), local.end());
    return local;
}

std::vector<int> soft_flags(const Template& body_template)
{
    const auto sorted = [](Eigen::Vector3i corners) {
        std::sort(corners.data(), corners.data() + 3);
        return std::array<int, 3>{corners[0], corners[1], corners[2]};
    };
    std::set<std::array<int, 3>> soft;
    for (Eigen::Index t = 0; t < body_template.wrap_triangles.rows(); ++t) {
        Eigen::Vector3i corners;
        for (int c = 0; c < 3; ++c) corners[c] = body_template.wrap_to_skin[body_template.wrap_triangles(t, c)];
        soft.insert(sorted(corners));
    }
    std::vector<int> flags;
    for (Eigen::Index t = 0; t < body_template.skin_triangles.rows(); ++t)
        flags.push_back(int(soft.count(sorted(body_template.skin_triangles.row(t).transpose()))));
    const auto found = std::count(flags.begin(), flags.end(), 1);
    require(found == body_template.wrap_triangles.rows(), "{} of {} triangles of the wraps are triangles of the skin",
            found, body_template.wrap_triangles.rows());
    return flags;
}

/// 9 P x 3 N of the whole skin.
RowMatrixF skin_directions(const Template& body_template, const LinearCorrectives& correctives,
                           const std::vector<int>& soft_triangles, const Points& skin, double fade)
{
    const SoftRegion region = soft_region(skin, body_template.skin_triangles, soft_triangles);
    const int num_wrap = body_template.num_wrap_vertices();
    RowMatrixF directions = RowMatrixF::Zero(correctives.blend_shapes.rows(), 3 * skin.rows());
    for (int w = 0; w < num_wrap; ++w) {
        const int v = body_template.wrap_to_skin[w];
        const int number = region.region_of_skin[v];
        if (number < 0) continue;
        const double t = fade > 0 ? std::min(region.rim_distances[number] / fade, 1.0) : 1.0;
        const auto share = float(t * t * (3 - 2 * t));
        // Free vertices: muscle wrap, then skin.
        directions.middleCols<3>(3 * v) = share * correctives.blend_shapes.middleCols<3>(3 * (num_wrap + w));
    }
    return directions;
}

double largest_distance(const Points& a, const Points& b, double& mean)
{
    const Eigen::VectorXd distances = (a - b).rowwise().norm();
    mean = distances.mean();
    return distances.maxCoeff();
}

}  // namespace

void describe(OptionList& list, StatisticalBodyOptions& options)
{
    list.add("shape-directions", options.shape_directions, "most shape directions kept; 0: all of the shape space", 0,
             100000);
    list.add("regressor-ridge", options.regressor_ridge,
             "weight of squared entries of the joint regressor beside squared distances of joints, m^2", 1e-12, 1);
    list.add("pose-fade", options.pose_fade,
             "distance from head, hands and toes over which pose directions grow from zero, m", 0, 1);
}

JointWeights fit_joint_regressor(const Skin& rest, const std::vector<const Skin*>& skins, double ridge)
{
    require_input(!skins.empty(), "a joint regressor needs at least one body");
    const Eigen::Index k = rest.joint_positions.rows(), n = rest.skin_vertices.rows();
    const auto rows = 3 * Eigen::Index(skins.size());
    std::vector<Eigen::Triplet<double>> entries;
    for (Eigen::Index j = 0; j < k; ++j) {
        const std::vector<int> local = local_vertices(rest.skin_vertices, rest.joint_positions.row(j));
        const auto m = Eigen::Index(local.size());
        // About the mean of the local vertices: what weights of sum one give does not depend on the origin, and the
        // rows sum to zero, so that the least solution changes no sum.
        Eigen::MatrixXd positions(rows, m);
        Eigen::VectorXd joints(rows);
        for (std::size_t b = 0; b < skins.size(); ++b) {
            require(skins[b]->skin_vertices.rows() == n && skins[b]->joint_positions.rows() == k,
                    "body {} has {} skin vertices and {} joints, the template {} and {}", b,
                    skins[b]->skin_vertices.rows(), skins[b]->joint_positions.rows(), n, k);
            Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
            for (const int v : local) centre += skins[b]->skin_vertices.row(v) / double(m);
            for (Eigen::Index i = 0; i < m; ++i)
                positions.col(i).segment<3>(3 * Eigen::Index(b)) =
                    (skins[b]->skin_vertices.row(local[std::size_t(i)]) - centre).transpose();
            joints.segment<3>(3 * Eigen::Index(b)) = (skins[b]->joint_positions.row(j) - centre).transpose();
        }
        Eigen::MatrixXd products = positions * positions.transpose();
        products.diagonal().array() += ridge * double(skins.size());
        const Eigen::VectorXd weights =
            (positions.transpose() * products.llt().solve(joints)).array() + 1.0 / double(m);
        for (Eigen::Index i = 0; i < m; ++i) entries.emplace_back(int(j), local[std::size_t(i)], weights[i]);
    }
    JointWeights regressor(k, n);
    regressor.setFromTriplets(entries.begin(), entries.end());
    return regressor;
}

StatisticalBody fit_statistical_body(const Template& body_template, const BodySet& bodies,
                                     const std::vector<int>& fitted, const ShapeSpace& space,
                                     const LinearCorrectives* correctives, const StatisticalBodyOptions& options,
                                     BodyErrors& errors)
{
    check_options(options);
    require_input(!fitted.empty(), "there is no body to fit a statistical body to");
    require_input(space.mean.size() == 3 * body_template.num_volume_vertices(),
                  "the shape space is of {} volume vertices, the template has {}", space.mean.size() / 3,
                  body_template.num_volume_vertices());
    const auto d = options.shape_directions > 0 ? std::min<Eigen::Index>(options.shape_directions, space.dimension())
                                                : Eigen::Index(space.dimension());
    const Eigen::Index n = body_template.rest.skin_vertices.rows();

    StatisticalBody body;
    body.name = body_template.rest.name;
    body.triangles = body_template.skin_triangles;
    body.skeleton = body_template.skeleton;
    body.weights = sparse_weights(body_template.skin_weights, body.num_joints());
    body.soft_triangles = soft_flags(body_template);

    // Regression of skins on codes, with a constant.
    body.people_shapes.resize(Eigen::Index(bodies.bodies.size()), d);
    for (std::size_t b = 0; b < bodies.bodies.size(); ++b) {
        const Eigen::VectorXd code = space.encode(bodies.bodies[b].volume_vertices);
        body.people.push_back(bodies.bodies[b].name);
        body.people_shapes.row(Eigen::Index(b)) =
            code.head(d).cwiseQuotient(space.standard_deviations.head(d)).transpose();
    }
    const auto count = Eigen::Index(fitted.size());
    require_input(count > d, "{} bodies do not determine {} shape directions and their mean", count, d);
    Eigen::MatrixXd shapes(count, d + 1);
    RowMatrix skins(count, 3 * n);
    std::vector<const Skin*> regressed, seen, unseen;
    for (Eigen::Index i = 0; i < count; ++i) {
        const Body& person = bodies.bodies[std::size_t(fitted[std::size_t(i)])];
        shapes.row(i) << body.people_shapes.row(fitted[std::size_t(i)]), 1.0;
        skins.row(i) = Eigen::Map<const Eigen::RowVectorXd>(person.skin_vertices.data(), 3 * n);
        regressed.push_back(&person);
        (std::size_t(i) % held_out_every == held_out_every - 1 ? unseen : seen).push_back(&person);
    }
    const Eigen::MatrixXd solution = shapes.colPivHouseholderQr().solve(Eigen::MatrixXd(skins));
    body.shape_directions = solution.topRows(d).cast<float>();
    const Eigen::RowVectorXd mean = solution.row(d);
    body.vertices = Eigen::Map<const Points>(mean.data(), n, 3);
    body.joint_regressor = fit_joint_regressor(body_template.rest, regressed, options.regressor_ridge);

    if (correctives != nullptr) {
        body.pose_joints = correctives->joints;
        body.pose_directions =
            skin_directions(body_template, *correctives, body.soft_triangles, body.vertices, options.pose_fade);
    }

    const auto count_joints = [&](const JointWeights& regressor, const std::vector<const Skin*>& list, double& mean_of,
                                  double& largest) {
        for (const Skin* skin : list) {
            double one_mean = 0;
            largest = std::max(
                largest, largest_distance(Points(regressor * skin->skin_vertices), skin->joint_positions, one_mean));
            mean_of += one_mean / double(list.size());
        }
    };
    count_joints(body.joint_regressor, regressed, errors.mean_joint, errors.largest_joint);
    if (!unseen.empty())
        count_joints(fit_joint_regressor(body_template.rest, seen, options.regressor_ridge), unseen,
                     errors.mean_held_out, errors.largest_held_out);
    for (const int b : fitted) {
        double one_mean = 0;
        const Points skin = body.rest_vertices(body.people_shapes.row(b).transpose());
        errors.largest_skin = std::max(errors.largest_skin,
                                       largest_distance(skin, bodies.bodies[std::size_t(b)].skin_vertices, one_mean));
        errors.mean_skin += one_mean / double(count);
    }
    return body;
}

}  // namespace ndg
