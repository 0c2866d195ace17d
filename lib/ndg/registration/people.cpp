// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/people.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <nlohmann/json.hpp>

namespace ndg {
namespace {

double read_sex(const nlohmann::json& value, const std::string& where)
{
    if (value == "female") return 0.0;
    if (value == "male") return 1.0;
    const double sex = value.is_number() ? value.get<double>() : -1.0;
    require_input(sex >= 0.0 && sex <= 1.0, "{}: sex is {}, expected a number from 0 (female) to 1 (male)", where,
                  value.dump());
    return sex;
}

}  // namespace

People read_people(const std::string& path)
{
    const auto json = nlohmann::json::parse(read_file(path), nullptr, false);
    require_input(json.is_object(), "{}: is no JSON object of people", path);
    People people;
    for (const auto& [name, entry] : json.items()) {
        const std::string where = path + ": \"" + name + "\"";
        require_input(entry.is_object(), "{} is no JSON object", where);
        Person person;
        for (const auto& [key, value] : entry.items()) {
            if (key == "sex") {
                person.sex = read_sex(value, where);
            } else {
                require_input(key == "age_years", "{}: unknown key \"{}\", known are sex and age_years", where, key);
                require_input(value.is_number() && value.get<double>() >= 0.0 && value.get<double>() <= 130.0,
                              "{}: age_years is {}", where, value.dump());
                person.age_years = value.get<double>();
            }
        }
        people[name] = person;
    }
    return people;
}

}  // namespace ndg
