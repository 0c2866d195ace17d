// SPDX-License-Identifier: Apache-2.0
#include "ndg/layers/body_composition.h"

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

constexpr double cm = 100.0;
constexpr double visceral_share_men = 0.15, visceral_share_women = 0.065;
constexpr double deurenberg_error = 0.041;
constexpr double fat_in_adipose = 0.80;
constexpr double adipose_density = 920.0, muscle_density = 1040.0;  ///< kg/m^3

double by_sex(double sex, double female, double male)
{
    return (1.0 - sex) * female + sex * male;
}

/// Siri 1961.
double fat_of_density(double density)
{
    return 4.95 / density - 4.50;
}

}  // namespace

double fat_share(const BodyGirths& girths, double stature_m, double mass_kg, const Person& person)
{
    // A tape cannot find a neck as thick as the trunk; the bound keeps the logarithm defined.
    const double men = cm * std::max(girths.abdomen - girths.neck, 0.1);
    const double women = cm * std::max(girths.waist + girths.hip - girths.neck, 0.3);
    const double height = std::log10(cm * stature_m);
    const double male = fat_of_density(1.0324 - 0.19077 * std::log10(men) + 0.15456 * height);
    const double female = fat_of_density(1.29579 - 0.35004 * std::log10(women) + 0.22100 * height);
    const double bmi = mass_kg / (stature_m * stature_m);
    const double by_bmi = 0.01 * (1.2 * bmi + 0.23 * person.age_years - 10.8 * person.sex - 5.4);
    return std::clamp(std::min(by_sex(person.sex, female, male), by_bmi + deurenberg_error), 0.04, 0.55);
}

double muscle_mass(const BodyGirths& girths, double stature_m, const Person& person, double fat_thickness_m,
                   double lean_mass_kg)
{
    const auto corrected = [&](double girth) {
        return cm * std::max(girth - M_PI * 2.0 * fat_thickness_m, 0.4 * girth);
    };
    const double arm = corrected(girths.upper_arm), thigh = corrected(girths.thigh), calf = corrected(girths.calf);
    const double mass = stature_m * (0.00744 * arm * arm + 0.00088 * thigh * thigh + 0.00441 * calf * calf) +
                        2.4 * person.sex - 0.048 * person.age_years + 7.8;
    return std::clamp(mass, 0.30 * lean_mass_kg, 0.65 * lean_mass_kg);
}

BodyComposition body_composition(const BodyGirths& girths, double stature_m, double mass_kg, double skin_area,
                                 const Person& person)
{
    BodyComposition result;
    result.fat_share = fat_share(girths, stature_m, mass_kg, person);
    result.fat_mass_kg = result.fat_share * mass_kg;
    const double under_skin = 1.0 - by_sex(person.sex, visceral_share_women, visceral_share_men);
    const double volume = under_skin * result.fat_mass_kg / (fat_in_adipose * adipose_density);
    result.subcutaneous_litre = 1e3 * volume;
    result.mean_fat_thickness_m = volume / skin_area;
    result.muscle_mass_kg =
        muscle_mass(girths, stature_m, person, result.mean_fat_thickness_m, mass_kg - result.fat_mass_kg);
    result.muscle_litre = 1e3 * result.muscle_mass_kg / muscle_density;
    return result;
}

}  // namespace ndg
