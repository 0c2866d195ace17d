// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/template.h"

#include "ndg/core/error.h"
#include "ndg/core/hash.h"
#include "ndg/geometry/tetrahedra.h"
#include "ndg/io/h5.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace ndg {

namespace {

constexpr const char* format_name = "ndg-template";
constexpr int format_version = 2;
/// How far rows of weights may be from summing to one.
constexpr double sum_tolerance = 1e-6;

void write_weights(H5Writer& writer, const std::string& group, const SkinningWeights& weights, const std::string& rows)
{
    writer.write(group + "/weight_joints", weights.joints, "joints that move each " + rows + " vertex, unused slots 0");
    writer.write(group + "/weights", weights.weights, "skinning weights of those joints, rows sum to one",
                 Storage::float64);
}

/// Every row non-negative but for `slack`, and summing to one; to zero where `elements` is -1.
void check_weight_rows(const H5Reader& reader, const std::string& dataset, const Eigen::Ref<const RowMatrix>& weights,
                       double slack, const std::vector<int>* elements = nullptr)
{
    for (Eigen::Index i = 0; i < weights.rows(); ++i) {
        double sum = 0.0;
        for (Eigen::Index k = 0; k < weights.cols(); ++k) {
            require_input(weights(i, k) >= -slack && weights(i, k) <= 1.0 + slack,
                          "{}: {}[{}, {}] is {}, not a weight between 0 and 1", reader.path(), dataset, i, k,
                          weights(i, k));
            sum += weights(i, k);
        }
        const double expected = elements && (*elements)[i] < 0 ? 0.0 : 1.0;
        require_input(std::abs(sum - expected) <= sum_tolerance, "{}: {}[{}] sums to {} instead of {}", reader.path(),
                      dataset, i, sum, expected);
    }
}

SkinningWeights read_weights(const H5Reader& reader, const std::string& group, Eigen::Index rows, int num_joints)
{
    SkinningWeights weights;
    weights.joints = reader.read_int_matrix(group + "/weight_joints", rows, max_influences, 0, num_joints - 1);
    weights.weights = reader.read_matrix(group + "/weights", rows, max_influences);
    check_weight_rows(reader, group + "/weights", weights.weights, 0.0);
    return weights;
}

Skeleton read_skeleton(const H5Reader& reader)
{
    const Skeleton& expected = standard_skeleton();
    Skeleton skeleton;
    skeleton.joint_names = reader.read_strings("/skeleton/joint_names", num_standard_joints);
    skeleton.parents = reader.read_ints("/skeleton/parents", num_standard_joints, -1, num_standard_joints - 1);
    for (std::size_t j = 0; j < skeleton.parents.size(); ++j) {
        require_input(skeleton.joint_names[j] == expected.joint_names[j],
                      "{}: /skeleton/joint_names[{}] is \"{}\" instead of \"{}\"", reader.path(), j,
                      skeleton.joint_names[j], expected.joint_names[j]);
        require_input(skeleton.parents[j] < static_cast<int>(j),
                      "{}: /skeleton/parents[{}] is {}, but parents stand before their children", reader.path(), j,
                      skeleton.parents[j]);
        require_input(skeleton.parents[j] == expected.parents[j], "{}: /skeleton/parents[{}] is {} instead of {}",
                      reader.path(), j, skeleton.parents[j], expected.parents[j]);
    }
    return skeleton;
}

void write_anatomy(H5Writer& writer, const Template& body_template)
{
    std::vector<std::string> names, layers, sides;
    std::vector<int> fma_ids;
    RowMatrixI ranges(static_cast<Eigen::Index>(body_template.anatomy_parts.size()), 4);
    for (const AnatomyPart& part : body_template.anatomy_parts) {
        const auto row = static_cast<Eigen::Index>(names.size());
        ranges.row(row) << part.vertex_begin, part.vertex_end, part.triangle_begin, part.triangle_end;
        names.push_back(part.name);
        layers.push_back(to_name(part.layer));
        sides.push_back(to_name(part.side));
        fma_ids.push_back(part.fma_id);
    }
    const Embedding& embedding = body_template.embedding;
    writer.write("/anatomy/vertices", body_template.anatomy_vertices, "rest positions of the anatomy, m",
                 Storage::float64);
    writer.write("/anatomy/triangles", body_template.anatomy_triangles, "indices into /anatomy/vertices");
    writer.write("/anatomy/part_names", names, "names of the parts");
    writer.write("/anatomy/part_layers", layers, "bone or muscle, for each part");
    writer.write("/anatomy/part_sides", sides, "left, right or middle, for each part");
    writer.write("/anatomy/part_fma_ids", fma_ids, "Foundational Model of Anatomy id of each part, 0 for none");
    writer.write("/anatomy/part_ranges", ranges, "vertex begin, vertex end, triangle begin, triangle end of each part");
    writer.write("/anatomy/embedding_elements", embedding.elements,
                 "prism of each anatomy vertex, or number of prisms + tetrahedron; -1: skinned, not embedded");
    writer.write("/anatomy/embedding_vertices", embedding.vertices,
                 "indices into volume vertices followed by bone interior vertices, unused columns 0");
    writer.write("/anatomy/embedding_weights", embedding.weights,
                 "weights of those vertices, rows sum to one (to zero where skinned)", Storage::float64);
    writer.write("/anatomy/embedding_distances", embedding.distances,
                 "distance of each anatomy vertex to its element, m, 0 inside");
    write_weights(writer, "/anatomy", body_template.anatomy_weights, "anatomy");
}

void read_anatomy_parts(const H5Reader& reader, Template& result)
{
    const std::vector<std::string> names = reader.read_strings("/anatomy/part_names");
    const auto count = static_cast<std::int64_t>(names.size());
    const std::vector<std::string> layers = reader.read_strings("/anatomy/part_layers", count);
    const std::vector<std::string> sides = reader.read_strings("/anatomy/part_sides", count);
    const std::vector<int> fma_ids =
        reader.read_ints("/anatomy/part_fma_ids", count, 0, std::numeric_limits<int>::max());
    const RowMatrixI ranges =
        reader.read_int_matrix("/anatomy/part_ranges", count, 4, 0, std::numeric_limits<int>::max());
    for (Eigen::Index i = 0; i < count; ++i) {
        const auto p = static_cast<std::size_t>(i);
        const auto item = [&](const char* dataset) { return fmt::format("{}: {}[{}]", reader.path(), dataset, i); };
        const auto layer = parse_name<AnatomyLayer>(layers[p], item("/anatomy/part_layers"));
        const auto side = parse_name<BodySide>(sides[p], item("/anatomy/part_sides"));
        require_input(ranges(i, 0) <= ranges(i, 1) && ranges(i, 1) <= result.anatomy_vertices.rows() &&
                          ranges(i, 2) <= ranges(i, 3) && ranges(i, 3) <= result.anatomy_triangles.rows(),
                      "{}: /anatomy/part_ranges[{}] is {}..{} and {}..{}, outside of {} vertices and {} triangles",
                      reader.path(), i, ranges(i, 0), ranges(i, 1), ranges(i, 2), ranges(i, 3),
                      result.anatomy_vertices.rows(), result.anatomy_triangles.rows());
        for (Eigen::Index t = ranges(i, 2); t < ranges(i, 3); ++t) {
            for (Eigen::Index k = 0; k < 3; ++k) {
                const int vertex = result.anatomy_triangles(t, k);
                require_input(vertex >= ranges(i, 0) && vertex < ranges(i, 1),
                              "{}: /anatomy/triangles[{}] has vertex {}, which is not of its part {}", reader.path(), t,
                              vertex, names[p]);
            }
        }
        result.anatomy_parts.push_back(
            {names[p], layer, ranges(i, 0), ranges(i, 1), ranges(i, 2), ranges(i, 3), fma_ids[p], side});
    }
}

void read_anatomy(const H5Reader& reader, Template& result)
{
    result.anatomy_vertices = reader.read_matrix("/anatomy/vertices", -1, 3);
    const Eigen::Index count = result.anatomy_vertices.rows();
    result.anatomy_triangles = reader.read_int_matrix("/anatomy/triangles", -1, 3, 0, static_cast<int>(count) - 1);
    read_anatomy_parts(reader, result);

    Embedding& embedding = result.embedding;
    const auto num_elements = static_cast<int>(result.prisms.rows() + result.tetrahedra.rows());
    const auto num_vertices = static_cast<int>(result.num_volume_vertices() + result.rest.interior_vertices.rows());
    embedding.elements = reader.read_ints("/anatomy/embedding_elements", count, -1, num_elements - 1);
    embedding.vertices = reader.read_int_matrix("/anatomy/embedding_vertices", count, 6, 0, num_vertices - 1);
    embedding.weights = reader.read_matrix("/anatomy/embedding_weights", count, 6);
    check_weight_rows(reader, "/anatomy/embedding_weights", embedding.weights, sum_tolerance, &embedding.elements);
    embedding.distances = reader.read_doubles("/anatomy/embedding_distances", count);
    for (std::size_t i = 0; i < embedding.distances.size(); ++i) {
        require_input(embedding.distances[i] >= 0.0, "{}: /anatomy/embedding_distances[{}] is {}, below zero",
                      reader.path(), i, embedding.distances[i]);
    }
    result.anatomy_weights = read_weights(reader, "/anatomy", count, result.skeleton.num_joints());
}

void write_skin(H5Writer& writer, const Template& body_template)
{
    writer.write("/skin/vertices", body_template.rest.skin_vertices, "rest positions of the whole skin, m",
                 Storage::float64);
    writer.write("/skin/triangles", body_template.skin_triangles, "indices into /skin/vertices, outward");
    write_weights(writer, "/skin", body_template.skin_weights, "skin");
    writer.write("/skin/region_names", body_template.skin_region_names,
                 "regions of the skin, the volumetric one first");
    writer.write("/skin/regions", body_template.skin_regions, "region of each triangle");
    std::vector<std::string> names;
    std::vector<int> triangles;
    RowMatrix barycentric(static_cast<Eigen::Index>(body_template.landmarks.size()), 3);
    for (const Landmark& landmark : body_template.landmarks) {
        barycentric.row(static_cast<Eigen::Index>(names.size())) = landmark.barycentric.transpose();
        names.push_back(landmark.name);
        triangles.push_back(landmark.skin_triangle_idx);
    }
    writer.write("/landmarks/names", names, "named points of the skin");
    writer.write("/landmarks/skin_triangles", triangles, "skin triangle of each landmark");
    writer.write("/landmarks/barycentric", barycentric, "barycentric coordinates on it", Storage::float64);
}

void read_skin(const H5Reader& reader, Template& result)
{
    result.rest.skin_vertices = reader.read_matrix("/skin/vertices", -1, 3);
    const Eigen::Index num_skin = result.rest.skin_vertices.rows();
    result.skin_triangles = reader.read_int_matrix("/skin/triangles", -1, 3, 0, static_cast<int>(num_skin) - 1);
    result.skin_weights = read_weights(reader, "/skin", num_skin, result.skeleton.num_joints());
    const auto num_triangles = static_cast<std::int64_t>(result.skin_triangles.rows());
    result.skin_region_names = reader.read_strings("/skin/region_names");
    const auto num_regions = static_cast<int>(result.skin_region_names.size());
    result.skin_regions = reader.read_ints("/skin/regions", num_regions > 0 ? num_triangles : 0, 0, num_regions - 1);
    const std::vector<std::string> names = reader.read_strings("/landmarks/names");
    const auto count = static_cast<std::int64_t>(names.size());
    const std::vector<int> triangles =
        reader.read_ints("/landmarks/skin_triangles", count, 0, static_cast<int>(num_triangles) - 1);
    const RowMatrix barycentric = reader.read_matrix("/landmarks/barycentric", count, 3);
    check_weight_rows(reader, "/landmarks/barycentric", barycentric, sum_tolerance);
    for (std::size_t i = 0; i < names.size(); ++i)
        result.landmarks.push_back({names[i], triangles[i], barycentric.row(static_cast<Eigen::Index>(i)).transpose()});
}

void read_volume(const H5Reader& reader, Template& result)
{
    const auto num_skin = static_cast<int>(result.rest.skin_vertices.rows());
    result.wrap_to_skin = reader.read_ints("/volume/wrap_to_skin", -1, 0, num_skin - 1);
    std::vector<int> wrap_of_skin(num_skin, -1);
    for (std::size_t i = 0; i < result.wrap_to_skin.size(); ++i) {
        int& earlier = wrap_of_skin[result.wrap_to_skin[i]];
        require_input(earlier < 0, "{}: /volume/wrap_to_skin[{}] is skin vertex {}, which entry {} has already",
                      reader.path(), i, result.wrap_to_skin[i], earlier);
        earlier = static_cast<int>(i);
    }
    const int num_wrap = result.num_wrap_vertices();
    result.wrap_triangles = reader.read_int_matrix("/volume/wrap_triangles", -1, 3, 0, num_wrap - 1);
    result.prisms = reader.read_int_matrix("/volume/prisms", 2 * result.wrap_triangles.rows(), 6, 0, 3 * num_wrap - 1);
    const Prisms expected = layer_prisms(result.wrap_triangles, num_wrap);
    for (Eigen::Index p = 0; p < expected.rows(); ++p) {
        require_input(result.prisms.row(p) == expected.row(p),
                      "{}: /volume/prisms[{}] does not join the layers over its triangle of /volume/wrap_triangles",
                      reader.path(), p);
    }
    result.rest.volume_vertices = reader.read_matrix("/volume/vertices", 3 * num_wrap, 3);
    const PrismCheck check = check_prisms(result.rest.volume_vertices, result.prisms);
    require_input(check.num_invalid == 0,
                  "{}: {} rest prisms of /volume are not valid, the worst is prism {} with Jacobian {} m^3",
                  reader.path(), check.num_invalid, check.worst_prism_idx, check.min_jacobian);

    result.rest.interior_vertices = reader.read_matrix("/bone_interior/vertices", -1, 3);
    const Eigen::Index num_interior = result.rest.interior_vertices.rows();
    result.tetrahedra =
        reader.read_int_matrix("/bone_interior/tetrahedra", -1, 4, 0, num_wrap + static_cast<int>(num_interior) - 1);
    Points vertices(num_wrap + num_interior, 3);
    vertices << result.rest.volume_vertices.topRows(num_wrap), result.rest.interior_vertices;
    const Eigen::VectorXd volumes = tetrahedron_volumes(vertices, result.tetrahedra);
    for (Eigen::Index t = 0; t < volumes.size(); ++t) {
        require_input(volumes[t] > 0.0, "{}: /bone_interior/tetrahedra[{}] has volume {} m^3", reader.path(), t,
                      volumes[t]);
    }
    result.interior_weights = read_weights(reader, "/bone_interior", num_interior, result.skeleton.num_joints());
}

void read_source(const H5Reader& reader, Template& result)
{
    const std::vector<std::size_t> shape = reader.shape("/source/vertices");
    const bool has_source = !shape.empty() && shape[0] > 0;
    const Eigen::Index rows = has_source ? result.rest.skin_vertices.rows() : 0;
    result.source_vertices = reader.read_int_matrix("/source/vertices", rows, 3, 0, std::numeric_limits<int>::max());
    result.source_barycentric = reader.read_matrix("/source/barycentric", rows, 3);
    check_weight_rows(reader, "/source/barycentric", result.source_barycentric, sum_tolerance);
    result.source_joint_offsets =
        reader.read_matrix("/source/joint_offsets", has_source ? result.skeleton.num_joints() : 0, 3);
}

using FloatPoints = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

void write_examples(H5Writer& writer, const std::vector<Skin>& examples, const std::string& dataset,
                    const std::string& description, Points Skin::*positions)
{
    writer.create(dataset, {examples.size(), static_cast<std::size_t>((examples.front().*positions).rows()), 3},
                  description);
    for (std::size_t e = 0; e < examples.size(); ++e) {
        const FloatPoints stored = (examples[e].*positions).cast<float>();
        writer.write_slice(dataset, e, stored.data());
    }
}

void read_examples(const H5Reader& reader, const std::string& dataset, Eigen::Index rows, std::vector<Skin>& examples,
                   Points Skin::*positions)
{
    const std::vector<std::size_t> shape = reader.shape(dataset);
    require_input(shape.size() == 3 && (examples.empty() || shape[0] == examples.size()) &&
                      shape[1] == static_cast<std::size_t>(rows) && shape[2] == 3,
                  "{}: {} has shape {}, not one of examples x {} x 3", reader.path(), dataset, fmt::join(shape, " x "),
                  rows);
    examples.resize(shape[0]);
    for (std::size_t e = 0; e < examples.size(); ++e) {
        const std::vector<float> stored = reader.read_slice(dataset, e);
        examples[e].name = fmt::format("example_{:04d}", e);
        examples[e].*positions = Eigen::Map<const FloatPoints>(stored.data(), rows, 3).cast<double>();
    }
}

}  // namespace

