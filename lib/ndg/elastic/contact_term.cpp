// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/contact_term.h"

#include "ndg/core/error.h"
#include "ndg/elastic/contact_barrier.h"
#include "ndg/elastic/lanes.h"
#include "ndg/elastic/projection.h"
#include "ndg/geometry/triangle_mesh.h"

#include <algorithm>

namespace ndg {

namespace {

using Vector12 = Eigen::Matrix<double, 12, 1>;
using Matrix12 = Eigen::Matrix<double, 12, 12>;

/// Share of the squared product of the edges' lengths at rest below which they count as parallel (Li et al. 2020).
constexpr double parallel_share = 1e-3;
/// Share of a pair's distance at rest that its reach may have.
constexpr double rest_distance_share = 0.5;

/// Whether boxes about the two parts are apart by as much, so that the pair has no energy.
bool far_apart(PairKind kind, const PairCorners& x, double squared_reach)
{
    const int first = kind == PairKind::point_triangle ? 1 : 2;
    const Eigen::RowVector3d gap =
        (x.bottomRows(4 - first).colwise().minCoeff() - x.topRows(first).colwise().maxCoeff())
            .cwiseMax(x.topRows(first).colwise().minCoeff() - x.bottomRows(4 - first).colwise().maxCoeff())
            .cwiseMax(0.0);
    return gap.squaredNorm() >= squared_reach;
}

/// One pair's.
class NearPair {
public:
    NearPair(PairKind kind, const PairCorners& corners, double squared_reach, double parallel_limit)
        : distance_(kind, corners), barrier_(contact_barrier(distance_.squared(), squared_reach))
    {
        if (kind == PairKind::edge_edge && barrier_.energy > 0) fade_ = parallel_fade(corners, parallel_limit);
    }
    bool active() const { return barrier_.energy > 0; }
    double energy() const { return fade_.value * barrier_.energy; }
    Vector12 forces() const
    {
        return fade_.value * barrier_.first * distance_.gradient() + barrier_.energy * fade_.gradient;
    }
    /// That along the line between the nearest points, which the fade of parallel edges only makes smaller.
    ContactForce force(double scale) const
    {
        const double distance = std::sqrt(distance_.squared());
        return {-2 * scale * fade_.value * barrier_.first * distance, distance_.gap() / distance, distance_.weights()};
    }
    Matrix12 hessian() const
    {
        const Vector12 gradient = distance_.gradient();
        const Matrix12 mixed = barrier_.first * gradient * fade_.gradient.transpose();
        return fade_.value *
                   (barrier_.second * gradient * gradient.transpose() + barrier_.first * distance_.hessian()) +
               mixed + mixed.transpose() + barrier_.energy * fade_.hessian;
    }

private:
    PairDistance distance_;
    ContactBarrier barrier_;
    ParallelFade fade_;
};

}  // namespace

void describe(OptionList& list, ContactOptions& options)
{
    list.add("contact", options.contact, "keep skin from passing through skin");
    list.add("contact-distance", options.contact_distance, "distance from which skin repels skin, m", 1e-5, 0.05);
    list.add("contact-stiffness", options.contact_stiffness_pascal, "scale of its pressure, Pa", 1, 1e9);
}

ContactTerm::ContactTerm(const Eigen::Ref<const Triangles>& skin, const ContactOptions& options, int num_vertices)
    : ContactTerm(std::vector<Triangles>{skin}, options, num_vertices)
{
}

ContactTerm::ContactTerm(const std::vector<Triangles>& surfaces, const ContactOptions& options, int num_vertices)
    : EnergyTerm(Stencils(4, {}, num_vertices)),
      surfaces_(surfaces),
      surface_of_(static_cast<std::size_t>(num_vertices), -1),
      options_(options)
{
    for (int s = 0; s < int(surfaces_.size()); ++s) {
        for (const int vertex : surfaces_[s].reshaped()) {
            int& surface = surface_of_.at(vertex);
            require(surface < 0 || surface == s, "vertex {} belongs to two surfaces", vertex);
            surface = s;
        }
    }
}

void ContactTerm::set_rest(const Eigen::Ref<const Points>& rest_vertices)
{
    rest_ = rest_vertices;
    areas_.setZero(rest_.rows());
    for (const Triangles& triangles : surfaces_) {
        const Eigen::VectorXd areas = triangle_areas(rest_, triangles);
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            for (int a = 0; a < 3; ++a) areas_[triangles(t, a)] += areas[t] / 3;
        }
    }
}

