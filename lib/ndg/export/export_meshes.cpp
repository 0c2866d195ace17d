// SPDX-License-Identifier: Apache-2.0
#include "ndg/export/export_meshes.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/credits.h"
#include "ndg/io/mesh.h"

#include <algorithm>
#include <set>

namespace ndg {

#define NDG_EXPORT_FORMAT(extension, frames, contents, write, summary) \
    void write(const std::string&, const MeshSequence&);
#include "ndg/export/formats.def"
#undef NDG_EXPORT_FORMAT

namespace {

void check_meshes(const std::string& path, const MeshSequence& sequence)
{
    require(!sequence.meshes.empty() && sequence.num_frames > 0, "{} would hold no mesh", path);
    std::set<std::string> names;
    for (const ExportedMesh& mesh : sequence.meshes) {
        require(!mesh.name.empty() && names.insert(mesh.name).second, "{} would hold two meshes named \"{}\"", path,
                mesh.name);
        require(mesh.triangles.rows() > 0 && mesh.triangles.minCoeff() >= 0, "{}: {} has no or negative triangles",
                path, mesh.name);
        require(mesh.opacity >= 0.0f && mesh.opacity <= 1.0f, "{}: the opacity of {} is {}, not in [0, 1]", path,
                mesh.name, mesh.opacity);
    }
}

void check_rig(const std::string& path, const MeshSequence& sequence)
{
    const Rig& rig = *sequence.rig;
    const int num_joints = rig.num_joints(), num_frames = sequence.num_frames;
    const Eigen::Index num_vertices = rig.rest_vertices.rows();
    require(rig.mesh_idx >= 0 && rig.mesh_idx < int(sequence.meshes.size()) &&
                sequence.meshes[rig.mesh_idx].triangles.maxCoeff() < num_vertices,
            "{}: the rig's mesh does not fit", path);
    require(num_joints > 0 && int(rig.parents.size()) == num_joints && rig.joint_positions.rows() == num_joints,
            "{}: the rig's joints do not fit each other", path);
    for (int j = 0; j < num_joints; ++j)
        require(j == 0 ? rig.parents[j] == -1 : rig.parents[j] >= 0 && rig.parents[j] < j,
                "{}: the parent of joint {} is {}", path, rig.joint_names[j], rig.parents[j]);
    require((rig.weights.cols() == 4 || rig.weights.cols() == 8) && rig.weights.rows() == num_vertices &&
                rig.weight_joints.rows() == num_vertices && rig.weight_joints.cols() == rig.weights.cols() &&
                rig.weights.minCoeff() >= 0.0 && rig.weight_joints.minCoeff() >= 0 &&
                rig.weight_joints.maxCoeff() < num_joints,
            "{}: the rig's weights are not 4 or 8 of its joints a vertex", path);
    require((rig.weights.rowwise().sum().array() - 1.0).abs().maxCoeff() < 1e-9, "{}: weights do not sum to one", path);
    require(int(rig.rotations.size()) == num_frames && rig.root_translations.rows() == num_frames,
            "{}: the rig has {} frames instead of {}", path, rig.rotations.size(), num_frames);
    require(rig.morphs.empty() ||
                (rig.morph_weights.rows() == num_frames && rig.morph_weights.cols() == Eigen::Index(rig.morphs.size())),
            "{}: the weights of the morphs are {} x {}", path, rig.morph_weights.rows(), rig.morph_weights.cols());
    for (const Points& morph : rig.morphs)
        require(morph.rows() == num_vertices && morph.allFinite(), "{}: a morph does not fit", path);
}

void check_frame(const std::string& path, const ExportedMesh& mesh, const MeshFrame& frame)
{
    const Eigen::Index num_vertices = frame.vertices.rows();
    require(mesh.triangles.maxCoeff() < num_vertices, "{}: {} has a triangle index outside its {} vertices", path,
            mesh.name, num_vertices);
    require(frame.vertices.allFinite(), "{}: {} has a vertex that is not finite", path, mesh.name);
    require(frame.colours.rows() == 0 || frame.colours.rows() == num_vertices, "{}: {} has {} colours for {} vertices",
            path, mesh.name, frame.colours.rows(), num_vertices);
    for (const auto& [name, values] : frame.scalars)
        require(values.size() == num_vertices && values.allFinite(), "{}: {} of {} is not one finite value a vertex",
                path, name, mesh.name);
}

/// The same sequence, each frame checked as it is asked for.
MeshSequence checked(const std::string& path, const MeshSequence& sequence)
{
    check_meshes(path, sequence);
    MeshSequence result = sequence;
    result.frame = [path, &sequence, num_vertices = std::vector<Eigen::Index>()](int frame_idx) mutable {
        std::vector<MeshFrame> frames = sequence.frame(frame_idx);
        require(frames.size() == sequence.meshes.size(), "{}: frame {} has {} meshes instead of {}", path, frame_idx,
                frames.size(), sequence.meshes.size());
        for (std::size_t k = 0; k < frames.size(); ++k) {
            check_frame(path, sequence.meshes[k], frames[k]);
            if (num_vertices.size() == k) num_vertices.push_back(frames[k].vertices.rows());
            require(frames[k].vertices.rows() == num_vertices[k], "{}: {} has {} vertices in frame {} instead of {}",
                    path, sequence.meshes[k].name, frames[k].vertices.rows(), frame_idx, num_vertices[k]);
        }
        return frames;
    };
    return result;
}

void write_frames(const ExportFormat& format, const std::string& path, const std::vector<std::string>& files,
                  const MeshSequence& whole)
{
    if (format.frames == Frames::one_file || (format.frames == Frames::by_name && files[0] == path))
        return format.write(path, whole);
    require_input(!whole.rig, "{}: the frames of a skeleton go into one file, without a place of a number", path);
    MeshSequence single = whole;
    single.num_frames = 1;
    for (int i = 0; i < whole.num_frames; ++i) {
        single.frame = [&](int) { return whole.frame(i); };
        format.write(files[i], single);
    }
}

}  // namespace

const std::vector<ExportFormat>& export_formats()
{
    static const std::vector<ExportFormat> formats = {
#define NDG_EXPORT_FORMAT(extension, frames, contents, write, summary) \
    {extension, Frames::frames, Contents::contents, write, summary},
#include "ndg/export/formats.def"
#undef NDG_EXPORT_FORMAT
    };
    return formats;
}

const ExportFormat& export_format(const std::string& path)
{
    const std::string extension = lower_extension(path);
    std::string known;
    for (const ExportFormat& format : export_formats()) {
        if (format.extension == extension) return format;
        known += (known.empty() ? "" : ", ") + format.extension;
    }
    throw InputError(fmt::format("{}: meshes cannot be written as '{}'; known are {}", path, extension, known));
}

std::vector<std::string> exported_files(const std::string& path, int num_frames)
{
    if (export_format(path).frames == Frames::one_file) return {path};
    if (path.find_first_of("{}") == std::string::npos) {
        require_input(num_frames == 1 || export_format(path).frames == Frames::by_name,
                      "{}: {} frames need the place of their number in the name, like {{:04}}", path, num_frames);
        return {path};
    }
    return numbered_names(path, num_frames);
}

void export_meshes(const std::string& path, const MeshSequence& sequence)
{
    const ExportFormat& format = export_format(path);
    const std::vector<std::string> files = exported_files(path, sequence.num_frames);
    if (format.contents == Contents::volume) {
        require(sequence.volume.has_value() && sequence.num_frames > 0, "{} would hold no volume", path);
        return format.write(path, sequence);
    }
    require(!sequence.rig || format.contents == Contents::surfaces_and_rig, "{} cannot hold a skeleton", path);
    if (sequence.rig) check_rig(path, sequence);
    write_frames(format, path, files, checked(path, sequence));
    const bool has_room_for_credits = format.extension != ".stl" && format.extension != ".pc2";
    if (!has_room_for_credits) write_credits_beside(path, sequence.credits);
}

}  // namespace ndg
