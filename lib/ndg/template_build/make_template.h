// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/body_source/template_source.h"
#include "ndg/template_build/cover.h"
#include "ndg/wraps/anatomy_wraps.h"

namespace ndg {

struct TemplateOptions {
    int prisms = 6000;                   ///< wanted number of prisms; reached within a few percent
    double keep_ratio = 0.25;            ///< share of the source's triangles kept on head, hands and toes
    double move_limit = 0.002;           ///< m; anatomy vertices this near to the volume are moved into it
    double muscle_edge = 0.020;          ///< m; longer edges of muscles are split, so that muscles bend with the flesh
    double shallow_muscle_edge = 0.008;  ///< m; so are those longer than this and than 1.5 times their depth
    CoverOptions cover;
    AnatomyWrapOptions wraps;
};
void describe(OptionList& list, TemplateOptions& options);

/// The layered template (NDG 3.1) of a source: its skin remeshed to the wanted resolution, anatomy brought under that
/// skin, bone wrap and muscle wrap around it, prisms between them, tetrahedra inside, the anatomy embedded. Throws
/// InputError for a skin that cannot be used, Error when no valid layers are found.
Template make_template(const TemplateSource& source, const TemplateOptions& options);

}  // namespace ndg