double ContactTerm::mean_area() const
{
    return areas_.sum() / static_cast<double>((areas_.array() > 0).count());
}

double ContactTerm::area_of(const SurfacePair& pair) const
{
    const auto& v = pair.vertices;
    if (surface_of_[v[0]] == surface_of_[v[3]]) {
        double area = 0;
        for (const int vertex : v) area += areas_[vertex] / 4;
        return area;
    }
    if (pair.kind == PairKind::point_triangle) {
        return std::min(areas_[v[0]], (areas_[v[1]] + areas_[v[2]] + areas_[v[3]]) / 3);
    }
    return std::min(areas_[v[0]] + areas_[v[1]], areas_[v[2]] + areas_[v[3]]) / 2;
}

void ContactTerm::set_pairs(const std::vector<SurfacePair>& pairs)
{
    std::vector<int> corners;
    pairs_.clear();
    for (const SurfacePair& pair : pairs) {
        const PairCorners rest = pair_corners(rest_, pair.vertices);
        double reach = options_.contact_distance;
        if (surface_of_[pair.vertices[0]] == surface_of_[pair.vertices[3]]) {
            reach = std::min(reach, rest_distance_share * std::sqrt(PairDistance(pair.kind, rest).squared()));
        }
        if (!(reach > 0)) continue;
        pairs_.push_back(
            {pair.kind, reach * reach, options_.contact_stiffness_pascal * area_of(pair) * reach,
             parallel_share * (rest.row(1) - rest.row(0)).squaredNorm() * (rest.row(3) - rest.row(2)).squaredNorm()});
        corners.insert(corners.end(), pair.vertices.begin(), pair.vertices.end());
    }
    set_stencils(Stencils(4, std::move(corners), stencils().num_vertices()));
}

PairCorners ContactTerm::corners_of(const Points& positions, int element) const
{
    PairCorners corners;
    for (int a = 0; a < 4; ++a) corners.row(a) = positions.row(stencils().corners(element)[a]);
    return corners;
}

std::vector<ContactForce> ContactTerm::forces(const Points& positions) const
{
    std::vector<ContactForce> forces(pairs_.size());
    for (int element = 0; element < stencils().size(); ++element) {
        const Pair& pair = pairs_[element];
        const PairCorners corners = corners_of(positions, element);
        if (far_apart(pair.kind, corners, pair.squared_reach)) continue;
        const NearPair near(pair.kind, corners, pair.squared_reach, pair.parallel_limit);
        if (near.active()) forces[element] = near.force(pair.scale);
    }
    return forces;
}

/// work(place, pair, scale) for those within reach.
template <class Work>
void ContactTerm::for_near(const Points& positions, const ElementPlaces& places, const Work& work) const
{
    if (silent_) return;
    for (int place = 0; place < places.size(); ++place) {
        const int element = places.element(place);
        const Pair& pair = pairs_[element];
        const PairCorners corners = corners_of(positions, element);
        if (far_apart(pair.kind, corners, pair.squared_reach)) continue;
        const NearPair near(pair.kind, corners, pair.squared_reach, pair.parallel_limit);
        if (near.active()) work(place, near, pair.scale);
    }
}

void ContactTerm::add_energy(const Points& positions, const ElementPlaces& places, EnergySum& sum) const
{
    for_near(positions, places,
             [&](int, const NearPair& pair, double scale) { sum.parts[0] += scale * pair.energy(); });
}

void ContactTerm::add_forces(const Points& positions, const ElementPlaces& places, ForceSum& sum) const
{
    for_near(positions, places, [&](int place, const NearPair& pair, double scale) {
        const Vector12 forces = scale * pair.forces();
        sum.add<4>(places.unknown(place), forces.data());
    });
}

void ContactTerm::add_hessian(const Points& positions, const ElementPlaces& places, HessianKind kind,
                              HessianSum& sum) const
{
    LaneBlocks<4> blocks;
    for_near(positions, places, [&](int place, const NearPair& pair, double scale) {
        const Matrix12 hessian = scale * pair.hessian();
        blocks.set_lane(0, kind == HessianKind::exact ? hessian : clamp_eigenvalues<12>(hessian));
        sum.add<4, num_lanes>(places, place, blocks.values.data());
    });
}

}  // namespace ndg
