// SPDX-License-Identifier: Apache-2.0
#include "ndg/geometry/tetrahedralize.h"

#include "ndg/core/error.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/geometry/triangle_mesh.h"

#include <tetgen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <new>
#include <string>
#include <vector>

namespace ndg {
namespace {

/// TetGen's own codes for terminatetetgen.
constexpr int tetgen_out_of_memory = 1;
constexpr int tetgen_self_intersection = 3;
constexpr int tetgen_small_feature = 4;
constexpr int tetgen_close_facets = 5;

/// Radius-edge ratio that refinement aims at.
constexpr double radius_edge_ratio = 1.414;

/// The working object of TetGen. When TetGen gives up it frees the object's memory and throws; the destructor would
/// free it a second time (as it does inside TetGen's own tetrahedralize), so it only runs after success.
class WorkingMesh {
public:
    WorkingMesh() : mesh_(new (storage_.data()) tetgenmesh) {}
    WorkingMesh(const WorkingMesh&) = delete;
    WorkingMesh& operator=(const WorkingMesh&) = delete;
    ~WorkingMesh()
    {
        if (finished_) mesh_->~tetgenmesh();
    }
    tetgenmesh* operator->() { return mesh_; }
    void finish() { finished_ = true; }

private:
    alignas(tetgenmesh) std::array<unsigned char, sizeof(tetgenmesh)> storage_{};
    tetgenmesh* mesh_;
    bool finished_ = false;
};

/// The steps of TetGen's tetrahedralize() for the switches p, Y, M, q, a and d. Throws int.
void run_tetgen(tetgenbehavior& behavior, tetgenio& input, tetgenio& output)
{
    clock_t time = 0;
    WorkingMesh mesh;
    mesh->b = &behavior;
    mesh->in = &input;
    mesh->initializepools();
    mesh->transfernodes();
    exactinit(behavior.verbose, behavior.noexact, behavior.nostaticfilter, mesh->xmax - mesh->xmin,
              mesh->ymax - mesh->ymin, mesh->zmax - mesh->zmin);
    mesh->incrementaldelaunay(time);
    mesh->meshsurface();
    output.firstnumber = input.firstnumber;
    output.mesh_dim = input.mesh_dim;
    if (behavior.diagnose != 0) {
        mesh->detectinterfaces();
        // What is left of the faces are those that intersect.
        if (mesh->subfaces->items > 0) mesh->outsubfaces(&output);
        mesh.finish();
        return;
    }
    mesh->recoverboundary(time);
    mesh->carveholes();
    if (mesh->subvertstack->objects > 0) mesh->suppresssteinerpoints();
    mesh->recoverdelaunay();
    if (behavior.quality != 0) mesh->delaunayrefinement();
    if (behavior.optlevel > 0) mesh->optimizemesh();
    mesh->outnodes(&output);
    mesh->outelements(&output);
    mesh.finish();
}

tetgenbehavior parse_switches(std::string switches)
{
    tetgenbehavior behavior;
    require(behavior.parse_commandline(switches.data()), "TetGen did not understand its switches {}", switches);
    return behavior;
}

/// Every triangle becomes a facet of its own. The arrays belong to `input`.
void fill_input(tetgenio& input, const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles)
{
    input.firstnumber = 0;
    input.numberofpoints = static_cast<int>(vertices.rows());
    input.pointlist = new double[3 * vertices.rows()];
    Eigen::Map<Points>(input.pointlist, vertices.rows(), 3) = vertices;
    input.numberoffacets = static_cast<int>(triangles.rows());
    input.facetlist = new tetgenio::facet[triangles.rows()];
    for (int t = 0; t < input.numberoffacets; ++t) {
        tetgenio::facet& facet = input.facetlist[t];
        tetgenio::init(&facet);
        facet.numberofpolygons = 1;
        facet.polygonlist = new tetgenio::polygon[1];
        tetgenio::init(facet.polygonlist);
        facet.polygonlist[0].numberofvertices = 3;
        facet.polygonlist[0].vertexlist = new int[3];
        for (int corner = 0; corner < 3; ++corner) facet.polygonlist[0].vertexlist[corner] = triangles(t, corner);
    }
}

[[noreturn]] void throw_tetgen_error(int code)
{
    switch (code) {
        case tetgen_self_intersection:
            throw InputError("the surface to fill with tetrahedra intersects itself");
        case tetgen_small_feature:
        case tetgen_close_facets:
            throw InputError("the surface to fill with tetrahedra has facets or vertices that all but touch");
        case tetgen_out_of_memory:
            throw Error("TetGen ran out of memory");
        default:
            throw Error(fmt::format("TetGen failed with code {}", code));
    }
}

using Face = std::array<int, 3>;

Face sorted_face(int a, int b, int c)
{
    Face face{a, b, c};
    std::sort(face.begin(), face.end());
    return face;
}

/// Faces that belong to one tetrahedron only, sorted.
std::vector<Face> boundary_faces(const Tetrahedra& tets)
{
    std::vector<Face> faces;
    faces.reserve(static_cast<std::size_t>(4 * tets.rows()));
    for (Eigen::Index t = 0; t < tets.rows(); ++t) {
        for (int left_out = 0; left_out < 4; ++left_out) {
            faces.push_back(
                sorted_face(tets(t, (left_out + 1) % 4), tets(t, (left_out + 2) % 4), tets(t, (left_out + 3) % 4)));
        }
    }
    std::sort(faces.begin(), faces.end());
    std::vector<Face> single;
    for (std::size_t i = 0; i < faces.size();) {
        std::size_t end = i + 1;
        while (end < faces.size() && faces[end] == faces[i]) ++end;
        if (end - i == 1) single.push_back(faces[i]);
        i = end;
    }
    return single;
}

/// TetGen is trusted with nothing that the callers build on: the input comes back as it was, and is filled.
void check_result(const TetrahedralMesh& mesh, const Eigen::Ref<const Points>& vertices,
                  const Eigen::Ref<const Triangles>& triangles)
{
    require(mesh.vertices.rows() >= vertices.rows() && mesh.vertices.topRows(vertices.rows()) == vertices,
            "TetGen did not keep the vertices of the surface");
    const Eigen::VectorXd volumes = tetrahedron_volumes(mesh.vertices, mesh.tetrahedra);
    Eigen::Index flattest = 0;
    const double smallest = volumes.minCoeff(&flattest);
    require(smallest > 0.0, "TetGen made tetrahedron {} with volume {:g} m^3", flattest, smallest);
    const double expected = enclosed_volume(vertices, triangles);
    require(std::abs(volumes.sum() - expected) <= 1e-9 * expected,
            "TetGen filled {:g} m^3 of a surface that encloses {:g} m^3", volumes.sum(), expected);
    std::vector<Face> skin;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        skin.push_back(sorted_face(triangles(t, 0), triangles(t, 1), triangles(t, 2)));
    }
    std::sort(skin.begin(), skin.end());
    require(boundary_faces(mesh.tetrahedra) == skin, "TetGen did not keep the triangles of the surface");
}

/// Leaves out vertices after the first `num_kept` that no tetrahedron has; TetGen may return some that it gave up.
void remove_loose_vertices(TetrahedralMesh& mesh, Eigen::Index num_kept)
{
    std::vector<bool> used(mesh.vertices.rows(), false);
    for (Eigen::Index i = 0; i < mesh.tetrahedra.size(); ++i) used[mesh.tetrahedra.data()[i]] = true;
    std::vector<int> number(mesh.vertices.rows());
    int next = 0;
    for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
        if (v >= num_kept && !used[v]) continue;
        mesh.vertices.row(next) = mesh.vertices.row(v).eval();
        number[v] = next++;
    }
    mesh.vertices.conservativeResize(next, 3);
    mesh.tetrahedra = mesh.tetrahedra.unaryExpr([&](int v) { return number[v]; }).eval();
}

