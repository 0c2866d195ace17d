// SPDX-License-Identifier: Apache-2.0
#include "ndg/registration/people.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace ndg {
namespace {

double read_sex(const nlohmann::json& value, const std::string& where)
{
    if (value.is_string()) return male_share(parse_name<Sex>(value.get<std::string>(), where + ": sex"));
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

void write_people(const std::string& path, const BodySet& bodies, const std::string& where)
{
    const auto column = [&](const char* name) {
        const auto found = std::find(bodies.parameter_names.begin(), bodies.parameter_names.end(), name);
        require_input(found != bodies.parameter_names.end(), "{}: the bodies have no parameter {}", where, name);
        return found - bodies.parameter_names.begin();
    };
    const Eigen::Index sex = column("sex"), age = column("age_years");
    nlohmann::json people = nlohmann::json::object();
    for (std::size_t b = 0; b < bodies.bodies.size(); ++b) {
        const auto row = static_cast<Eigen::Index>(b);
        people[bodies.bodies[b].name] = {{"sex", bodies.parameters(row, sex)},
                                         {"age_years", bodies.parameters(row, age)}};
    }
    write_file(path, people.dump(1) + "\n");
}

}  // namespace ndg
