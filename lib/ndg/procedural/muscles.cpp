// SPDX-License-Identifier: Apache-2.0
#include "ndg/procedural/muscles.h"

#include "ndg/core/error.h"
#include "ndg/geometry/triangle_mesh.h"
#include "ndg/procedural/bones.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

namespace ndg {

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr double edge_length = 0.015;  // m, about the longest: only vertices bend with the flesh
constexpr int least_rings = 13, least_sides = 12;
constexpr double fascia_depth = 0.0032;  // m under the lean skin

/// Catmull-Rom spline through the stations at t in [0, 1], uniform in the stations.
MuscleStation station_at(const std::vector<MuscleStation>& stations, double t)
{
    const double place = t * static_cast<double>(stations.size() - 1);
    const std::size_t i = std::min(static_cast<std::size_t>(place), stations.size() - 2);
    const double f = place - static_cast<double>(i), f2 = f * f, f3 = f2 * f;
    const MuscleStation &p1 = stations[i], &p2 = stations[i + 1];
    const MuscleStation &p0 = stations[i == 0 ? 0 : i - 1], &p3 = stations[std::min(i + 2, stations.size() - 1)];
    const double a = 0.5 * (-f3 + 2.0 * f2 - f), b = 0.5 * (3.0 * f3 - 5.0 * f2 + 2.0),
                 c = 0.5 * (-3.0 * f3 + 4.0 * f2 + f), d = 0.5 * (f3 - f2);
    MuscleStation result;
    result.place = a * p0.place + b * p1.place + c * p2.place + d * p3.place;
    const double s = f2 * (3.0 - 2.0 * f);
    result.superficial = (1.0 - s) * p1.superficial + s * p2.superficial;
    result.width = (1.0 - s) * p1.width + s * p2.width;
    result.thickness = (1.0 - s) * p1.thickness + s * p2.thickness;
    return result;
}

Eigen::Vector3d outward(const Field& skin, const Eigen::Vector3d& x)
{
    const Eigen::Vector3d gradient = skin.gradient(x);
    return gradient.norm() > 1e-6 ? gradient.normalized() : Eigen::Vector3d::UnitZ();
}

/// Rings along the way, and vertices on the widest of them, that are about edge_length apart.
std::pair<int, int> rings_and_sides(const MuscleSketch& sketch)
{
    constexpr int parts = 200;
    double length = 0.0, widest = 0.0;
    for (int i = 0; i < parts; ++i) {
        const MuscleStation here = station_at(sketch.stations, static_cast<double>(i) / parts);
        const MuscleStation next = station_at(sketch.stations, static_cast<double>(i + 1) / parts);
        length += (next.place - here.place).norm();
        widest = std::max(widest, here.width);
    }
    const double side_angle = 2.0 * std::asin(std::min(1.0, 0.5 * edge_length / widest));
    return {std::max(least_rings, static_cast<int>(std::ceil(length / edge_length)) + 1),
            std::max(least_sides, 2 * static_cast<int>(std::ceil(pi / side_angle)))};
}

AnatomyMesh sweep(const MuscleSketch& sketch, const Field& skin)
{
    const auto [num_rings, num_sides] = rings_and_sides(sketch);
    AnatomyMesh part;
    part.name = sketch.name;
    part.name[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(part.name[0])));
    part.name = "Left " + part.name;
    part.fma_id = sketch.fma_left;
    part.side = BodySide::left;
    part.layer = AnatomyLayer::muscle;
    part.vertices.resize(num_rings * num_sides + 2, 3);
    for (int r = 0; r < num_rings; ++r) {
        const double t = static_cast<double>(r) / (num_rings - 1);
        const MuscleStation here = station_at(sketch.stations, t);
        const Eigen::Vector3d ahead = station_at(sketch.stations, std::min(1.0, t + 0.03)).place -
                                      station_at(sketch.stations, std::max(0.0, t - 0.03)).place;
        const Eigen::Vector3d across = ahead.cross(outward(skin, here.place)).normalized();
        // The ends close over a short cap.
        const double ends = std::sqrt(std::max(0.0, 1.0 - std::pow(std::abs(2.0 * t - 1.0), 6.0)));
        const double width = here.width * (0.45 + 0.55 * ends), thickness = here.thickness * (0.35 + 0.65 * ends);
        for (int k = 0; k < num_sides; ++k) {
            const double angle = 2.0 * pi * k / num_sides, b = std::cos(angle);
            Eigen::Vector3d middle = here.place + b * width * across;
            if (here.superficial > 0.0)
                middle += here.superficial * (skin.project(middle, -fascia_depth - thickness, 12) - middle);
            part.vertices.row(r * num_sides + k) =
                (middle + std::sin(angle) * thickness * outward(skin, middle)).transpose();
        }
    }
    for (const int end : {0, 1}) {
        const int first = end == 0 ? 0 : (num_rings - 1) * num_sides;
        part.vertices.row(num_rings * num_sides + end) = part.vertices.middleRows(first, num_sides).colwise().mean();
    }
    std::vector<std::array<int, 3>> faces;
    for (int k = 0; k < num_sides; ++k) {
        const int next = (k + 1) % num_sides;
        for (int r = 0; r + 1 < num_rings; ++r) {
            const int a = r * num_sides + k, b = r * num_sides + next, c = a + num_sides, d = b + num_sides;
            faces.push_back({a, b, d});
            faces.push_back({a, d, c});
        }
        const int last = (num_rings - 1) * num_sides;
        faces.push_back({num_rings * num_sides, next, k});
        faces.push_back({num_rings * num_sides + 1, last + k, last + next});
    }
    part.triangles.resize(static_cast<Eigen::Index>(faces.size()), 3);
    for (std::size_t f = 0; f < faces.size(); ++f)
        part.triangles.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
    if (enclosed_volume(part.vertices, part.triangles) < 0.0) part.triangles.col(1).swap(part.triangles.col(2));
    return part;
}

}  // namespace

std::vector<AnatomyMesh> procedural_muscles(const BodyLayout& layout, const Field& lean_skin)
{
    std::vector<MuscleSketch> sketches = trunk_muscle_sketches(layout);
    std::vector<MuscleSketch> limbs = limb_muscle_sketches(layout);
    std::move(limbs.begin(), limbs.end(), std::back_inserter(sketches));
    std::vector<AnatomyMesh> muscles(2 * sketches.size());
#pragma omp parallel for schedule(dynamic)
    for (std::size_t i = 0; i < sketches.size(); ++i) {
        muscles[2 * i] = sweep(sketches[i], lean_skin);
        muscles[2 * i + 1] = mirrored_part(muscles[2 * i], sketches[i].fma_right);
    }
    return muscles;
}

}  // namespace ndg
