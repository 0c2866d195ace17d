// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/person.h"
#include "ndg/body/template.h"

#include <map>
#include <string>

namespace ndg {

using People = std::map<std::string, Person>;

/// JSON object {name: {"sex": number from 0 to 1, or "female" or "male", "age_years": number}, ...}. Throws InputError
/// naming file and entry.
People read_people(const std::string& path);

/// The same file from skins' parameters sex and age_years. Throws InputError, starting with `where`, without them.
void write_people(const std::string& path, const SkinSet& skins, const std::string& where);

}  // namespace ndg
