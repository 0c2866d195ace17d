// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/skin_lanes.h"

#include <cmath>

namespace ndg {

namespace {

/// Local vertices of the left and the right triangle.
constexpr std::array<std::array<std::size_t, 3>, 2> corners{{{0, 1, 2}, {0, 1, 3}}};
/// Weights of the edge vector x1 - x0 on a triangle's vertices.
constexpr std::array<double, 3> along{-1, 1, 0};

}  // namespace

SkinLanes::SkinLanes(const Points& positions, const ElementBatch<SkinEdgeRest>& batch)
    : rests_(batch.rests), x_(gather_corners<4>(positions, batch.corners))
{
    edge_ = x_[1] - x_[0];
    length_ = sqrt(dot(edge_, edge_));
    direction_ = (1.0 / length_) * edge_;
    rest_length_ = gather_lanes(rests_, [](const Rest* rest) { return rest->length; });
    stretch_stiffness_ = gather_lanes(rests_, [](const Rest* rest) { return rest->stretch_stiffness; });
    bend_weight_ = gather_lanes(rests_, [](const Rest* rest) { return rest->bend.weight; });
    const Lanes left_area = gather_lanes(rests_, [](const Rest* rest) { return rest->bend.left_area; });
    const Lanes right_area = gather_lanes(rests_, [](const Rest* rest) { return rest->bend.right_area; });
    left_ = make_wing(x_[2] - x_[0], 1, left_area);
    right_ = make_wing(x_[3] - x_[0], -1, right_area);
    // As dihedral_angle().
    const Lanes sine = dot(cross(left_.area_vector, right_.area_vector), edge_) / length_;
    const Lanes cosine = dot(left_.area_vector, right_.area_vector);
    constexpr double pi = 3.14159265358979323846;
    difference_ = 0.0;
    for (std::size_t i = 0; i < num_lanes; ++i) {
        if (fading_[i]) continue;
        const double angle = std::atan2(sine[i], cosine[i]);
        const double difference = (angle > -pi ? angle : pi) - rests_[i]->bend.angle;
        difference_[i] = difference - 2 * pi * std::ceil((difference - pi) / (2 * pi));
    }
}

SkinLanes::Wing SkinLanes::make_wing(const Lanes3& arm, double side, const Lanes& rest_area)
{
    Wing wing;
    wing.area_vector = Lanes(side) * cross(edge_, arm);
    const Lanes squared = dot(wing.area_vector, wing.area_vector);
    const auto fades = 0.25 * squared < bend_fade_share * bend_fade_share * rest_area * rest_area;
    for (std::size_t i = 0; i < num_lanes; ++i) {
        if (!fades[i]) continue;
        fading_[i] = any_fading_ = true;
    }
    const Lanes double_area = sqrt(squared);
    wing.height = double_area / length_;
    wing.normal = (1.0 / double_area) * wing.area_vector;
    wing.slope = (1.0 / wing.height) * wing.normal;
    wing.out = Lanes(side) * cross(wing.normal, direction_);
    const Lanes foot = dot(arm, direction_) / length_;
    wing.weights = {1.0 - foot, foot, -1.0};
    return wing;
}

Hinge SkinLanes::hinge(std::size_t lane) const
{
    const auto vertex = [&](std::size_t a) { return Eigen::Vector3d(x_[a][0][lane], x_[a][1][lane], x_[a][2][lane]); };
    return {vertex(0), vertex(1), vertex(2), vertex(3)};
}

Lanes SkinLanes::energy() const
{
    const Lanes strain = length_ / rest_length_ - 1.0;
    Lanes bend = 0.5 * bend_weight_ * difference_ * difference_;
    for (std::size_t i = 0; any_fading_ && i < num_lanes; ++i) {
        if (fading_[i]) bend[i] = bend_energy(hinge(i), rests_[i]->bend);
    }
    return 0.5 * stretch_stiffness_ * strain * strain + bend;
}

std::array<Lanes3, 4> SkinLanes::angle_gradient() const
{
    return {left_.weights[0] * left_.slope + right_.weights[0] * right_.slope,
            left_.weights[1] * left_.slope + right_.weights[1] * right_.slope, Lanes(-1.0) * left_.slope,
            Lanes(-1.0) * right_.slope};
}

std::tuple<LaneVector<6>, LaneVector<12>> SkinLanes::forces() const
{
    std::tuple<LaneVector<6>, LaneVector<12>> result;
    auto& [stretch, bend] = result;
    const std::array<Lanes3, 4> angle = angle_gradient();
    for (std::size_t a = 0; a < 4; ++a) bend.set3(a, (bend_weight_ * difference_) * angle[a]);
    for (std::size_t i = 0; any_fading_ && i < num_lanes; ++i) {
        if (!fading_[i]) continue;
        const Vector12 gradient = bend_gradient(hinge(i), rests_[i]->bend);
        for (int k = 0; k < 12; ++k) bend.values[num_lanes * k + i] = gradient(k);
    }
    const Lanes3 pull =
        (stretch_stiffness_ * (length_ - rest_length_) / (length_ * rest_length_ * rest_length_)) * edge_;
    stretch.set3(0, Lanes(-1.0) * pull);
    stretch.set3(1, pull);
    return result;
}

// The angle's Hessian is a sum over both wings, each of unit normal m, direction out b, height h and vertex weights a,
// the edge of direction e, length l and vertex weights c = (-1, 1, 0) (from d normal, d height and d foot; the same
// expressions as Tamstorf and Grinspun 2013):
//   a a^T (m b^T + b m^T) / h^2  -  (c a^T m e^T + a c^T e m^T) / (h l)  +  c c^T (m b^T + b m^T) / (2 l^2),
// the first factor over vertices, the second over coordinates.

Lanes SkinLanes::stability() const
{
    // Squared Frobenius norm of the Hessian from inner products of its terms; the vectors of both wings lie in the
    // plane across the edge. All terms with e together have 4 / l^2 |gradient|^2.
    const Lanes mm = dot(left_.normal, right_.normal), mb = dot(left_.normal, right_.out);
    const Lanes bm = dot(left_.out, right_.normal), bb = dot(left_.out, right_.out);
    const auto over_vertices = [](const Wing& p, const Wing& q, double same) {
        return p.weights[0] * q.weights[0] + p.weights[1] * q.weights[1] + same;
    };
    const Lanes left_left = over_vertices(left_, left_, 1), right_right = over_vertices(right_, right_, 1);
    const Lanes left_right = over_vertices(left_, right_, 0);
    const Lanes p = 1.0 / (left_.height * left_.height), q = 1.0 / (right_.height * right_.height);
    const Lanes slopes = 1.0 / (left_.height * right_.height);
    const Lanes squared_gradient = p * left_left + q * right_right + 2.0 * slopes * mm * left_right;
    // <m b^T + b m^T of the left, of the right>; of one with itself it is 2.
    const Lanes between = 2.0 * (mm * bb + mb * bm);
    const Lanes r = 0.5 / (length_ * length_);
    const auto along_edge = [](const Wing& wing) { return wing.weights[1] - wing.weights[0]; };
    const Lanes left_edge = along_edge(left_) * along_edge(left_), right_edge = along_edge(right_) * along_edge(right_);
    const Lanes across = p * p * left_left * left_left * 2.0 + q * q * right_right * right_right * 2.0 +
                         2.0 * p * q * left_right * left_right * between +
                         2.0 * r * (p * left_edge + q * right_edge) * (2.0 + between) +
                         4.0 * r * r * (4.0 + 2.0 * between);
    const Lanes squared = across + 4.0 * squared_gradient / (length_ * length_);
    Lanes stability = -abs(difference_) * sqrt(squared) / squared_gradient;
    for (std::size_t i = 0; any_fading_ && i < num_lanes; ++i) {
        if (fading_[i]) stability[i] = bend_stability(hinge(i), rests_[i]->bend);
    }
    return stability;
}

void SkinLanes::bend_hessian(HingeBlocks& blocks) const
{
    const std::array<Lanes3, 4> angle = angle_gradient();
    std::array<Lanes3, 4> scaled;
    for (std::size_t a = 0; a < 4; ++a) scaled[a] = bend_weight_ * angle[a];
    blocks.add_products<true>(scaled, angle);
    const Lanes moment = bend_weight_ * difference_;
    for (const Wing* wing : {&left_, &right_}) {
        const std::array<std::size_t, 3>& corner = corners[wing == &left_ ? 0 : 1];
        const Lanes edge_share = 0.5 * wing->height * wing->height / (length_ * length_);
        const Lanes3 fold = (moment / wing->height) * wing->slope, slide = (moment / length_) * wing->slope;
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) {
                const Lanes across = fold[i] * wing->out[j] + fold[j] * wing->out[i];
                const Lanes m_e = slide[i] * direction_[j], e_m = slide[j] * direction_[i];
                for (std::size_t a = 0; a < 3; ++a) {
                    for (std::size_t b = 0; b <= a; ++b) {
                        Lanes value = wing->weights[a] * wing->weights[b] * across;
                        if (a < 2) value += along[a] * (along[b] * edge_share * across - wing->weights[b] * m_e);
                        if (b < 2) value -= along[b] * wing->weights[a] * e_m;
                        const std::size_t k = HingeBlocks::at(corner[a], corner[b]) + i + 3 * j;
                        blocks.set(k, blocks.get(k) + value);
                    }
                }
            }
        }
    }
}

