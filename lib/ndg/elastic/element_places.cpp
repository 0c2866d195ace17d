// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/element_places.h"

#include <algorithm>

namespace ndg {

ElementPlaces::ElementPlaces(const Stencils& stencils, const std::vector<int>& vertices)
    : num_corners_(stencils.num_corners()), record_length_(1 + 2 * num_corners_ + num_corners_ * (num_corners_ + 1) / 2)
{
    const std::vector<int> elements = stencils.elements_at(vertices);
    records_.assign(elements.size() * record_length_, -1);
    auto record = records_.begin();
    for (const int e : elements) {
        *record = e;
        for (int a = 0; a < num_corners_; ++a) {
            const int vertex = stencils.corners(e)[a];
            const auto found = std::lower_bound(vertices.begin(), vertices.end(), vertex);
            if (found != vertices.end() && *found == vertex) record[1 + a] = static_cast<int>(found - vertices.begin());
        }
        record += record_length_;
    }
}

void ElementPlaces::find_blocks(const SparsityPattern& pattern)
{
    for (int i = 0; i < size(); ++i) {
        int* unknown = &records_[record_length_ * i + 1];
        int *stride = unknown + num_corners_, *block = stride + num_corners_;
        for (int a = 0; a < num_corners_; ++a) {
            if (unknown[a] >= 0) stride[a] = pattern.stride(unknown[a]);
            for (int b = 0; b <= a; ++b, ++block) {
                const auto [column, row] = std::minmax(unknown[a], unknown[b]);
                if (column >= 0) *block = pattern.block(row, column);
            }
        }
    }
}

SparsityPattern::SparsityPattern(int num_unknown_vertices, const std::vector<ElementPlaces>& terms)
{
    // Later neighbours of every vertex with repetitions, one vertex after the other, then sorted and made unique.
    std::vector<int> end(num_unknown_vertices + 1, 0);
    const auto for_pairs = [&](const auto& visit) {
        for (const ElementPlaces& places : terms) {
            const int corners = places.num_corners();
            for (int i = 0; i < places.size(); ++i) {
                const int* unknown = places.unknown(i);
                for (int a = 0; a < corners; ++a) {
                    if (unknown[a] < 0) continue;
                    for (int b = 0; b < corners; ++b) {
                        if (unknown[b] > unknown[a]) visit(unknown[a], unknown[b]);
                    }
                }
            }
        }
    };
    for_pairs([&](int column, int) { ++end[column + 1]; });
    for (int v = 0; v < num_unknown_vertices; ++v) end[v + 1] += end[v] + 1;
    std::vector<int> all(end.back());
    for (int v = 0; v < num_unknown_vertices; ++v) all[end[v]++] = v;
    for_pairs([&](int column, int row) { all[end[column]++] = row; });
    rows_.reserve(all.size());
    begin_.push_back(0);
    auto first = all.begin();
    for (int v = 0; v < num_unknown_vertices; ++v) {
        const auto last = all.begin() + end[v];
        std::sort(first, last);
        rows_.insert(rows_.end(), first, std::unique(first, last));
        begin_.push_back(static_cast<int>(rows_.size()));
        first = last;
    }
}

Eigen::SparseMatrix<double> SparsityPattern::matrix() const
{
    const int num_vertices = static_cast<int>(begin_.size()) - 1;
    Eigen::SparseMatrix<double> matrix(3 * num_vertices, 3 * num_vertices);
    matrix.resizeNonZeros(num_values());
    int value = 0;
    for (int v = 0; v < num_vertices; ++v) {
        for (int j = 0; j < 3; ++j) {
            matrix.outerIndexPtr()[3 * v + j] = value;
            for (int k = begin_[v]; k < begin_[v + 1]; ++k) {
                for (int i = 0; i < 3; ++i) {
                    matrix.innerIndexPtr()[value] = 3 * rows_[k] + i;
                    matrix.valuePtr()[value++] = 0;
                }
            }
        }
    }
    matrix.outerIndexPtr()[3 * num_vertices] = value;
    return matrix;
}

int SparsityPattern::block(int row, int column) const
{
    const auto begin = rows_.begin() + begin_[column];
    const auto found = std::lower_bound(begin, rows_.begin() + begin_[column + 1], row);
    return 9 * begin_[column] + 3 * static_cast<int>(found - begin);
}

}  // namespace ndg
