// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/elastic_system.h"

#include "ndg/core/error.h"
#include "ndg/elastic/flesh_lanes.h"
#include "ndg/elastic/guarded_prism.h"
#include "ndg/elastic/skin_lanes.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <type_traits>

namespace ndg {

namespace {

std::vector<int> all_free_vertices(const ElasticModel& model)
{
    std::vector<int> vertices(static_cast<std::size_t>(model.num_vertices() - model.num_fixed_vertices()));
    std::iota(vertices.begin(), vertices.end(), model.num_fixed_vertices());
    return vertices;
}

/// Elements with at least one of the vertices, ascending.
std::vector<int> elements_at(const std::vector<int>& vertices, const std::vector<std::vector<int>>& around)
{
    std::vector<int> elements;
    for (const int vertex : vertices) {
        const std::vector<int>& here = around[static_cast<std::size_t>(vertex)];
        elements.insert(elements.end(), here.begin(), here.end());
    }
    std::sort(elements.begin(), elements.end());
    elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
    return elements;
}

/// Share of an element's stiffness that its smallest eigenvalue may lie below zero and stay, where most stay.
constexpr double nearly_exact_tolerance = 0.3;

/// Up to num_lanes elements in a row; short batches repeat the last.
template <class Part, class Element>
struct Batch {
    std::array<const Part*, num_lanes> parts;
    std::array<const Element*, num_lanes> elements;
    std::size_t count;
};

template <class Part>
const Part* address(const Part& part)
{
    return &part;
}
template <class Part>
const Part* address(const Part* part)
{
    return part;
}

/// work(batch) for all of `parts`, a vector of parts or of pointers to them.
template <class Parts, class Element, class Work>
void for_batches(const Parts& parts, const std::vector<Element>& elements, const Work& work)
{
    using Part = std::remove_cv_t<std::remove_pointer_t<decltype(address(parts.front()))>>;
    Batch<Part, Element> batch;
    for (std::size_t begin = 0; begin < parts.size(); begin += num_lanes) {
        batch.count = std::min(num_lanes, parts.size() - begin);
        for (std::size_t i = 0; i < num_lanes; ++i) {
            batch.parts[i] = address(parts[begin + std::min(i, batch.count - 1)]);
            batch.elements[i] = &elements[static_cast<std::size_t>(batch.parts[i]->element)];
        }
        work(batch);
    }
}

/// scatter_lane(lane) for the elements of a batch that may stay as they are; the others are put by.
template <class Part, class Element, class ScatterLane>
void sort_out_unstable(const Batch<Part, Element>& batch, const Lanes& stability, std::vector<const Part*>& unstable,
                       const ScatterLane& scatter_lane)
{
    for (std::size_t i = 0; i < batch.count; ++i) {
        if (stability[i] < -nearly_exact_tolerance) {
            unstable.push_back(batch.parts[i]);
        } else {
            scatter_lane(i);
        }
    }
}

/// Adds forces to gradient and their absolute values to absolute.
class ForceSum {
public:
    ForceSum(Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) : gradient_(gradient), absolute_(absolute) {}
    void add(int unknown, int coordinate, double force)
    {
        gradient_[3 * unknown + coordinate] += force;
        absolute_[3 * unknown + coordinate] += std::abs(force);
    }
    template <class Part, std::size_t Size>
    void add_lane(const Part& part, const LaneVector<Size>& forces, std::size_t lane)
    {
        for (std::size_t a = 0; 3 * a < Size; ++a) {
            if (part.unknown[a] < 0) continue;
            for (std::size_t c = 0; c < 3; ++c) {
                add(part.unknown[a], static_cast<int>(c), forces.values[num_lanes * (3 * a + c) + lane]);
            }
        }
    }

private:
    Eigen::VectorXd& gradient_;
    Eigen::VectorXd& absolute_;
};

}  // namespace

ElasticSystem::ElasticSystem(const ElasticModel& model) : ElasticSystem(model, all_free_vertices(model)) {}

ElasticSystem::ElasticSystem(const ElasticModel& model, std::vector<int> vertices)
    : model_(&model), vertices_(std::move(vertices))
{
    require(!vertices_.empty() && std::is_sorted(vertices_.begin(), vertices_.end()) &&
                vertices_.front() >= model.num_fixed_vertices() && vertices_.back() < model.num_vertices(),
            "unknown vertices must be ascending and none of the bone wrap");
    const auto make_parts = [&](const auto& elements, const std::vector<std::vector<int>>& around, auto& parts) {
        for (const int e : elements_at(vertices_, around)) {
            auto& part = parts.emplace_back();
            part.element = e;
            const auto& corners = elements[static_cast<std::size_t>(e)].vertices;
            for (std::size_t a = 0; a < corners.size(); ++a) {
                const auto found = std::lower_bound(vertices_.begin(), vertices_.end(), corners[a]);
                const bool unknown = found != vertices_.end() && *found == corners[a];
                part.unknown[a] = unknown ? static_cast<int>(found - vertices_.begin()) : -1;
            }
        }
    };
    make_parts(model.flesh(), model.flesh_around(), flesh_);
    make_parts(model.skin(), model.skin_around(), skin_);
    make_pattern();
}

double ElasticSystem::energy(const Points& positions) const
{
    Lanes total = 0.0;
    const auto add = [&](const auto& batch, Lanes energy) {
        for (std::size_t i = batch.count; i < num_lanes; ++i) energy[i] = 0;
        total += energy;
    };
    for_batches(flesh_, model_->flesh(), [&](const auto& batch) {
        const FleshLanes flesh(positions, batch.elements);
        Lanes energy = flesh.energy();
        if (model_->guards_volume() && any_of(flesh.volume_shares() < guarded_volume_share)) {
            for (std::size_t i = 0; i < num_lanes; ++i)
                energy[i] += GuardedPrism(positions, *batch.elements[i]).energy();
        }
        add(batch, energy);
    });
    for_batches(skin_, model_->skin(), [&](const auto& batch) {
        add(batch, SkinLanes(positions, batch.elements, model_->stretch_stiffness()).energy());
    });
    return reduce(total);
}

void ElasticSystem::gradient(const Points& positions, Eigen::VectorXd& gradient, Eigen::VectorXd& absolute) const
{
    gradient.setZero(num_unknowns());
    absolute.setZero(num_unknowns());
    ForceSum sum(gradient, absolute);
    for_batches(flesh_, model_->flesh(), [&](const auto& batch) {
        const FleshLanes flesh(positions, batch.elements);
        LaneVector<18> forces;
        flesh.forces(forces);
        for (std::size_t i = 0; i < batch.count; ++i) sum.add_lane(*batch.parts[i], forces, i);
        if (!model_->guards_volume() || none_of(flesh.volume_shares() < guarded_volume_share)) return;
        for (std::size_t i = 0; i < batch.count; ++i) {
            const GuardedPrism guarded(positions, *batch.elements[i]);
            if (!guarded.active()) continue;
            const PrismVertices extra = guarded.forces();
            for (int k = 0; k < 18; ++k) {
                const int unknown = batch.parts[i]->unknown[static_cast<std::size_t>(k / 3)];
                if (unknown >= 0) sum.add(unknown, k % 3, extra(k / 3, k % 3));
            }
        }
    });
    for_batches(skin_, model_->skin(), [&](const auto& batch) {
        const SkinLanes skin(positions, batch.elements, model_->stretch_stiffness());
        LaneVector<12> bend;
        LaneVector<6> stretch;
        skin.bend_forces(bend);
        const Lanes3 pull = skin.pull();
        stretch.set3(0, Lanes(-1.0) * pull);
        stretch.set3(1, pull);
        for (std::size_t i = 0; i < batch.count; ++i) {
            sum.add_lane(*batch.parts[i], stretch, i);
            sum.add_lane(*batch.parts[i], bend, i);
        }
    });
}

void ElasticSystem::make_pattern()
{
    // Later neighbours of every vertex with repetitions, one vertex after the other, then sorted and made unique.
    std::vector<int> end(vertices_.size() + 1, 0);
    const auto for_pairs = [&](const auto& visit) {
        const auto visit_parts = [&](const auto& parts) {
            for (const auto& part : parts) {
                for (const int column : part.unknown) {
                    if (column < 0) continue;
                    for (const int row : part.unknown) {
                        if (row > column) visit(static_cast<std::size_t>(column), row);
                    }
                }
            }
        };
        visit_parts(flesh_);
        visit_parts(skin_);
    };
    for_pairs([&](std::size_t column, int) { ++end[column + 1]; });
    for (std::size_t v = 0; v < vertices_.size(); ++v) end[v + 1] += end[v] + 1;
    std::vector<int> rows(static_cast<std::size_t>(end.back()));
    for (std::size_t v = 0; v < vertices_.size(); ++v) rows[static_cast<std::size_t>(end[v]++)] = static_cast<int>(v);
    for_pairs([&](std::size_t column, int row) { rows[static_cast<std::size_t>(end[column]++)] = row; });
    block_rows_.reserve(rows.size());
    block_begin_.push_back(0);
    auto first = rows.begin();
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        const auto last = rows.begin() + end[v];
        std::sort(first, last);
        block_rows_.insert(block_rows_.end(), first, std::unique(first, last));
        block_begin_.push_back(static_cast<int>(block_rows_.size()));
        first = last;
    }
    for (Part<6>& part : flesh_) find_places(part);
    for (Part<4>& part : skin_) find_places(part);
}