SkinningWeights Template::volume_weights() const
{
    std::vector<int> rows;
    rows.reserve(3 * wrap_to_skin.size());
    for (int layer = 0; layer < 3; ++layer) rows.insert(rows.end(), wrap_to_skin.begin(), wrap_to_skin.end());
    return select_weights(skin_weights, rows);
}

std::vector<int> Template::visible_joints() const
{
    constexpr double visible_weight = 1e-3;
    const SkinningWeights weights = volume_weights();
    std::vector<int> visible(skeleton.num_joints(), 0);
    for (Eigen::Index i = 0; i < weights.size(); ++i)
        for (int k = 0; k < max_influences; ++k)
            if (weights.weights(i, k) >= visible_weight) visible[weights.joints(i, k)] = 1;
    // A joint turns its descendants too; parents come before children.
    for (int joint = skeleton.num_joints() - 1; joint > 0; --joint)
        if (visible[joint]) visible[skeleton.parents[joint]] = 1;
    if (!visible.empty()) visible[0] = 0;
    return visible;
}

SkinningWeights Template::prism_weights() const
{
    return element_weights(volume_weights(), prisms, skeleton.num_joints());
}

Prisms layer_prisms(const Eigen::Ref<const Triangles>& wrap_triangles, int num_wrap_vertices)
{
    const Eigen::Index count = wrap_triangles.rows();
    Prisms prisms(2 * count, 6);
    prisms.topRows(count) << wrap_triangles.array() + num_wrap_vertices, wrap_triangles;
    prisms.bottomRows(count) << wrap_triangles.array() + 2 * num_wrap_vertices,
        wrap_triangles.array() + num_wrap_vertices;
    return prisms;
}

