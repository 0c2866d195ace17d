// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/skeleton.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/tool.h"
#include "ndg/motion/motion_files.h"
#include "ndg/retarget/joint_map_proposal.h"

#include <fmt/format.h>

using namespace ndg;

int main(int argc, char** argv)
{
    std::string motion_path, output_path;
    int reference_frame = find_reference_frame;

    Tool tool("propose-joint-map",
              "Guesses how an unknown motion-capture skeleton drives ours, as a file to be edited.",
              "propose-joint-map --motion walk.bvh --output configs/joint-maps/my-rig.json");
    tool.input("motion", motion_path, "one motion of the rig: BVH, AMC (ASF beside it), DeepMimic or AMASS");
    tool.output("output", output_path, "joint map to write (JSON)");
    tool.parameter("reference-frame", reference_frame,
                   "frame in which the performer stands straight; -1: the zero pose where it stands, else the "
                   "straightest frame; -2: the zero pose as it is",
                   zero_pose_is_reference, 1000000000);

    return tool.run(argc, argv, [&] {
        const std::vector<MotionFile> files = find_motion_files({motion_path});
        require_input(files.size() == 1 && files[0].skip_reason.empty(), "{}: give one motion, not a folder",
                      motion_path);
        const MotionClip clip = read_motion(files[0]);
        const JointMapProposal proposal = propose_joint_map(clip, reference_frame);
        write_file(output_path,
                   joint_map_json(proposal.map, "Proposed for the rig of " + clip.name + "; please check"));
        for (const JointMapEntry& entry : proposal.map.entries) fmt::print("{}: {}\n", entry.joint, entry.source);
        for (const std::string& text : proposal.notes) fmt::print("note: {}\n", text);
        fmt::print("{}: {} of our {} joints are driven, of the source's {}\n", output_path, proposal.map.entries.size(),
                   num_standard_joints, clip.num_joints());
    });
}
