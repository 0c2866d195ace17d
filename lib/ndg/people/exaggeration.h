// SPDX-License-Identifier: Apache-2.0
// Stylised people: bodies outside of what datasets are drawn from (NDG Table 2).
#pragma once

#include "ndg/body/template.h"

namespace ndg {

/// A caricature of person `body_idx` of `skins`: the template's skin and `factor` times the differences of the person's
/// from it, put on the floor; joints follow the skin as those of drawn people do. Parameters stature_m, mass_kg and bmi
/// are those of the new skin. A factor of 1 gives the person again. Throws InputError for a person that is not there.
SkinSet exaggerated_person(const Template& body_template, const SkinSet& skins, int body_idx, double factor);

}  // namespace ndg
