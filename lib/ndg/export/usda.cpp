// SPDX-License-Identifier: Apache-2.0
// USD as text: a mesh a surface with points over time, of one that moves as a rigid body (a bone) a transform over
// time; a mesh on a skeleton by UsdSkel (Skeleton with bind and rest transforms, SkelAnimation, joint indices and
// weights, blend shapes). Meshes of a group lie in a scope of its name. The credits are in customLayerData.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/provenance.h"
#include "ndg/export/mesh_sequence.h"
#include "ndg/export/rigid_motions.h"

#include <cctype>
#include <iterator>
#include <set>

namespace ndg {
namespace {

const std::string binding_schema = "prepend apiSchemas = [\"SkelBindingAPI\"]";

/// A name that USD takes: letters, digits and underscores, no digit first.
std::string identifier(const std::string& name)
{
    std::string result;
    for (const char c : name) result += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
    if (result.empty() || std::isdigit(static_cast<unsigned char>(result[0])) != 0) result = "_" + result;
    return result;
}

/// A text in quotes.
std::string quoted(const std::string& text)
{
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        if (c == '\n')
            result += "\\n";
        else
            result += c;
    }
    return result + "\"";
}

template <typename Count, typename Item>
std::string list(Count count, const Item& item)
{
    std::string text = "[";
    for (Count i = 0; i < count; ++i) {
        if (i > 0) text += ", ";
        item(text, i);
    }
    return text + "]";
}

/// Micrometres for a body: seven digits.
template <typename Row>
void add_vector(std::string& text, const Row& row)
{
    fmt::format_to(std::back_inserter(text), "({:.7g}, {:.7g}, {:.7g})", float(row[0]), float(row[1]), float(row[2]));
}

std::string vectors(const Points& points)
{
    return list(points.rows(), [&](std::string& text, Eigen::Index i) { add_vector(text, points.row(i)); });
}

std::string numbers(const RowMatrix& matrix)
{
    return list(matrix.size(), [&](std::string& text, Eigen::Index i) {
        fmt::format_to(std::back_inserter(text), "{:.7g}", float(matrix.data()[i]));
    });
}

std::string integers(const RowMatrixI& matrix)
{
    return list(matrix.size(), [&](std::string& text, Eigen::Index i) {
        fmt::format_to(std::back_inserter(text), "{}", matrix.data()[i]);
    });
}

std::string names(const std::vector<std::string>& names)
{
    return list(names.size(), [&](std::string& text, std::size_t i) { text += quoted(names[i]); });
}

std::string extent(const Points& points)
{
    Points corners(2, 3);
    corners << points.colwise().minCoeff(), points.colwise().maxCoeff();
    return vectors(corners);
}

/// As USD writes a matrix: rows, for points as rows.
std::string matrix(const Eigen::Isometry3d& motion)
{
    const Eigen::Matrix4d m = motion.matrix().transpose();
    std::string text = "( ";
    for (int i = 0; i < 4; ++i)
        text +=
            fmt::format("{}({:.9g}, {:.9g}, {:.9g}, {:.9g})", i > 0 ? ", " : "", m(i, 0), m(i, 1), m(i, 2), m(i, 3));
    return text + " )";
}

/// Text, indented by the prims that are open.
class UsdWriter {
public:
    explicit UsdWriter(const MeshSequence& sequence) : sequence_(sequence)
    {
        text_ = fmt::format(
            "#usda 1.0\n(\n    customLayerData = {{\n        string creator = {}\n        string licences = {}\n    "
            "}}\n"
            "    defaultPrim = \"body\"\n    endTimeCode = {}\n    framesPerSecond = {}\n    metersPerUnit = 1\n"
            "    startTimeCode = 0\n    timeCodesPerSecond = {}\n    upAxis = \"Y\"\n)\n\n",
            quoted("neural_deformation_gradients " + project_version()), quoted(sequence.credits),
            sequence.num_frames - 1, sequence.frame_rate, sequence.frame_rate);
    }

