// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/nearest_seeds.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// One line of the lower envelope of parabolas (Felzenszwalb and Huttenlocher 2012) with apices off the nodes: a seed
/// lies in its node's cube, so the apices along a line are in order.
class LineTransform {
public:
    explicit LineTransform(int length) : apex_(length), height_(length), seed_(length), from_(length) {}

    /// `seeds` of the nodes on the line (-1 for none) are replaced by the nearest seed of each. `height(seed)`: squared
    /// distance in the axes done before.
    template <typename Height>
    void run(std::vector<int>& seeds, const std::vector<Eigen::Vector3f>& points, int axis, const Height& height)
    {
        std::size_t count = 0;
        for (const int seed : seeds) {
            if (seed < 0) continue;
            const double p = points[seed][axis];
            const double h = height(seed);
            double from = -1e30;
            bool hidden = false;
            while (count > 0) {
                const double gap = p - apex_[count - 1];
                if (gap < 1e-9) {
                    if (h >= height_[count - 1]) {
                        hidden = true;
                        break;
                    }
                    --count;
                    continue;
                }
                from = 0.5 * (p + apex_[count - 1] + (h - height_[count - 1]) / gap);
                if (from > from_[count - 1]) break;
                --count;
            }
            if (hidden) continue;
            if (count == 0) from = -1e30;
            apex_[count] = p;
            height_[count] = h;
            seed_[count] = seed;
            from_[count] = from;
            ++count;
        }
        if (count == 0) return;
        std::size_t current = 0;
        for (std::size_t i = 0; i < seeds.size(); ++i) {
            while (current + 1 < count && from_[current + 1] <= static_cast<double>(i)) ++current;
            seeds[i] = seed_[current];
        }
    }

private:
    std::vector<double> apex_, height_;
    std::vector<int> seed_;
    std::vector<double> from_;
};

/// Every node takes the nearest of its own seed and its neighbours'.
void compare_with_neighbours(const GridBox& box, SeedGrid& seeds)
{
    const std::vector<int> before = seeds.seed_of_node;
    const Eigen::Index dy = box.size[0], dz = dy * box.size[1];
    for_each_node(box, [&](int i, int j, int k, std::size_t n) {
        const Eigen::Vector3f node(i, j, k);
        int best = before[n];
        float nearest = (seeds.points[best] - node).squaredNorm();
        const auto compare = [&](bool exists, Eigen::Index step) {
            if (!exists) return;
            const int other = before[static_cast<Eigen::Index>(n) + step];
            if (other == best) return;
            const float distance = (seeds.points[other] - node).squaredNorm();
            if (distance >= nearest) return;
            nearest = distance;
            best = other;
        };
        compare(i > 0, -1);
        compare(i + 1 < box.size[0], 1);
        compare(j > 0, -dy);
        compare(j + 1 < box.size[1], dy);
        compare(k > 0, -dz);
        compare(k + 1 < box.size[2], dz);
        seeds.seed_of_node[n] = best;
    });
}

}  // namespace

void find_nearest_seeds(const GridBox& box, SeedGrid& seeds)
{
    auto& nodes = seeds.seed_of_node;
    const auto& points = seeds.points;
    constexpr int block = 16;  // lines side by side are fetched together, which the cache likes
    for (int axis = 0; axis < 3; ++axis) {
        const int length = box.size[axis];
        const int outer_axis = axis == 2 ? 1 : 2;
        const int inner_axis = axis == 0 ? 1 : 0;
        const Eigen::Index stride = axis == 0 ? 1 : (axis == 1 ? box.size[0] : Eigen::Index(box.size[0]) * box.size[1]);
#pragma omp parallel
        {
            LineTransform transform(length);
            std::vector<std::vector<int>> lines(block, std::vector<int>(static_cast<std::size_t>(length)));
#pragma omp for schedule(dynamic)
            for (int outer = 0; outer < box.size[outer_axis]; ++outer) {
                for (int begin = 0; begin < box.size[inner_axis]; begin += block) {
                    const int width = std::min(block, box.size[inner_axis] - begin);
                    Eigen::Array3i start = Eigen::Array3i::Zero();
                    start[outer_axis] = outer;
                    start[inner_axis] = begin;
                    const Eigen::Index first = box.index(start[0], start[1], start[2]);
                    const Eigen::Index step = inner_axis == 0 ? 1 : box.size[0];
                    for (int i = 0; i < length; ++i)
                        for (int w = 0; w < width; ++w) lines[w][i] = nodes[first + i * stride + w * step];
                    for (int w = 0; w < width; ++w) {
                        Eigen::Array3i at = start;
                        at[inner_axis] += w;
                        transform.run(lines[w], points, axis, [&](int seed) {
                            double sum = 0.0;
                            for (int done = 0; done < axis; ++done) {
                                const double gap = points[seed][done] - at[done];
                                sum += gap * gap;
                            }
                            return sum;
                        });
                    }
                    for (int i = 0; i < length; ++i)
                        for (int w = 0; w < width; ++w) nodes[first + i * stride + w * step] = lines[w][i];
                }
            }
        }
    }
    for (int round = 0; round < 2; ++round) compare_with_neighbours(box, seeds);
}

}  // namespace ndg
