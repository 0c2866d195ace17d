// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/body_source/adult_statistics.h"
#include "ndg/core/options.h"
#include "ndg/makehuman/makehuman.h"
#include "ndg/people/proportions.h"

#include <cstdint>
#include <string>

namespace ndg {

/// Who is drawn (adult_statistics.h), and how much people of equal stature and mass differ.
struct BodySamplingOptions {
    double min_bmi = 17.0, max_bmi = 45.0;
    double muscle_spread = 0.2;       ///< standard deviation of MakeHuman's muscle slider (0..1)
    double proportion_spread = 0.18;  ///< of its proportions
    double detail_spread = 0.2;       ///< of each of makehuman_details() that no length of proportions() depends on
    double length_spread = 0.8;       ///< of the lengths of proportions(), in published standard deviations

    /// check_options, and that the range of the body mass index is at least 1.
    void check() const;
};
void describe(OptionList& list, BodySamplingOptions& options);

/// MakeHuman's parameters for an adult of the muscle, proportions and details of `wished`: muscle is no more than a
/// wish; height is solved for the stature (within 1 mm), weight for the body mass index (within 0.05), and the details
/// that `lengths` are about for these (within 0.002 of the stature, as far as MakeHuman's details reach). Who is
/// heavier than the weight slider reaches gets fullness and less muscle than wished, who is lighter less muscle too:
/// MakeHuman's heaviest have no muscle. Throws Error naming what cannot be reached.
MakeHumanParameters makehuman_parameters(const MakeHuman& source, const Adult& adult, MakeHumanParameters wished,
                                         const ProportionValues& lengths);

/// The mean adult of that sex, 25 years old, with a body mass index of 23.5 and of usual proportions.
MakeHumanParameters mean_adult(const MakeHuman& source, bool male);

/// Parameters of body `body_idx`. Depends on (seed, body_idx) and the options alone.
MakeHumanParameters sample_parameters(const MakeHuman& source, std::uint64_t seed, int body_idx,
                                      const BodySamplingOptions& options);

/// The source's surface in the template's tessellation.
/// Throws InputError when the template has no source map.
Skin skin_on_template(const Template& body_template, const ParametricSurface& surface, const std::string& name);

/// `count` adults of the template's own source as skins in its tessellation; parameters sex, age_years, stature_m,
/// mass_kg, bmi, of the source's own surface. MakeHuman's people need its folder; the procedural body needs none. Body
/// b depends on (seed, b) and the options alone. Throws InputError when the template has no source or the folder is
/// missing.
SkinSet sample_skins(const Template& body_template, const std::string& makehuman_folder, int count, std::uint64_t seed,
                     const BodySamplingOptions& options);

/// Mean, standard deviation and percentiles of stature, mass and body mass index of the skins by sex, and shares of the
/// obese, beside what was drawn from: a table for reading. `skins` as sample_skins has them.
std::string sampling_table(const SkinSet& skins, const BodySamplingOptions& options);

}  // namespace ndg
