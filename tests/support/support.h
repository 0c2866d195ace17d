// SPDX-License-Identifier: Apache-2.0
// What several test executables share.
#pragma once

#include "ndg/body/posing.h"
#include "ndg/body/template.h"

#include <string>

namespace ndg::test {

/// A fresh folder, removed with everything in it at the end of the scope.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    std::string file(const std::string& name) const { return path_ + "/" + name; }
    const std::string& path() const { return path_; }

private:
    std::string path_;
};

/// Folder of real data (environment NDG_DATA, which ctest sets from CMake's NDG_DATA), "" if there is none; prints one
/// line then.
std::string data_folder();

/// Runs a command, returns its exit code and both streams.
struct CommandResult {
    int exit_code = -1;
    std::string output;
};
CommandResult run_command(const std::string& command);
/// Path of one of our executables.
std::string tool_path(const std::string& name);

/// A small layered body without any file: a vertical tube of three concentric wraps (closed by no caps), two joints
/// along its axis (named after standard joints: all 60 exist, only left_upper_arm and left_forearm carry weight),
/// bone interior of tetrahedra around the axis, one embedded "bone". `rings` >= 3 rings of `segments` >= 3 vertices.
Template tube_template(int rings = 7, int segments = 8);
/// How the tube bends: its one bone would stay straight.
inline constexpr PosingOptions bending{BoneWrap::lbs};
/// A tube of segments of eight that is its own mirror image in x = 0: spine_2 below, each side's upper arm and forearm
/// above, blended over the middle.
Template symmetric_tube_template(int rings = 7);
/// The tube's elbow bent by `angle` radians about z at the middle joint.
Pose tube_pose(double angle);

}  // namespace ndg::test