template <std::size_t Size>
void ElasticSystem::find_places(Part<Size>& part) const
{
    part.place.fill(-1);
    for (std::size_t a = 0; a < Size; ++a) {
        if (part.unknown[a] < 0) continue;
        const auto vertex = static_cast<std::size_t>(part.unknown[a]);
        part.stride[a] = 3 * (block_begin_[vertex + 1] - block_begin_[vertex]);
        for (std::size_t b = 0; b < Size; ++b) {
            // Column a, row b.
            if (part.unknown[b] < part.unknown[a]) continue;
            const auto begin = block_rows_.begin() + block_begin_[vertex];
            const auto found = std::lower_bound(begin, block_rows_.begin() + block_begin_[vertex + 1], part.unknown[b]);
            const std::size_t high = std::max(a, b), low = std::min(a, b);
            part.place[high * (high + 1) / 2 + low] = 9 * block_begin_[vertex] + 3 * static_cast<int>(found - begin);
        }
    }
}

Eigen::SparseMatrix<double> ElasticSystem::hessian_pattern() const
{
    Eigen::SparseMatrix<double> matrix(num_unknowns(), num_unknowns());
    matrix.resizeNonZeros(9 * block_begin_.back());
    int value = 0;
    for (std::size_t v = 0; v < vertices_.size(); ++v) {
        for (int j = 0; j < 3; ++j) {
            matrix.outerIndexPtr()[3 * v + static_cast<std::size_t>(j)] = value;
            for (int k = block_begin_[v]; k < block_begin_[v + 1]; ++k) {
                for (int i = 0; i < 3; ++i) {
                    matrix.innerIndexPtr()[value] = 3 * block_rows_[static_cast<std::size_t>(k)] + i;
                    matrix.valuePtr()[value++] = 0;
                }
            }
        }
    }
    matrix.outerIndexPtr()[num_unknowns()] = value;
    return matrix;
}

