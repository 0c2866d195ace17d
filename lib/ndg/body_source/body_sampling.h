// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/body_source/makehuman.h"

#include <cstdint>
#include <string>

namespace ndg {

/// How far sampled adults spread around the middle of MakeHuman's sliders.
struct BodySamplingOptions {
    double spread = 0.18;  ///< standard deviation of proportions (slider 0..1); weight and muscle 1.3, height 0.4 times

    void check() const;
};

/// Parameters of body `body_idx`: sexes alternate, age uniform from 20 to 75 years, the other sliders normal, centred
/// so that stature and BMI spread about as adults' do, and cut at 0.08 and 0.95. Depends on (seed, body_idx) alone.
MakeHumanParameters sample_parameters(std::uint64_t seed, int body_idx, const BodySamplingOptions& options);

/// The source's surface in the template's tessellation: skin vertices and joints of the returned body are filled.
/// Throws InputError when the template has no source map.
Body skin_on_template(const Template& body_template, const ParametricSurface& surface, const std::string& name);

/// `count` adults of the template's own source as skins in its tessellation; parameters sex, age_years, stature_m,
/// mass_kg, bmi. MakeHuman's people need its folder; the procedural body needs none. Body b depends on (seed, b) alone.
/// Throws InputError when the template has no source or the folder is missing.
BodySet sample_skins(const Template& body_template, const std::string& makehuman_folder, int count, std::uint64_t seed,
                     const BodySamplingOptions& options);

}  // namespace ndg