    void open(const std::string& kind, const std::string& name, const std::vector<std::string>& metadata = {})
    {
        line(fmt::format("def {} \"{}\"{}", kind, name, metadata.empty() ? "" : " ("));
        for (const std::string& entry : metadata) line("    " + entry);
        if (!metadata.empty()) line(")");
        line("{");
        ++depth_;
    }
    void close()
    {
        --depth_;
        line("}");
    }
    void line(const std::string& text) { text_ += std::string(4 * depth_, ' ') + text + "\n"; }
    void vertex_attribute(const std::string& type_and_name, const std::string& values, Eigen::Index values_per_vertex)
    {
        line(type_and_name + " = " + values + " (");
        line(fmt::format("    elementSize = {}", values_per_vertex));
        line("    interpolation = \"vertex\"");
        line(")");
    }
    /// An attribute, or its value in every frame.
    void attribute(const std::string& type_and_name, const std::string& value) { line(type_and_name + " = " + value); }
    template <typename Value>
    void samples(const std::string& type_and_name, const Value& value)
    {
        line(type_and_name + ".timeSamples = {");
        for (int f = 0; f < sequence_.num_frames; ++f) line(fmt::format("    {}: {},", f, value(f)));
        line("}");
    }

    void mesh(const ExportedMesh& mesh, const std::string& name, const std::vector<Points>& vertices, bool rigged)
    {
        std::vector<std::string> metadata = {"customData = {", "    string name = " + quoted(mesh.name)};
        if (mesh.fma_id != 0) metadata.push_back(fmt::format("    int fma_id = {}", mesh.fma_id));
        metadata.push_back("}");
        if (rigged) metadata.insert(metadata.begin(), binding_schema);
        open("Mesh", name, metadata);
        attribute("uniform token subdivisionScheme", "\"none\"");
        attribute("uniform bool doubleSided", mesh.two_sided ? "1" : "0");
        attribute("int[] faceVertexCounts", integers(RowMatrixI::Constant(mesh.triangles.rows(), 1, 3)));
        attribute("int[] faceVertexIndices", integers(mesh.triangles));
        const Eigen::RowVector3d colour = linear_from_srgb(mesh.colour).transpose().cast<double>();
        attribute("color3f[] primvars:displayColor", vectors(colour));
        attribute("float[] primvars:displayOpacity", fmt::format("[{:.7g}]", mesh.opacity));
        const auto motions = rigged || vertices.size() == 1 ? std::nullopt : rigid_motions(vertices);
        if (vertices.size() == 1 || motions) {
            attribute("point3f[] points", vectors(vertices[0]));
            attribute("float3[] extent", extent(vertices[0]));
        } else {
            samples("point3f[] points", [&](int f) { return vectors(vertices[f]); });
            samples("float3[] extent", [&](int f) { return extent(vertices[f]); });
        }
        if (motions) {
            samples("matrix4d xformOp:transform", [&](int f) { return matrix((*motions)[f]); });
            attribute("uniform token[] xformOpOrder", "[\"xformOp:transform\"]");
        }
    }

    /// What binds the open mesh at /body/NAME to the skeleton.
    void binding(const Rig& rig, const std::string& name)
    {
        attribute("rel skel:skeleton", "</body/skeleton>");
        attribute("matrix4d primvars:skel:geomBindTransform", matrix(Eigen::Isometry3d::Identity()));
        vertex_attribute("int[] primvars:skel:jointIndices", integers(rig.weight_joints), rig.weights.cols());
        vertex_attribute("float[] primvars:skel:jointWeights", numbers(rig.weights), rig.weights.cols());
        if (rig.morphs.empty()) return;
        std::vector<std::string> targets;
        for (const std::string& morph : morph_names(rig)) targets.push_back(fmt::format("</body/{}/{}>", name, morph));
        attribute("uniform token[] skel:blendShapes", names(morph_names(rig)));
        attribute("rel skel:blendShapeTargets", fmt::format("[{}]", fmt::join(targets, ", ")));
        for (std::size_t k = 0; k < rig.morphs.size(); ++k) {
            open("BlendShape", morph_names(rig)[k]);
            attribute("uniform vector3f[] offsets", vectors(rig.morphs[k]));
            close();
        }
    }

