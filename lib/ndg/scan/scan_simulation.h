// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/scan/scan.h"
#include "ndg/scan/scan_fault.h"
#include "ndg/scan/skin_places.h"

#include <cstdint>

namespace ndg {

/// What a scanner does to a body.
struct ScanSimulationOptions {
    int points = 40000;         ///< about so many
    double noise = 0.0015;      ///< standard deviation along the normal, m
    double pose_angle = 8.0;    ///< degrees: shoulders, elbows, hips and knees turn by up to this
    double hole_radius = 0.05;  ///< m, of the holes at armpits and crotch; 0: no holes there, on the head or the soles
    bool cloud = false;         ///< points without triangles
    bool place = true;          ///< random heading and position; else where the skin stands
    ScanFault fault = ScanFault::none;
};
void describe(OptionList& list, ScanSimulationOptions& options);

struct SimulatedScan {
    Scan scan;
    Pose pose;                  ///< on the skin's own joints, including heading and position
    Points posed_skin;          ///< N x 3, the true surface in the skin's tessellation
    Points posed_joints;        ///< J x 3
    std::vector<char> covered;  ///< N, 1 where the scan shows clothes or hair instead of the skin
    SkinnedSurface person;      ///< who was scanned, at rest: the skin given, but for ScanFault::child
};

/// A scan of a skin: posed by linear blend skinning with random rotations, triangulated anew (edges split to one
/// length, vertices moved at random within their triangles, edges flipped), with holes at armpits, crotch, soles and
/// the top of the head, and noise along the normal. Without noise all points lie on the posed skin, but for what the
/// fault adds.
/// Depends on (seed, body_idx) alone.
SimulatedScan simulate_scan(const SkinnedSurface& skin, const ScanSimulationOptions& options, std::uint64_t seed,
                            int body_idx);

}  // namespace ndg
