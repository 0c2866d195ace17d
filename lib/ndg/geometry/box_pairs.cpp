// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/box_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

namespace ndg {

namespace {

using Cell = Eigen::Array<std::int64_t, 3, 1>;

/// Cells of equal size, numbered from the lowest corner of all boxes.
class Grid {
public:
    Grid(const Boxes& first, const Boxes& second)
    {
        const Eigen::Array3d low =
            first.leftCols<3>().colwise().minCoeff().cwiseMin(second.leftCols<3>().colwise().minCoeff());
        const Eigen::Array3d high =
            first.rightCols<3>().colwise().maxCoeff().cwiseMax(second.rightCols<3>().colwise().maxCoeff());
        const auto extent = [](const Boxes& boxes) {
            return (boxes.rightCols<3>() - boxes.leftCols<3>()).rowwise().maxCoeff().mean();
        };
        origin_ = low;
        // At most 2^20 cells along an axis, so that three indices fit one key.
        size_ = std::max(
            {extent(first), extent(second), (high - low).maxCoeff() / (1 << 20), std::numeric_limits<double>::min()});
    }
    Cell cell(const Eigen::Array3d& point) const { return ((point - origin_) / size_).floor().cast<std::int64_t>(); }

private:
    Eigen::Array3d origin_;
    double size_ = 1;
};

struct Entry {
    std::int64_t key;
    int box;
    bool operator<(const Entry& other) const { return key != other.key ? key < other.key : box < other.box; }
};

std::int64_t key_of(const Cell& cell)
{
    return (cell[0] << 42) | (cell[1] << 21) | cell[2];
}

/// Every box in every cell it overlaps, sorted by cell.
std::vector<Entry> entries(const Boxes& boxes, const Grid& grid)
{
    std::vector<Entry> result;
    result.reserve(4 * boxes.rows());
    for (int i = 0; i < boxes.rows(); ++i) {
        const Cell low = grid.cell(boxes.row(i).head<3>().transpose()),
                   high = grid.cell(boxes.row(i).tail<3>().transpose());
        for (std::int64_t x = low[0]; x <= high[0]; ++x)
            for (std::int64_t y = low[1]; y <= high[1]; ++y)
                for (std::int64_t z = low[2]; z <= high[2]; ++z) result.push_back({key_of(Cell(x, y, z)), i});
    }
    std::sort(result.begin(), result.end());
    return result;
}

}  // namespace

std::vector<std::pair<int, int>> overlapping_boxes(const Boxes& first, const Boxes& second)
{
    std::vector<std::pair<int, int>> pairs;
    if (first.rows() == 0 || second.rows() == 0) return pairs;
    const Grid grid(first, second);
    const std::vector<Entry> a = entries(first, grid), b = entries(second, grid);
    auto begin = b.begin();
    for (const Entry& entry : a) {
        while (begin != b.end() && begin->key < entry.key) ++begin;
        for (auto other = begin; other != b.end() && other->key == entry.key; ++other) {
            const auto box = first.row(entry.box), box_b = second.row(other->box);
            const Eigen::Array3d low = box.head<3>().cwiseMax(box_b.head<3>()).transpose();
            const Eigen::Array3d high = box.tail<3>().cwiseMin(box_b.tail<3>()).transpose();
            // Boxes that share several cells are found in that of their common lower corner.
            if ((low <= high).all() && key_of(grid.cell(low)) == entry.key) pairs.emplace_back(entry.box, other->box);
        }
    }
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

}  // namespace ndg
