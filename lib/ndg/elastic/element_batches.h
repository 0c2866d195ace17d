// SPDX-License-Identifier: Apache-2.0
// A term's elements, num_lanes at a time.
#pragma once

#include "ndg/core/types.h"
#include "ndg/elastic/element_places.h"
#include "ndg/elastic/lanes.h"

#include <algorithm>
#include <vector>

namespace ndg {

/// Up to num_lanes elements in a row; short batches repeat the last. `Rest` holds what a kernel knows of one element
/// beside its corners.
template <class Rest>
struct ElementBatch {
    std::array<int, num_lanes> places;          ///< index among the objective's elements
    std::array<const int*, num_lanes> corners;  ///< vertices
    std::array<const Rest*, num_lanes> rests;
    int count;
};

/// work(batch) for the elements places(0) to places(count - 1) of the objective's.
template <class Rest, class Places, class Work>
void for_batches(const Stencils& stencils, const std::vector<Rest>& rests, const ElementPlaces& elements, int count,
                 const Places& places, const Work& work)
{
    constexpr int lanes = num_lanes;
    ElementBatch<Rest> batch;
    for (int begin = 0; begin < count; begin += lanes) {
        batch.count = std::min(lanes, count - begin);
        for (int i = 0; i < lanes; ++i) {
            batch.places[i] = places(begin + std::min(i, batch.count - 1));
            const int element = elements.element(batch.places[i]);
            batch.corners[i] = stencils.corners(element);
            batch.rests[i] = &rests[element];
        }
        work(batch);
    }
}
/// For all of them.
template <class Rest, class Work>
void for_batches(const Stencils& stencils, const std::vector<Rest>& rests, const ElementPlaces& elements,
                 const Work& work)
{
    for_batches(
        stencils, rests, elements, elements.size(), [](int i) { return i; }, work);
}

template <std::size_t Corners>
[[gnu::always_inline]] inline std::array<Lanes3, Corners> gather_corners(
    const Points& positions, const std::array<const int*, num_lanes>& corners)
{
    std::array<Lanes3, Corners> x;
    for (std::size_t a = 0; a < Corners; ++a) {
        for (std::size_t c = 0; c < 3; ++c) {
            x[a][c] = gather_lanes(corners, [&](const int* vertices) { return positions.data()[3 * vertices[a] + c]; });
        }
    }
    return x;
}

}  // namespace ndg
