// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/skeleton.h"
#include "ndg/core/enum_names.h"
#include "ndg/core/random.h"
#include "ndg/scan/skin_places.h"

#include <vector>

namespace ndg {

/// What makes a simulated scan a difficult one.
enum class ScanFault {
    none,
    pieces,           ///< shells of their own for arms, head, legs, front and back; those of the arms inside out
    clothes,          ///< trousers and shoes
    floor,            ///< a floor under the feet and a thing beside it
    t_pose,           ///< arms held sideways
    arms_raised,      ///< arms above the shoulders
    large_triangles,  ///< some 3000 triangles
    hair,             ///< 3 cm of it
    fists,
    no_feet,  ///< cut off above the ankles
    child,    ///< of 0.7 times the stature, with the head of a child
    mirrored  ///< left and right exchanged, and with them inside and outside
};
template <>
inline constexpr EnumName<ScanFault> enum_table<ScanFault>[] = {
    {ScanFault::none, "none"},       {ScanFault::pieces, "pieces"},
    {ScanFault::clothes, "clothes"}, {ScanFault::floor, "floor"},
    {ScanFault::t_pose, "t-pose"},   {ScanFault::arms_raised, "arms-raised"},
    {ScanFault::hair, "hair"},       {ScanFault::large_triangles, "large-triangles"},
    {ScanFault::fists, "fists"},     {ScanFault::no_feet, "no-feet"},
    {ScanFault::child, "child"},     {ScanFault::mirrored, "mirrored"}};

/// The person who is scanned: a child is made of the adult, everybody else stays.
SkinnedSurface person_of_fault(ScanFault fault, SkinnedSurface skin);
/// Adds the turns of arms and fingers to a pose.
void add_fault_pose(ScanFault fault, const Eigen::Ref<const Points>& joints, Pose& pose);
/// The surface that the scanner sees of the posed skin: with clothes, shoes or hair on it. `covered`: N, 1 where it is
/// not the skin's own.
Points surface_of_fault(ScanFault fault, const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed_skin,
                        std::vector<char>& covered);
/// What the fault does to the mesh of a scan; `posed_skin`: the true surface, in the tessellation of `rest`.
void apply_fault_to_mesh(ScanFault fault, const SkinnedSurface& rest, const Eigen::Ref<const Points>& posed_skin,
                         Points& vertices, Triangles& triangles);

}  // namespace ndg
