// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/embedding.h"

#include "ndg/core/error.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/prism.h"
#include "ndg/geometry/tetrahedra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace ndg {

namespace {

using Weights = Eigen::Matrix<double, 6, 1>;
using Box = Eigen::AlignedBox3d;

/// A point counts as inside an element when no local coordinate is below minus this.
constexpr double inside_tolerance = 1e-9;
/// Metres added to boxes, so that rounding cannot hide a point on an element's face.
constexpr double box_margin = 1e-9;

/// Prisms and tetrahedra as one list of elements: prism p, then N_p + tetrahedron index.
class Elements {
public:
    Elements(const Eigen::Ref<const Points>& volume_vertices, const Eigen::Ref<const Prisms>& prisms,
             const Eigen::Ref<const Points>& interior_vertices, const Eigen::Ref<const Tetrahedra>& tetrahedra,
             int num_wrap_vertices)
        : num_prisms_(static_cast<int>(prisms.rows())),
          positions_(volume_vertices.rows() + interior_vertices.rows(), 3),
          vertices_(prisms.rows() + tetrahedra.rows(), 6)
    {
        positions_ << volume_vertices, interior_vertices;
        require(positions_.array().isFinite().all(), "An element's vertex is not a finite point");
        const int num_volume_vertices = static_cast<int>(volume_vertices.rows());
        vertices_.setZero();
        vertices_.topRows(prisms.rows()) = prisms;
        for (Eigen::Index t = 0; t < tetrahedra.rows(); ++t) {
            for (Eigen::Index k = 0; k < 4; ++k) {
                const int vertex = tetrahedra(t, k);
                vertices_(prisms.rows() + t, k) =
                    vertex < num_wrap_vertices ? vertex : vertex - num_wrap_vertices + num_volume_vertices;
            }
        }
        for (Eigen::Index i = 0; i < vertices_.size(); ++i) {
            require(vertices_.data()[i] >= 0 && vertices_.data()[i] < positions_.rows(),
                    "An element has vertex {} of {}", vertices_.data()[i], positions_.rows());
        }
    }

    int size() const { return static_cast<int>(vertices_.rows()); }
    auto vertices(int element) const { return vertices_.row(element); }

    Box box(int element) const
    {
        Box box;
        for (int k = 0; k < num_corners(element); ++k) box.extend(corner(element, k));
        return Box(box.min().array() - box_margin, box.max().array() + box_margin);
    }

    /// Smallest local coordinate of the point (>= 0 inside) and its weights; -infinity if there are none.
    double coordinates(int element, const Eigen::Vector3d& point, Weights& weights) const
    {
        weights.setZero();
        if (element >= num_prisms_) {
            weights.head<4>() = tetrahedron_coordinates(corner(element, 0), corner(element, 1), corner(element, 2),
                                                        corner(element, 3), point);
            const double smallest = std::min({weights[0], weights[1], weights[2], weights[3]});
            return std::isfinite(smallest) ? smallest : -std::numeric_limits<double>::infinity();
        }
        const PrismCoordinates local = prism_coordinates(prism(element), point.transpose());
        if (!local.converged) return -std::numeric_limits<double>::infinity();
        weights = prism_shape_functions(local.alpha, local.beta, local.xi);
        return std::min({local.alpha, local.beta, 1.0 - local.alpha - local.beta, local.xi, 1.0 - local.xi});
    }

    /// Distance of an outside point to the element and the weights of its closest point.
    double distance(int element, const Eigen::Vector3d& point, Weights& weights) const
    {
        return element >= num_prisms_ ? tetrahedron_distance(element, point, weights)
                                      : prism_distance(prism(element), point, weights);
    }

private:
    int num_corners(int element) const { return element < num_prisms_ ? 6 : 4; }
    Eigen::Vector3d corner(int element, int k) const { return positions_.row(vertices_(element, k)).transpose(); }
    PrismVertices prism(int element) const
    {
        PrismVertices prism;
        for (int k = 0; k < 6; ++k) prism.row(k) = positions_.row(vertices_(element, k));
        return prism;
    }