template <class Replace>
void SkinLanes::replace_fading(HingeBlocks& blocks, const Replace& replace) const
{
    for (std::size_t i = 0; any_fading_ && i < num_lanes; ++i) {
        if (!fading_[i]) continue;
        blocks.set_lane(i, replace(hinge(i), rests_[i]->bend));
    }
}

void SkinLanes::add_stretch(HingeBlocks& blocks, bool projected) const
{
    // e e^T + (1 - rest / length) (I - e e^T), over the squared rest length.
    const Lanes scale = stretch_stiffness_ / (rest_length_ * rest_length_);
    Lanes across = 1.0 - rest_length_ / length_;
    if (projected) across = max(across, Lanes(0.0));
    for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t i = 0; i < 3; ++i) {
            Lanes value = scale * (1.0 - across) * direction_[i] * direction_[j];
            if (i == j) value += scale * across;
            const std::size_t k = i + 3 * j;
            for (const std::size_t block : {HingeBlocks::at(0, 0), HingeBlocks::at(1, 1)}) {
                blocks.set(block + k, blocks.get(block + k) + value);
            }
            const std::size_t off = HingeBlocks::at(1, 0) + k;
            blocks.set(off, blocks.get(off) - value);
        }
    }
}

void SkinLanes::hessian(HingeBlocks& blocks) const
{
    bend_hessian(blocks);
    replace_fading(blocks, ndg::bend_hessian);
    add_stretch(blocks, false);
}

