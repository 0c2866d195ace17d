// SPDX-License-Identifier: Apache-2.0
#include "ndg/avatar/avatar.h"
#include "ndg/capture/import_capture.h"
#include "ndg/core/error.h"
#include "ndg/core/tool.h"

#include <fmt/format.h>

int main(int argc, char** argv)
{
    using namespace ndg;
    std::vector<std::string> paths;
    std::string avatar_path, poses_path, output_path, licence;
    CaptureImportOptions options;

    Tool tool("import-capture",
              "Reads captured surfaces in motion that are registered to a body's skin: folders of OBJ or PLY files, "
              ".npy, .npz, HDF5 of frames x vertices x 3 or of DFAUST's and Dyna's layout.",
              "import-capture --avatar avatar.h5 --sequence jumping_jacks/ --sequence running.npy --poses poses.h5 "
              "--output capture.h5");
    tool.input("avatar", avatar_path, "avatar of the person, whose skin the frames are registered to (make-avatar)");
    tool.input("sequence", paths, "sequences: a folder is one, files may hold several");
    tool.input("poses", poses_path,
               "poses of the avatar's skeleton fitted to the frames, each clip called as a sequence; without them a "
               "capture can be looked at, not measured",
               false);
    tool.output("output", output_path, "capture to write");
    tool.options(options);
    tool.parameter("licence", licence, "licence and credit line of the capture, kept in the output");

    return tool.run(argc, argv, [&] {
        const Avatar avatar = read_avatar(avatar_path);
        const CaptureSurface surface{avatar.skin_vertices.rows(), avatar.whole_skin_triangles};
        Capture capture;
        capture.subject = avatar.name;
        capture.triangles = avatar.whole_skin_triangles;
        const auto say = [](const std::string& line) { fmt::print("{}\n", line); };
        for (const std::string& path : paths) {
            for (CaptureSequence& sequence : import_sequences(path, surface, options, say)) {
                for (const CaptureSequence& other : capture.sequences) {
                    require_input(other.name != sequence.name, "{}: there are two sequences called \"{}\"", path,
                                  sequence.name);
                }
                capture.sequences.push_back(std::move(sequence));
            }
        }
        if (!poses_path.empty()) {
            const PoseSet poses = read_poses(poses_path);
            const auto num_joints = static_cast<std::size_t>(avatar.skeleton.num_joints());
            require_input(poses.size() > 0 && poses.poses[0].parent_from_joint.size() == num_joints,
                          "{}: its poses are not of the {} joints of {}", poses_path, num_joints, avatar_path);
            capture.joint_names = avatar.skeleton.joint_names;
            for (CaptureSequence& sequence : capture.sequences) attach_poses(sequence, poses, poses_path);
        }
        write_capture(output_path, capture, tool.provenance(licence));
        fmt::print("{}: {} sequences of {} vertices{}\n", output_path, capture.sequences.size(), surface.num_vertices,
                   capture.has_poses() ? ", with poses" : "; without poses it cannot be measured");
    });
}