    /// Exact: the closest point of an outside point lies on one of the four faces.
    double tetrahedron_distance(int element, const Eigen::Vector3d& point, Weights& weights) const
    {
        constexpr std::array<std::array<int, 3>, 4> faces = {{{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};
        double best = std::numeric_limits<double>::infinity();
        for (const auto& face : faces) {
            const ClosestPoint closest = closest_point_on_triangle(point, corner(element, face[0]),
                                                                   corner(element, face[1]), corner(element, face[2]));
            if (!(closest.distance < best)) continue;
            best = closest.distance;
            weights.setZero();
            for (int k = 0; k < 3; ++k) weights[face[k]] = closest.barycentric[k];
        }
        return best;
    }

    /// At fixed xi the prism is a triangle, at fixed (alpha, beta) a segment, and the closest point of each is exact:
    /// minimising over the two in turn stays inside the element and never increases the distance.
    static double prism_distance(const PrismVertices& prism, const Eigen::Vector3d& point, Weights& weights)
    {
        constexpr int max_iterations = 100;
        constexpr double tolerance = 1e-12;  // metres
        double best = std::numeric_limits<double>::infinity();
        for (double xi : {0.0, 0.5, 1.0}) {
            double distance = std::numeric_limits<double>::infinity();
            Eigen::Vector3d barycentric = Eigen::Vector3d::Zero();
            for (int iteration = 0; iteration < max_iterations; ++iteration) {
                const Eigen::Matrix3d triangle = xi * prism.topRows<3>() + (1.0 - xi) * prism.bottomRows<3>();
                const ClosestPoint closest = closest_point_on_triangle(
                    point, triangle.row(0).transpose(), triangle.row(1).transpose(), triangle.row(2).transpose());
                barycentric = closest.barycentric;
                const bool settled = closest.distance > distance - tolerance;
                distance = closest.distance;
                if (settled) break;
                const Eigen::Vector3d outer = prism.topRows<3>().transpose() * barycentric;
                const Eigen::Vector3d inner = prism.bottomRows<3>().transpose() * barycentric;
                const double length2 = (outer - inner).squaredNorm();
                if (length2 > 0.0) xi = std::clamp((point - inner).dot(outer - inner) / length2, 0.0, 1.0);
            }
            if (!(distance < best)) continue;
            best = distance;
            weights << xi * barycentric, (1.0 - xi) * barycentric;
        }
        return best;
    }

    int num_prisms_;
    Points positions_;
    Eigen::Matrix<int, Eigen::Dynamic, 6, Eigen::RowMajor> vertices_;
};

/// Bounding-volume hierarchy over the elements' boxes, split at the median of the centres along the longest side.
class ElementTree {
public:
    explicit ElementTree(const Elements& elements) : elements_(elements)
    {
        boxes_.reserve(elements.size());
        for (int e = 0; e < elements.size(); ++e) boxes_.push_back(elements.box(e));
        order_.resize(boxes_.size());
        std::iota(order_.begin(), order_.end(), 0);
        nodes_.reserve(2 * boxes_.size());
        build(0, elements.size());
    }

    struct Found {
        int element = -1;
        Weights weights = Weights::Zero();
        double distance = 0.0;
    };

    Found find(const Eigen::Vector3d& point) const
    {
        Found found;
        double largest = -inside_tolerance;
        find_containing(0, point, largest, found);
        if (found.element < 0) {
            found.distance = std::numeric_limits<double>::infinity();
            find_nearest(0, point, found);
        }
        return found;
    }

private:
    struct Node {
        Box box;
        int begin = 0, end = 0;  ///< range of order_; a leaf when second_child is 0
        int second_child = 0;    ///< the first child follows its parent
    };
    static constexpr int leaf_size = 4;

    int build(int begin, int end)
    {
        const int index = static_cast<int>(nodes_.size());
        nodes_.emplace_back();
        Box box, centres;
        for (int i = begin; i < end; ++i) {
            const Box& element_box = boxes_[order_[i]];
            box.extend(element_box);
            centres.extend(element_box.center());
        }
        int second_child = 0;
        if (end - begin > leaf_size) {
            const Eigen::Vector3d sides = centres.sizes();
            int axis = 0;
            if (sides[1] > sides[axis]) axis = 1;
            if (sides[2] > sides[axis]) axis = 2;
            const int middle = begin + (end - begin) / 2;
            std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end, [&](int a, int b) {
                const double centre_a = boxes_[a].center()[axis];
                const double centre_b = boxes_[b].center()[axis];
                return centre_a != centre_b ? centre_a < centre_b : a < b;
            });
            build(begin, middle);
            second_child = build(middle, end);
        }
        nodes_[index] = {box, begin, end, second_child};
        return index;
    }

    /// Of the elements holding the point the one it lies deepest in, the first of equals.
    void find_containing(int index, const Eigen::Vector3d& point, double& largest, Found& found) const
    {
        const Node& node = nodes_[index];
        if (!node.box.contains(point)) return;
        if (node.second_child != 0) {
            find_containing(index + 1, point, largest, found);
            find_containing(node.second_child, point, largest, found);
            return;
        }
        for (int i = node.begin; i < node.end; ++i) {
            const int element = order_[i];
            if (!boxes_[element].contains(point)) continue;
            Weights weights;
            const double smallest = elements_.coordinates(element, point, weights);
            if (smallest < largest || (smallest == largest && found.element >= 0 && element > found.element)) continue;
            largest = smallest;
            found.element = element;
            found.weights = weights;
        }
    }

    void find_nearest(int index, const Eigen::Vector3d& point, Found& found) const
    {
        const Node& node = nodes_[index];
        if (node.second_child != 0) {
            int near_child = index + 1, far_child = node.second_child;
            double near_distance = box_distance(near_child, point), far_distance = box_distance(far_child, point);
            if (far_distance < near_distance) {
                std::swap(near_child, far_child);
                std::swap(near_distance, far_distance);
            }
            if (near_distance < found.distance) find_nearest(near_child, point, found);
            if (far_distance < found.distance) find_nearest(far_child, point, found);
            return;
        }
        for (int i = node.begin; i < node.end; ++i) {
            const int element = order_[i];
            if (boxes_[element].exteriorDistance(point) >= found.distance) continue;
            Weights weights;
            const double distance = elements_.distance(element, point, weights);
            if (distance > found.distance || (distance == found.distance && element > found.element)) continue;
            found.distance = distance;
            found.element = element;
            found.weights = weights;
        }
    }

    double box_distance(int index, const Eigen::Vector3d& point) const
    {
        return nodes_[index].box.exteriorDistance(point);
    }

    const Elements& elements_;
    std::vector<Box> boxes_;
    std::vector<int> order_;
    std::vector<Node> nodes_;
};

}  // namespace

Embedding embed_points(const Eigen::Ref<const Points>& points, const Eigen::Ref<const Points>& volume_vertices,
                       const Eigen::Ref<const Prisms>& prisms, const Eigen::Ref<const Points>& interior_vertices,
                       const Eigen::Ref<const Tetrahedra>& tetrahedra, int num_wrap_vertices)
{
    require(points.array().isFinite().all(), "A point to embed is not finite");
    Embedding embedding;
    embedding.elements.assign(points.rows(), -1);
    embedding.distances.assign(points.rows(), 0.0);
    embedding.vertices.setZero(points.rows(), 6);
    embedding.weights.setZero(points.rows(), 6);
    if (points.rows() == 0) return embedding;

    const Elements elements(volume_vertices, prisms, interior_vertices, tetrahedra, num_wrap_vertices);
    require(elements.size() > 0, "{} points were to be embedded in a volume without elements", points.rows());
    const ElementTree tree(elements);
#pragma omp parallel for schedule(dynamic, 64)
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const ElementTree::Found found = tree.find(points.row(i).transpose());
        embedding.elements[i] = found.element;
        embedding.distances[i] = found.distance;
        embedding.vertices.row(i) = elements.vertices(found.element);
        embedding.weights.row(i) = found.weights.transpose();
    }
    return embedding;
}

Points apply_embedding(const Embedding& embedding, const Eigen::Ref<const Points>& volume_vertices,
                       const Eigen::Ref<const Points>& interior_vertices)
{
    const Eigen::Index num_volume = volume_vertices.rows();
    const Eigen::Index num_vertices = num_volume + interior_vertices.rows();
    for (Eigen::Index i = 0; i < embedding.vertices.size(); ++i) {
        const int vertex = embedding.vertices.data()[i];
        require(vertex >= 0 && vertex < num_vertices, "The embedding refers to vertex {} of {}", vertex, num_vertices);
    }
    Points points(embedding.vertices.rows(), 3);
#pragma omp parallel for schedule(static)
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (Eigen::Index k = 0; k < 6; ++k) {
            const double weight = embedding.weights(i, k);
            if (weight == 0.0) continue;
            const Eigen::Index vertex = embedding.vertices(i, k);
            if (vertex < num_volume) {
                sum += weight * volume_vertices.row(vertex);
            } else {
                sum += weight * interior_vertices.row(vertex - num_volume);
            }
        }
        points.row(i) = sum;
    }
    return points;
}

}  // namespace ndg