void SkinLanes::gauss_newton_hessian(HingeBlocks& blocks) const
{
    const std::array<Lanes3, 4> angle = angle_gradient();
    std::array<Lanes3, 4> scaled;
    for (std::size_t a = 0; a < 4; ++a) scaled[a] = bend_weight_ * angle[a];
    blocks.add_products<true>(scaled, angle);
    replace_fading(blocks, bend_gauss_newton_hessian);
    add_stretch(blocks, true);
}

void SkinLanes::projected_hessian(HingeBlocks& blocks) const
{
    bend_hessian(blocks);
    // The Hessian A lives in 8 of 12 dimensions. Over vertices: orthonormal (-1, 1, 0, 0), (1, 1, -1, -1) and
    // (0, 0, 1, -1), scaled; across the edge with all three of them, directions normal and out of the left wing; along
    // it only with those that span the weights of both wings.
    const double root_half = std::sqrt(0.5);
    const Lanes moment = bend_weight_ * difference_;
    std::array<std::array<Lanes, 8>, 8> reduced{};
    std::array<Lanes, 6> gradient{};
    std::array<Lanes3, 2> weights;
    for (std::size_t side = 0; side < 2; ++side) {
        const Wing& wing = side == 0 ? left_ : right_;
        weights[side] = {{(wing.weights[1] - wing.weights[0]) * root_half, 1.0, side == 0 ? -root_half : root_half}};
    }
    const Lanes3 first = (1.0 / sqrt(dot(weights[0], weights[0]))) * weights[0];
    Lanes3 second = weights[1] - dot(weights[1], first) * first;
    second = (1.0 / sqrt(dot(second, second))) * second;
    for (std::size_t side = 0; side < 2; ++side) {
        const Wing& wing = side == 0 ? left_ : right_;
        const Lanes m[2] = {dot(wing.normal, left_.normal), dot(wing.normal, left_.out)};
        const Lanes b[2] = {dot(wing.out, left_.normal), dot(wing.out, left_.out)};
        const Lanes curvature = moment / (wing.height * wing.height);
        const Lanes edge_share = moment / (length_ * length_);
        const Lanes coupling = moment / (root_half * length_ * wing.height);
        for (std::size_t d = 0; d < 2; ++d) {
            for (std::size_t z = 0; z < 3; ++z) gradient[2 * z + d] += weights[side][z] * m[d] / wing.height;
            for (std::size_t e = 0; e < 2; ++e) {
                const Lanes across = m[d] * b[e] + b[d] * m[e];
                for (std::size_t z = 0; z < 3; ++z) {
                    for (std::size_t y = 0; y < 3; ++y) {
                        reduced[2 * z + d][2 * y + e] += curvature * weights[side][z] * weights[side][y] * across;
                    }
                }
                reduced[d][e] += edge_share * across;
            }
            reduced[6][d] -= coupling * m[d] * dot(weights[side], first);
            reduced[7][d] -= coupling * m[d] * dot(weights[side], second);
        }
    }
    for (std::size_t i = 0; i < 6; ++i) {
        for (std::size_t j = 0; j < 6; ++j) reduced[i][j] += bend_weight_ * gradient[i] * gradient[j];
    }
    for (std::size_t d = 0; d < 2; ++d) {
        for (std::size_t k = 6; k < 8; ++k) reduced[d][k] = reduced[k][d];
    }
    // Its positive part is (A + |A|) / 2, and |A| = W S^-1 W^T where W = A V = U S.
    orthogonalise<8>(reduced);
    for (std::size_t k = 0; k < HingeBlocks::at(3, 3) + 9; ++k) blocks.set(k, 0.5 * blocks.get(k));
    std::array<Lanes3, 4> mode, scaled;
    for (const std::array<Lanes, 8>& w : reduced) {
        Lanes size = 0.0;
        for (const Lanes& entry : w) size += entry * entry;
        size = sqrt(size);
        where(size == 0.0, size) = 1.0;
        std::array<Lanes3, 3> part;
        for (std::size_t z = 0; z < 3; ++z) {
            part[z] =
                w[2 * z] * left_.normal + w[2 * z + 1] * left_.out + (w[6] * first[z] + w[7] * second[z]) * direction_;
        }
        const Lanes3 edge = Lanes(root_half) * part[0], both = Lanes(0.5) * part[1], apart = Lanes(root_half) * part[2];
        mode = {both - edge, both + edge, apart - both, Lanes(-1.0) * (apart + both)};
        for (std::size_t a = 0; a < 4; ++a) scaled[a] = (0.5 / size) * mode[a];
        blocks.add_products(scaled, mode);
    }
    replace_fading(blocks, bend_projected_hessian);
    add_stretch(blocks, true);
}

}  // namespace ndg
