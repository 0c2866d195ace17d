// SPDX-License-Identifier: Apache-2.0
// MakeHuman's parametric body (CC0): base mesh, macro targets, rig and weights, on our skeleton and in our units.
#pragma once

#include "ndg/body_source/parametric_surface.h"
#include "ndg/core/types.h"

#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// MakeHuman's macro sliders, each 0..1, 0.5 is the middle; and fullness.
struct MakeHumanParameters {
    double sex = 0.5;  ///< 0 female, 1 male
    double age = 0.5;  ///< 0.5 is 25 years, 1 is 90 years; below 0.5 (children) is not offered
    double weight = 0.5;
    double muscle = 0.5;
    double height = 0.5;
    double proportions = 0.5;  ///< 0 uncommon, 1 ideal
    /// Weight of MakeHuman's targets for larger girths of trunk, limbs and neck, 0 to 3: beyond what the weight slider
    /// reaches, which ends at a body mass index of about 33 for women and 40 for men, and that without any muscle.
    double fullness = 0.0;
    /// Weights of makehuman_details(), -1 to 1 each; empty: none.
    std::vector<double> details;

    /// Throws InputError for a value outside its range.
    void check() const;
};

/// Names of MakeHuman's measure and detail targets in which people of equal stature and mass differ, folder and name
/// without -incr and -decr ("side": l and r): girths, breadths and depths of trunk and limbs, lengths of their
/// segments. Both sides of the body change alike.
const std::vector<std::string>& makehuman_details();

/// Years of age for MakeHuman's age slider.
double makehuman_age_years(double age);

/// Credit line stored in files made from this source.
extern const char* const makehuman_licence;

class MakeHuman {
public:
    /// Folder with 3dobjs/base.obj, targets/, rigs/. Throws InputError naming what is missing or malformed.
    explicit MakeHuman(const std::string& folder);
    ~MakeHuman();

    /// Triangles of the closed `body` group (quads split), T x 3 into vertices 0..N-1.
    const Triangles& triangles() const;
    /// Dense skinning weights on the standard skeleton, N x J, rows sum to one: MakeHuman's game-engine rig, its spine,
    /// neck and forearm weights divided over our finer chains.
    const RowMatrix& weights() const;
    /// The body for these parameters: targets blended multiplicatively as MakeHuman does, decimetre to metre.
    ParametricSurface evaluate(const MakeHumanParameters& parameters) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