template <std::size_t Size>
void ElasticSystem::scatter(const Part<Size>& part, const LaneBlocks<Size>& blocks, std::size_t lane, double* values)
{
    std::size_t block = 0;
    for (std::size_t a = 0; a < Size; ++a) {
        for (std::size_t b = 0; b <= a; ++b, ++block) {
            const int place = part.place[block];
            if (place < 0) continue;
            const bool transposed = part.unknown[a] < part.unknown[b];
            const std::ptrdiff_t down = transposed ? part.stride[a] : 1, right = transposed ? 1 : part.stride[b];
            const double* source = &blocks.values[num_lanes * 9 * block + lane];
            double* target = values + place;
            for (int j = 0; j < 3; ++j) {
                for (int i = 0; i < 3; ++i) target[i * down + j * right] += source[num_lanes * (i + 3 * j)];
            }
        }
    }
}

void ElasticSystem::hessian(const Points& positions, HessianKind kind, Eigen::SparseMatrix<double>& hessian) const
{
    require(hessian.rows() == num_unknowns() && hessian.nonZeros() == 9 * block_begin_.back(),
            "the matrix given does not have the pattern of this system");
    std::fill_n(hessian.valuePtr(), hessian.nonZeros(), 0.0);
    flesh_hessian(positions, kind, hessian.valuePtr());
    skin_hessian(positions, kind, hessian.valuePtr());
}

