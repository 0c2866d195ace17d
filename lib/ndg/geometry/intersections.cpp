// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/intersections.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>

namespace ndg {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point to_point(const Eigen::RowVector3d& row)
{
    return {row[0], row[1], row[2]};
}

/// A triangle as its exact set of points: a flat one is the longest of its edges.
struct Element {
    Kernel::Triangle_3 triangle;
    Kernel::Segment_3 segment;
    bool flat;
};

Element to_element(const Point& a, const Point& b, const Point& c)
{
    Element element{Kernel::Triangle_3(a, b, c), Kernel::Segment_3(a, b), CGAL::collinear(a, b, c)};
    for (const Kernel::Segment_3& edge : {Kernel::Segment_3(b, c), Kernel::Segment_3(c, a)}) {
        if (edge.squared_length() > element.segment.squared_length()) element.segment = edge;
    }
    return element;
}

bool intersect(const Element& a, const Element& b)
{
    if (!a.flat && !b.flat) return CGAL::do_intersect(a.triangle, b.triangle);
    if (a.flat && b.flat) return CGAL::do_intersect(a.segment, b.segment);
    return a.flat ? CGAL::do_intersect(b.triangle, a.segment) : CGAL::do_intersect(a.triangle, b.segment);
}

using Box = CGAL::Box_intersection_d::Box_with_info_d<double, 3, int>;

struct BoxedSurface {
    std::vector<Element> elements;
    std::vector<Box> boxes;

    BoxedSurface(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
    {
        elements.reserve(triangles.rows());
        boxes.reserve(elements.capacity());
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            elements.push_back(to_element(to_point(vertices.row(triangles(t, 0))),
                                          to_point(vertices.row(triangles(t, 1))),
                                          to_point(vertices.row(triangles(t, 2)))));
            boxes.emplace_back(elements.back().triangle.bbox(), static_cast<int>(t));
        }
    }
    const Element& operator[](int t) const { return elements[t]; }
};

/// Whether triangles with common vertices meet elsewhere too. Corners of each from the first common one on.
bool neighbours_intersect(const Element& s, const Element& t, const std::vector<std::pair<int, int>>& common)
{
    if (s.flat || t.flat) return false;
    if (common.size() == 3) return true;
    const auto [i, j] = common[0];
    if (common.size() == 1) {
        // The segment in which they meet, if any, ends on the side opposite the common vertex of one of them.
        return CGAL::do_intersect(t.triangle, Kernel::Segment_3(s.triangle.vertex(i + 1), s.triangle.vertex(i + 2))) ||
               CGAL::do_intersect(s.triangle, Kernel::Segment_3(t.triangle.vertex(j + 1), t.triangle.vertex(j + 2)));
    }
    const auto [k, l] = common[1];
    const Point &a = s.triangle.vertex(i), &b = s.triangle.vertex(k), &c = s.triangle.vertex(3 - i - k),
                &d = t.triangle.vertex(3 - j - l);
    return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
}

}  // namespace

std::vector<std::pair<int, int>> self_intersections(const Eigen::Ref<const Points>& vertices,
                                                    const Eigen::Ref<const Triangles>& triangles, bool with_neighbours)
{
    BoxedSurface surface(vertices, triangles);
    std::vector<std::pair<int, int>> pairs;
    CGAL::box_self_intersection_d(surface.boxes.begin(), surface.boxes.end(), [&](const Box& a, const Box& b) {
        const int s = std::min(a.info(), b.info());
        const int t = std::max(a.info(), b.info());
        std::vector<std::pair<int, int>> common;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                if (triangles(s, i) == triangles(t, j)) common.emplace_back(i, j);
        if (common.empty() ? intersect(surface[s], surface[t])
                           : with_neighbours && neighbours_intersect(surface[s], surface[t], common))
            pairs.emplace_back(s, t);
    });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

std::vector<std::pair<int, int>> surface_intersections(const Eigen::Ref<const Points>& first_vertices,
                                                       const Eigen::Ref<const Triangles>& first_triangles,
                                                       const Eigen::Ref<const Points>& second_vertices,
                                                       const Eigen::Ref<const Triangles>& second_triangles)
{
    BoxedSurface first(first_vertices, first_triangles), second(second_vertices, second_triangles);
    std::vector<std::pair<int, int>> pairs;
    CGAL::box_intersection_d(first.boxes.begin(), first.boxes.end(), second.boxes.begin(), second.boxes.end(),
                             [&](const Box& a, const Box& b) {
                                 if (intersect(first[a.info()], second[b.info()]))
                                     pairs.emplace_back(a.info(), b.info());
                             });
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

}  // namespace ndg