    void skeleton(const Rig& rig)
    {
        std::vector<std::string> paths;
        for (int j = 0; j < rig.num_joints(); ++j)
            paths.push_back((j > 0 ? paths[rig.parents[j]] + "/" : "") + identifier(rig.joint_names[j]));
        open("Skeleton", "skeleton", {binding_schema});
        attribute("uniform token[] joints", names(paths));
        const auto transforms = [&](const auto& position) {
            return list(rig.num_joints(), [&](std::string& text, int j) {
                Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
                transform.translation() = position(j).transpose();
                text += matrix(transform);
            });
        };
        attribute("uniform matrix4d[] bindTransforms",
                  transforms([&](int j) { return Eigen::RowVector3d(rig.joint_positions.row(j)); }));
        attribute("uniform matrix4d[] restTransforms", transforms([&](int j) { return rig.local_position(j); }));
        attribute("rel skel:animationSource", "</body/skeleton/motion>");
        open("SkelAnimation", "motion");
        attribute("uniform token[] joints", names(paths));
        samples("float3[] translations", [&](int f) {
            return list(rig.num_joints(), [&](std::string& text, int j) {
                Eigen::RowVector3d position = rig.local_position(j);
                if (j == 0) position += rig.root_translations.row(f);
                add_vector(text, position);
            });
        });
        samples("quatf[] rotations", [&](int f) {
            return list(rig.num_joints(), [&](std::string& text, int j) {
                const Eigen::Quaterniond& q = rig.rotations[f][j];
                fmt::format_to(std::back_inserter(text), "({:.7g}, {:.7g}, {:.7g}, {:.7g})", q.w(), q.x(), q.y(),
                               q.z());
            });
        });
        attribute("half3[] scales", list(rig.num_joints(), [](std::string& text, int) { text += "(1, 1, 1)"; }));
        if (!rig.morphs.empty()) {
            attribute("uniform token[] blendShapes", names(morph_names(rig)));
            // Some readers want the value outside of time too.
            attribute("float[] blendShapeWeights", numbers(RowMatrix::Zero(1, Eigen::Index(rig.morphs.size()))));
            samples("float[] blendShapeWeights", [&](int f) { return numbers(rig.morph_weights.row(f)); });
        }
        close();
        close();
    }
    const std::string& text() const { return text_; }

private:
    static std::vector<std::string> morph_names(const Rig& rig)
    {
        std::vector<std::string> result;
        for (std::size_t k = 0; k < rig.morphs.size(); ++k) result.push_back(fmt::format("corrective_{}", k));
        return result;
    }

    const MeshSequence& sequence_;
    std::string text_;
    std::size_t depth_ = 0;
};

}  // namespace

void write_usda(const std::string& path, const MeshSequence& sequence)
{
    const std::optional<Rig>& rig = sequence.rig;
    std::vector<std::vector<Points>> vertices(sequence.meshes.size());  // mesh, frame
    for (int f = 0; f < sequence.num_frames; ++f) {
        if (rig && sequence.meshes.size() == 1) break;
        std::vector<MeshFrame> frames = sequence.frame(f);
        for (std::size_t k = 0; k < frames.size(); ++k) vertices[k].push_back(std::move(frames[k].vertices));
    }
    if (rig) vertices[rig->mesh_idx] = {rig->rest_vertices};

    UsdWriter usd(sequence);
    usd.open(rig ? "SkelRoot" : "Xform", "body");
    if (rig) usd.skeleton(*rig);
    std::set<std::string> groups, taken = {"/skeleton"};
    for (const ExportedMesh& mesh : sequence.meshes) {
        groups.insert(mesh.group);  // the empty one comes first
        taken.insert("/" + identifier(mesh.group));
    }
    for (const std::string& group : groups) {
        if (!group.empty()) usd.open("Scope", identifier(group));
        for (std::size_t k = 0; k < sequence.meshes.size(); ++k) {
            const ExportedMesh& mesh = sequence.meshes[k];
            if (mesh.group != group) continue;
            std::string name = identifier(mesh.name);
            while (!taken.insert(group + "/" + name).second) name += "_";
            const bool rigged = rig && int(k) == rig->mesh_idx;
            usd.mesh(mesh, name, vertices[k], rigged);
            if (rigged) usd.binding(*rig, name);
            usd.close();
        }
        if (!group.empty()) usd.close();
    }
    usd.close();
    write_file(path, usd.text());
}

}  // namespace ndg