void ElasticSystem::flesh_hessian(const Points& positions, HessianKind kind, double* values) const
{
    PrismBlocks blocks;
    std::vector<const Part<6>*> unstable;
    const auto add_projected = [&](const auto& batch) {
        FleshLanes(positions, batch.elements).projected_hessian(blocks);
        for (std::size_t i = 0; i < batch.count; ++i) scatter(*batch.parts[i], blocks, i, values);
    };
    const auto add = [&](const auto& batch) {
        const FleshLanes flesh(positions, batch.elements);
        flesh.hessian(blocks);
        const Lanes stability = kind == HessianKind::exact ? Lanes(1.0) : flesh.stability();
        const auto scatter_lane = [&](std::size_t i) { scatter(*batch.parts[i], blocks, i, values); };
        sort_out_unstable(batch, stability, unstable, scatter_lane);
    };
    if (kind == HessianKind::exact || kind == HessianKind::nearly_exact) {
        for_batches(flesh_, model_->flesh(), add);
        for_batches(unstable, model_->flesh(), add_projected);
    } else {
        for_batches(flesh_, model_->flesh(), add_projected);
    }
    if (!model_->guards_volume()) return;
    for_batches(flesh_, model_->flesh(), [&](const auto& batch) {
        if (none_of(FleshLanes(positions, batch.elements).volume_shares() < guarded_volume_share)) return;
        for (std::size_t i = 0; i < batch.count; ++i) {
            const GuardedPrism guarded(positions, *batch.elements[i]);
            if (!guarded.active()) continue;
            blocks.set_lane(0, guarded.hessian(kind == HessianKind::exact));
            scatter(*batch.parts[i], blocks, 0, values);
        }
    });
}

void ElasticSystem::skin_hessian(const Points& positions, HessianKind kind, double* values) const
{
    HingeBlocks blocks;
    std::vector<const Part<4>*> unstable;
    const auto lanes = [&](const auto& batch) {
        return SkinLanes(positions, batch.elements, model_->stretch_stiffness());
    };
    const auto scatter_all = [&](const auto& batch) {
        for (std::size_t i = 0; i < batch.count; ++i) scatter(*batch.parts[i], blocks, i, values);
    };
    const auto add_projected = [&](const auto& batch) {
        lanes(batch).projected_hessian(blocks);
        scatter_all(batch);
    };
    const auto add_gauss_newton = [&](const auto& batch) {
        lanes(batch).gauss_newton_hessian(blocks);
        scatter_all(batch);
    };
    const auto add = [&](const auto& batch) {
        const SkinLanes skin = lanes(batch);
        skin.hessian(blocks);
        const Lanes stability = kind == HessianKind::exact ? Lanes(1.0) : skin.stability();
        const auto scatter_lane = [&](std::size_t i) { scatter(*batch.parts[i], blocks, i, values); };
        sort_out_unstable(batch, stability, unstable, scatter_lane);
    };
    if (kind == HessianKind::gauss_newton) {
        for_batches(skin_, model_->skin(), add_gauss_newton);
    } else if (kind == HessianKind::projected) {
        for_batches(skin_, model_->skin(), add_projected);
    } else {
        for_batches(skin_, model_->skin(), add);
        for_batches(unstable, model_->skin(), add_projected);
    }
}

}  // namespace ndg
