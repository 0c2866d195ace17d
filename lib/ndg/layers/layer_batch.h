// SPDX-License-Identifier: Apache-2.0
// Layers for many skins: in parallel, resumable, failures set apart.
#pragma once

#include "ndg/dataset/part_store.h"
#include "ndg/layers/layers.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// Whose sex: skins takes the skins' parameters "sex" and "age_years".
enum class SexSource { skins, female, male, unknown };
template <>
inline constexpr EnumName<SexSource> enum_table<SexSource>[] = {{SexSource::skins, "skins"},
                                                                {SexSource::female, "female"},
                                                                {SexSource::male, "male"},
                                                                {SexSource::unknown, "unknown"}};

/// Where sex and age of the people come from.
struct PeopleOptions {
    SexSource sex = SexSource::skins;
    double age_years = Person().age_years;  ///< of all, unless the skins say
};
void describe(OptionList& list, PeopleOptions& options);
/// One for each skin. Throws InputError naming `path` and the parameter that the skins lack, or the body and its value
/// out of range.
std::vector<Person> people_of_skins(const SkinSet& skins, const std::string& path, const PeopleOptions& options);

inline const PartKind body_parts = {"ndg-body-part", 1, "bodies"};

struct LayerBatch {
    BodySet bodies;                     ///< those that succeeded, in the skins' order, with layer_parameters
    std::vector<std::string> failures;  ///< one sentence for each skin that failed
    int num_resumed = 0;                ///< skins that an earlier run had finished
    std::vector<double> seconds;        ///< that each body took on one core
};

/// Layers for all skins; finished ones are kept in `store`, whose key must hold all that bodies depend on but skins and
/// people. A skin that fails is set apart with its sentence. Throws Interrupted, parts kept, once `stop` returns true.
/// The result does not depend on threads or interruptions.
LayerBatch build_layer_batch(const LayerBuilder& builder, const SkinSet& skins, const std::vector<Person>& people,
                             const PartStore& store, const std::function<bool()>& stop);

/// Names of the numbers that are stored with a body, and these numbers.
const std::vector<std::string>& layer_parameter_names();
Eigen::RowVectorXd layer_parameters(const Person& person, const LayerReport& report);

}  // namespace ndg
