// SPDX-License-Identifier: Apache-2.0
// A body of our own that needs no file: skin, rig, weights and a simplified anatomy for any adult.
#pragma once

#include "ndg/body_source/parametric_surface.h"
#include "ndg/body_source/template_source.h"
#include "ndg/core/types.h"
#include "ndg/procedural/parameters.h"

#include <memory>

namespace ndg {

/// Credit line stored in files made from this source.
extern const char* const procedural_licence;

class ProceduralBody {
public:
    /// Meshes the reference person (some seconds). Deterministic; needs no data.
    ProceduralBody();
    ~ProceduralBody();
    ProceduralBody(ProceduralBody&&) noexcept;

    /// The skin's triangles, T x 3, the same for all people: closed, outward, genus 0, mirror image of itself.
    const Triangles& triangles() const;
    /// Dense skinning weights, N x 60, rows sum to one, at most 8 entries a row.
    const RowMatrix& weights() const;
    /// Vertex at the mirrored place (itself on x = 0), N.
    const std::vector<int>& mirror() const;
    /// The person with these parameters, exactly symmetric in x. Stature and mass (volume times body_density) come out
    /// as asked: fat makes up what muscle and bone leave of the mass. Throws InputError for parameters out of range.
    ParametricSurface evaluate(const ProceduralParameters& parameters) const;
    /// The same with rig, weights and anatomy: what a template is made from.
    TemplateSource source(const ProceduralParameters& parameters) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace ndg
