// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/elastic/elastic_body.h"
#include "ndg/elastic/materials.h"

#include <vector>

namespace ndg {

/// Of every prism: muscle's, then fat's.
std::vector<Lame> prism_materials(const Template& body_template, const MaterialOptions& material);

/// A layered body's elastic energy (NDG equation 7): muscle and fat of stable Neo-Hookean prisms, the guard of their
/// volumes where the material has one, and the skin. The bone wrap is given; at rest it is the template's own body.
ElasticBody layered_body(const Template& body_template, const MaterialOptions& material);

}  // namespace ndg
