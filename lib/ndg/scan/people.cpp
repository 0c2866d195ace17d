// SPDX-License-Identifier: Apache-2.0
#include "ndg/scan/people.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/json_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {

People read_people(const std::string& path)
{
    People people;
    for (const auto& [name, entry] : JsonValue(path).members()) {
        entry.check_keys({"sex", "age_years"});
        Person person;
        if (entry.has("sex")) {
            const JsonValue sex = entry.at("sex");
            person.sex = sex.is_text() ? male_share(parse_name<Sex>(sex.text(), sex.where())) : sex.number(0.0, 1.0);
        }
        person.age_years = entry.number_or("age_years", person.age_years, 18.0, 130.0);
        people[name] = person;
    }
    return people;
}

void write_people(const std::string& path, const SkinSet& skins, const std::string& where)
{
    const auto column = [&](const char* name) {
        const auto found = std::find(skins.parameter_names.begin(), skins.parameter_names.end(), name);
        require_input(found != skins.parameter_names.end(), "{}: the bodies have no parameter {}", where, name);
        return found - skins.parameter_names.begin();
    };
    const Eigen::Index sex = column("sex"), age = column("age_years");
    nlohmann::json people = nlohmann::json::object();
    for (std::size_t b = 0; b < skins.bodies.size(); ++b) {
        const auto row = static_cast<Eigen::Index>(b);
        people[skins.bodies[b].name] = {{"sex", skins.parameters(row, sex)}, {"age_years", skins.parameters(row, age)}};
    }
    write_file(path, people.dump(1) + "\n");
}

}  // namespace ndg
