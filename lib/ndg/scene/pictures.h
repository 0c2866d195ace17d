// SPDX-License-Identifier: Apache-2.0
// The project's pictures: one body, its layers, sections through it, samples side by side, a row of bodies.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/core/enum_names.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/scene/body_surfaces.h"
#include "ndg/scene/camera.h"
#include "ndg/scene/image.h"
#include "ndg/scene/render.h"

#include <string>
#include <vector>

namespace ndg {

struct PictureSettings {
    View view = View::front;
    int height = 1200;  ///< pixels of one body; the width follows
    int samples_per_axis = 2;
    bool volume_colours = false;  ///< colour the skin by volume change
    double colour_range = 0.3;    ///< volume change shown in full colour
};

/// `count` indices spread evenly over 0..size-1, all when there are fewer.
std::vector<int> spread_indices(int size, int count);

/// The skin of a body, plain or coloured by its volume change.
SceneSurface shown_skin(const Template& body_template, const Body& body, const BodyGeometry& geometry,
                        const PictureSettings& settings);

/// A picture of it.
Image body_picture(const Template& body_template, const Body& body, const BodyGeometry& geometry,
                   const PictureSettings& settings);

/// One surface of a body that faces +z.
Image surface_picture(const SceneSurface& surface, View view, const PictureSettings& settings);

/// Front and back of skin, muscle wrap, bone wrap, bones, and muscles with bones side by side, each inside a faint
/// skin.
Image layers_picture(const Template& body_template, const BodyGeometry& geometry, const PictureSettings& settings);

/// Sections of a body at rest: a frontal one through the shoulders, and horizontal ones through chest, abdomen, upper
/// arm, hip and thigh, with fat, muscle, the inside of the bone wrap and the anatomy in colours of their own.
Image sections_picture(const Template& body_template, const Body& body, const PictureSettings& settings);

/// Which plane cuts bodies: all stands for the sagittal one and horizontal ones through chest, abdomen and hip.
enum class SectionKind { all, sagittal, coronal, horizontal };
template <>
inline constexpr EnumName<SectionKind> enum_table<SectionKind>[] = {{SectionKind::all, "all"},
                                                                    {SectionKind::sagittal, "sagittal"},
                                                                    {SectionKind::coronal, "coronal"},
                                                                    {SectionKind::horizontal, "horizontal"}};
struct SectionChoice {
    SectionKind kind = SectionKind::all;
    /// Joint the plane goes through; empty: pelvis for sagittal, left_upper_arm for coronal, spine_4 for horizontal.
    std::string joint;
    double offset = 0.0;  ///< m, from there to the left, forward or up
};

/// Sections of bodies at rest, a column a body, all at one scale (`settings.height` pixels for the tallest body), in
/// the colours of sections_picture. Sagittal ones face right; horizontal ones show the trunk from above, front down.
/// Throws InputError for a plane that misses a body, naming it, or a joint the skeleton lacks.
Image section_sheet(const Template& body_template, const BodySet& bodies, const std::vector<int>& body_indices,
                    const SectionChoice& choice, const PictureSettings& settings);

/// The plane that cuts a posed body: through the joint that `choice` names where the pose took it, and turned with it.
/// Its normal points to the left, forward or up of the body, as offsets do. SectionKind::all: sagittal. Throws
/// InputError for a joint the skeleton lacks.
ClipPlane posed_cut(const PosedBody& posed, const SectionChoice& choice);

/// A section of a posed body. The plane goes through the joint that `choice` names where the pose took it, and turns
/// with it: a sagittal one through left_shin cuts the left knee lengthwise in every bend. SectionKind::all: sagittal.
/// Throws InputError as section_sheet.
Image posed_section_picture(const PosedBody& posed, const BodyGeometry& geometry, const SectionChoice& choice,
                            const PictureSettings& settings);

/// One row a sample, one column a file: `num_samples` pairs of `split` spread evenly over those the first file holds.
/// Every row is seen by one camera that frames all its bodies. Throws InputError when a file lacks a pair, a body or
/// pose index has no counterpart, or the split has no sample.
Image frames_picture(const BodyPoser& poser, const BodySet& bodies, const PoseSet& poses,
                     const std::vector<DeformationSet>& files, const std::string& split, int num_samples,
                     const PictureSettings& settings);

/// The same of pairs given, in their order.
Image frames_picture(const BodyPoser& poser, const BodySet& bodies, const PoseSet& poses,
                     const std::vector<DeformationSet>& files, const std::vector<SamplePair>& pairs,
                     const PictureSettings& settings);

/// Up to `max_bodies` bodies at rest, spread evenly over the set, all at one scale.
Image bodies_picture(const Template& body_template, const BodySet& bodies, int max_bodies,
                     const PictureSettings& settings);

}  // namespace ndg
