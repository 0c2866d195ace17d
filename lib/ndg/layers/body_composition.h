// SPDX-License-Identifier: Apache-2.0
// How much fat and muscle a person has, from girths, by published formulas.
#pragma once

#include "ndg/body/person.h"
#include "ndg/layers/girths.h"

namespace ndg {

struct BodyComposition {
    double fat_share = 0;             ///< of the body's mass
    double fat_mass_kg = 0;           ///< all fat
    double subcutaneous_litre = 0;    ///< adipose tissue under the skin
    double muscle_mass_kg = 0;        ///< skeletal muscle
    double muscle_litre = 0;          ///< the same as volume
    double mean_fat_thickness_m = 0;  ///< of the adipose tissue under the skin
};

/// Share of fat in the body's mass, from girths and stature in metres: density by Hodgdon and Beckett 1984 (Prediction
/// of percent body fat for U.S. Navy men and women from body circumferences and height, Naval Health Research Center
/// reports 84-11 and 84-29), in cm,
///   men    1.0324 - 0.19077 log10(abdomen - neck) + 0.15456 log10(stature)
///   women  1.29579 - 0.35004 log10(waist + hip - neck) + 0.22100 log10(stature)
/// and 4.95 / density - 4.50 (Siri 1961). These were made on sailors and go too far for the very heavy: the result is
/// at most one standard error, 0.041, above what mass and age tell, (1.2 bmi + 0.23 age - 10.8 sex - 5.4) percent
/// (Deurenberg, Weststrate and Seidell 1991, British Journal of Nutrition 65, 105-114), and within 4 to 55 percent.
double fat_share(const BodyGirths& girths, double stature_m, double mass_kg, const Person& person);

/// Skeletal muscle, kg, by Lee et al. 2000 (Total-body skeletal muscle mass: development and cross-validation of
/// anthropometric prediction models, Am J Clin Nutr 72, 796-803), model 1, race white or Hispanic:
///   stature (0.00744 CAG^2 + 0.00088 CTG^2 + 0.00441 CCG^2) + 2.4 sex - 0.048 age + 7.8
/// with stature in m and the girths in cm of upper arm, thigh and calf less pi times a skinfold, which is twice
/// `fat_thickness_m`. Kept within 30 to 65 percent of `lean_mass_kg`, since the model was made on people below a body
/// mass index of 30.
double muscle_mass(const BodyGirths& girths, double stature_m, const Person& person, double fat_thickness_m,
                   double lean_mass_kg);

/// Both, and the volumes they take. The part of the fat that lies under the skin is what viscera do not hold: they have
/// 10 to 20 percent of a man's fat and 5 to 8 percent of a woman's (Wajchenberg 2000, Endocrine Reviews 21, 697-738),
/// taken as 15 and 6.5. Adipose tissue is 80 percent fat and weighs 0.92 kg a litre, muscle 1.04 (Snyder et al. 1975,
/// Report of the Task Group on Reference Man, ICRP 23). `skin_area`: m^2, what the fat under the skin spreads over.
BodyComposition body_composition(const BodyGirths& girths, double stature_m, double mass_kg, double skin_area,
                                 const Person& person);

}  // namespace ndg