TetrahedralMesh to_mesh(const tetgenio& output, Eigen::Index num_surface)
{
    require(output.numberoftetrahedra > 0 && output.numberofcorners == 4, "TetGen made no tetrahedra");
    TetrahedralMesh mesh;
    mesh.vertices = Eigen::Map<const Points>(output.pointlist, output.numberofpoints, 3);
    mesh.tetrahedra = Eigen::Map<const Tetrahedra>(output.tetrahedronlist, output.numberoftetrahedra, 4);
    for (Eigen::Index t = 0; t < mesh.tetrahedra.rows(); ++t) {
        auto tet = mesh.tetrahedra.row(t);
        if (tetrahedron_volume(mesh.vertices.row(tet[0]), mesh.vertices.row(tet[1]), mesh.vertices.row(tet[2]),
                               mesh.vertices.row(tet[3])) < 0.0) {
            std::swap(tet[2], tet[3]);
        }
    }
    remove_loose_vertices(mesh, num_surface);
    return mesh;
}

}  // namespace

TetrahedralMesh tetrahedralize(const Eigen::Ref<const Points>& vertices, const Eigen::Ref<const Triangles>& triangles,
                               double max_volume)
{
    const std::string defect = closed_surface_defect(vertices, triangles);
    require_input(defect.empty(), "the surface to fill with tetrahedra is not closed and outward ({})", defect);
    require_input(std::isfinite(max_volume), "the largest tetrahedron volume {} is not finite", max_volume);

    // p: fill a surface; Y: keep its triangles; M: do not merge coplanar ones; Q: quiet; d: look for intersections.
    TetrahedralMesh mesh;
    try {
        tetgenbehavior diagnosis = parse_switches("pdMQ");
        tetgenio surface;
        tetgenio intersecting;
        fill_input(surface, vertices, triangles);
        run_tetgen(diagnosis, surface, intersecting);
        require_input(intersecting.numberoftrifaces == 0,
                      "the surface to fill with tetrahedra intersects itself ({} triangles take part)",
                      intersecting.numberoftrifaces);

        tetgenbehavior behavior =
            parse_switches(max_volume > 0.0 ? fmt::format("pYMQq{}a1", radius_edge_ratio) : std::string("pYMQ"));
        if (max_volume > 0.0) behavior.maxvolume = max_volume;
        tetgenio input;
        tetgenio output;
        fill_input(input, vertices, triangles);
        run_tetgen(behavior, input, output);
        mesh = to_mesh(output, vertices.rows());
    } catch (const int code) {
        throw_tetgen_error(code);
    }
    check_result(mesh, vertices, triangles);
    return mesh;
}

}  // namespace ndg