void write_template(const std::string& path, const Template& body_template, const Provenance& provenance)
{
    const Body& rest = body_template.rest;
    H5Writer writer(path, format_name, format_version, provenance);
    writer.attribute("body_name", rest.name);
    writer.attribute("source_name", body_template.source_name);
    writer.write("/skeleton/joint_names", body_template.skeleton.joint_names, "names of the joints");
    writer.write("/skeleton/parents", body_template.skeleton.parents, "parent of each joint, -1 for the root");
    writer.write("/skeleton/joint_positions", rest.joint_positions, "rest positions of the joints, m",
                 Storage::float64);

    write_skin(writer, body_template);

    writer.write("/volume/wrap_to_skin", body_template.wrap_to_skin, "skin vertex of each wrap vertex");
    writer.write("/volume/wrap_triangles", body_template.wrap_triangles, "indices into one wrap, outward");
    writer.write("/volume/prisms", body_template.prisms,
                 "outer triangle, inner triangle; indices into /volume/vertices; muscle layer, then fat layer");
    writer.write("/volume/vertices", rest.volume_vertices,
                 "rest positions of bone wrap, muscle wrap and volumetric skin, m", Storage::float64);

    writer.write("/bone_interior/vertices", rest.interior_vertices, "rest positions inside the bone wrap, m",
                 Storage::float64);
    writer.write("/bone_interior/tetrahedra", body_template.tetrahedra,
                 "indices into bone wrap vertices followed by bone interior vertices");
    write_weights(writer, "/bone_interior", body_template.interior_weights, "bone interior");

    write_anatomy(writer, body_template);

    // Arrays never set have no columns; on file they are 0 x 3.
    const bool has_source = body_template.source_vertices.rows() > 0;
    writer.write("/source/vertices", has_source ? body_template.source_vertices : RowMatrixI(0, 3),
                 "vertices of the parametric source's base mesh under each skin vertex");
    writer.write("/source/barycentric", has_source ? body_template.source_barycentric : RowMatrix(0, 3),
                 "barycentric coordinates on them", Storage::float64);
    writer.write("/source/joint_offsets", has_source ? body_template.source_joint_offsets : Points(0, 3),
                 "from the source's own joints to those of the template body, m", Storage::float64);
    if (!body_template.examples.empty()) {
        write_examples(writer, body_template.examples, "/examples/skin_vertices",
                       "rest positions of the skins of people of the source, m", &Skin::skin_vertices);
        write_examples(writer, body_template.examples, "/examples/joint_positions", "rest positions of their joints, m",
                       &Skin::joint_positions);
    }
    writer.commit();
}

Template read_template(const std::string& path)
{
    const H5Reader reader(path, format_name, format_version);
    Template result;
    result.rest.name = reader.attribute("body_name");
    result.source_name = reader.attribute("source_name");
    result.skeleton = read_skeleton(reader);
    result.rest.joint_positions = reader.read_matrix("/skeleton/joint_positions", num_standard_joints, 3);
    read_skin(reader, result);
    read_volume(reader, result);
    read_anatomy(reader, result);
    read_source(reader, result);
    if (reader.has("/examples/skin_vertices")) {
        read_examples(reader, "/examples/skin_vertices", result.rest.skin_vertices.rows(), result.examples,
                      &Skin::skin_vertices);
        read_examples(reader, "/examples/joint_positions", result.skeleton.num_joints(), result.examples,
                      &Skin::joint_positions);
    }
    result.file_sha256 = sha256_path(path);
    return result;
}

}  // namespace ndg
