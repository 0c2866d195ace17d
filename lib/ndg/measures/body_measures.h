// SPDX-License-Identifier: Apache-2.0
// Measures of a body's bones, joints and flesh beside published ranges, and the gates among them.
#pragma once

#include "ndg/body/template.h"
#include "ndg/measures/body_measure.h"

#include <string>
#include <vector>

namespace ndg {

struct MeasuredBody {
    std::string name;
    Person person;
    double stature_m = 0, bmi = 0;  ///< of the skin, with body_density
    std::vector<BodyMeasure> measures;
    /// The gates it misses, one sentence each.
    std::vector<std::string> failures() const;
};

/// Everything: of the skin's joints (measure_skin), of the bones (spine, rib cage, pelvis, limbs: where anatomy_at_rest
/// puts them) and of the layers. Rows whose bones or landmarks the template lacks are left out. `person`: whose
/// published ranges are taken.
MeasuredBody measure_body(const Template& body_template, const Body& body, const Person& person);

/// What joints and skin alone tell.
MeasuredBody measure_skin(const Template& body_template, const Skin& skin, const Person& person);

/// All people of a set, in parallel; sex and age by their parameters "sex" and "age_years", where they have them.
std::vector<MeasuredBody> measure_people(const Template& body_template, const BodySet& bodies);
std::vector<MeasuredBody> measure_people(const Template& body_template, const SkinSet& skins);

/// Gates over several bodies, each sentence one that does not hold: the mean distance of the hip joints from where
/// pelvic landmarks put them (Harrington et al. 2007) is at most 12 mm; judged from ten bodies on.
std::vector<std::string> common_failures(const std::vector<MeasuredBody>& bodies);

}  // namespace ndg
