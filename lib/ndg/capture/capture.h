// SPDX-License-Identifier: Apache-2.0
// Captures: surfaces of a person in motion, registered to the tessellation of the person's skin frame by frame.
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/provenance.h"
#include "ndg/core/types.h"

#include <string>
#include <vector>

namespace ndg {

/// One motion of it.
struct CaptureSequence {
    std::string name;
    double frame_rate_hertz = 60;
    /// Number of each frame that is there, counted from where the recording begins; ascending. A gap is a frame that is
    /// missing.
    std::vector<int> frame_numbers;
    std::vector<Points> vertices;  ///< one a frame: N x 3, m
    std::vector<Pose> poses;       ///< one a frame, fitted to it; or none

    int num_frames() const { return static_cast<int>(frame_numbers.size()); }
    /// From the first frame to the last, missing ones among them.
    int num_recorded() const { return frame_numbers.empty() ? 0 : frame_numbers.back() - frame_numbers.front() + 1; }
    /// From the first frame to the last.
    double seconds() const { return num_frames() < 2 ? 0 : (num_recorded() - 1) / frame_rate_hertz; }
};

struct Capture {
    std::string subject;
    Triangles triangles;  ///< T x 3, of the whole skin
    std::vector<CaptureSequence> sequences;
    std::vector<std::string> joint_names;  ///< of the poses, if there are any
    /// Of a twin, whose truth is known: Young's modulus of the fat below each vertex over that of its kind, N; 0 where
    /// there is no flesh. Empty for a person.
    std::vector<double> true_stiffness;

    bool has_poses() const { return !sequences.empty() && !sequences[0].poses.empty(); }
    /// Throws InputError where there is none of that name.
    const CaptureSequence& sequence(const std::string& name) const;
    /// Throws InputError naming `where`, sequence and value: other numbers of vertices or poses than there should be,
    /// frames that do not ascend, values that are not finite, indices out of range, poses for some sequences alone.
    void check(const std::string& where) const;
};

/// Format "ndg-capture", version 1 (docs/formats.md). Vertices are stored in single precision.
void write_capture(const std::string& path, const Capture& capture, const Provenance& provenance);
Capture read_capture(const std::string& path);

}  // namespace ndg
