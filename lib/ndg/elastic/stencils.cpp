// SPDX-License-Identifier: Apache-2.0
#include "ndg/elastic/stencils.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <numeric>

namespace ndg {

Stencils::Stencils(int num_corners, std::vector<int> vertices, int num_vertices, std::vector<std::pair<int, int>> apart)
    : num_corners_(num_corners), vertices_(std::move(vertices)), around_begin_(num_vertices + 1, 0)
{
    for (const int vertex : vertices_) {
        require(vertex >= 0 && vertex < num_vertices, "an element has vertex {} of {}", vertex, num_vertices);
        ++around_begin_[vertex + 1];
    }
    for (int a = 0; a < num_corners_; ++a) {
        for (int b = 0; b < num_corners_; ++b) {
            const std::pair<int, int> pair(std::min(a, b), std::max(a, b));
            if (a != b && std::find(apart.begin(), apart.end(), pair) == apart.end()) adjacent_.emplace_back(a, b);
        }
    }
    std::partial_sum(around_begin_.begin(), around_begin_.end(), around_begin_.begin());
    around_.resize(vertices_.size());
    std::vector<int> end(around_begin_.begin(), around_begin_.end() - 1);
    for (int i = 0; i < int(vertices_.size()); ++i) around_[end[vertices_[i]]++] = i / num_corners_;
}

std::vector<int> Stencils::elements_at(const std::vector<int>& vertices) const
{
    std::vector<int> elements;
    for (const int vertex : vertices) {
        elements.insert(elements.end(), around_.begin() + around_begin_[vertex],
                        around_.begin() + around_begin_[vertex + 1]);
    }
    std::sort(elements.begin(), elements.end());
    elements.erase(std::unique(elements.begin(), elements.end()), elements.end());
    return elements;
}

}  // namespace ndg
