// SPDX-License-Identifier: Apache-2.0
// From a skin to a layered body, after InsideHumans (Komaritzan, Wenninger and Botsch 2021) as NDG 3.1 and 4.1 change
// it.
#pragma once

#include "ndg/body/template.h"
#include "ndg/layers/body_composition.h"
#include "ndg/layers/layer_fit.h"
#include "ndg/placement/skeleton_placer.h"

#include <optional>
#include <string>
#include <vector>

namespace ndg {

/// Measures of a layered body.
struct LayerReport {
    double stature_m = 0, mass_kg = 0, bmi = 0;
    BodyGirths girths;
    BodyComposition composition;                         ///< what the girths tell
    double fat_layer_litre = 0, muscle_layer_litre = 0;  ///< reached
    double wanted_fat_litre = 0;                         ///< of the fat layer, see LayerBuilder
    LayerFitReport fit;
};

/// To be raised whenever the same options, template and skin come to give other layers: no batch is resumed then that
/// another method began.
inline constexpr int layers_method_version = 3;
/// What all layered bodies of a batch depend on.
std::string layers_key(const LayerFitOptions& options, const std::string& template_sha256);

/// Makes layered bodies of one template. Kept by reference.
class LayerBuilder {
public:
    LayerBuilder(const Template& body_template, const LayerFitOptions& options);

    /// Layers for a skin in the template's tessellation: `skin.skin_vertices` and `skin.joint_positions` are given, the
    /// rest is filled, the joints of the trunk are placed (SkeletonPlacer); skin vertices move where prisms ask for it
    /// (fit_layers). The bone wrap is the template's, carried by trunk and limbs (carried_bone_wrap): it does not grow
    /// with fat. The fat layer holds the adipose tissue under the skin that the girths tell (body_composition). Muscle
    /// has the template's thickness times the root of how much more tissue there is than in the template, times one
    /// factor; where viscera fill the muscle layer, in the abdomen, the fat is 1.6 times the mean fat instead, and
    /// more where muscles would else be thinner than four tenths. Throws InputError for a skin that does not fit the
    /// template, Error naming the body and the worst place when a prism stays invalid.
    Body build(const Skin& skin, const Person& person, LayerReport* report = nullptr) const;

    const Template& body_template() const { return template_; }

private:
    LayerSurfaces targets(const Skin& skin, const TrunkMap& trunk, double scale, LayerReport& report) const;

    const Template& template_;
    LayerFitOptions options_;
    std::optional<SkeletonPlacer> placer_;  ///< empty for a template without bones
    RowMatrix weights_;                     ///< N_w x J, dense
    Points bone_, muscle_, skin_;           ///< the template's wraps
    Eigen::VectorXd visceral_;              ///< N_w, how far the muscle layer is viscera (0..1)
    Prisms muscle_prisms_, fat_prisms_;
    double stature_ = 0;
};

/// One body by itself.
Body build_layers(const Template& body_template, const Skin& skin, const Person& person, double min_scaled_jacobian,
                  LayerReport* report = nullptr);

}  // namespace ndg
