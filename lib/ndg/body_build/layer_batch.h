// SPDX-License-Identifier: Apache-2.0
// Layers for many skins: in parallel, resumable, failures set apart.
#pragma once

#include "ndg/body_build/layers.h"

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
std::vector<Person> people_of_skins(const BodySet& skins, const std::string& path, const PeopleOptions& options);

struct LayerBatchOptions {
    std::string output;    ///< finished bodies are kept beside it, in "OUTPUT.parts", until the batch is written
    std::string settings;  ///< everything a body depends on; parts of other settings are not used
};

struct LayerBatch {
    BodySet bodies;                     ///< those that succeeded, in the skins' order, with layer_parameters
    std::vector<std::string> failures;  ///< one sentence for each skin that failed
    int num_resumed = 0;                ///< bodies taken over from parts
    std::vector<double> seconds;        ///< that each of the others took on one core
};

/// Layers for all skins. A skin that fails is set apart with its sentence. Throws Interrupted, parts kept, once `stop`
/// returns true. The result does not depend on threads or interruptions.
LayerBatch build_layer_batch(const LayerBuilder& builder, const BodySet& skins, const std::vector<Person>& people,
                             const LayerBatchOptions& options, const std::function<bool()>& stop);
/// Removes the parts of a batch that has been written.
void remove_layer_parts(const LayerBatchOptions& options);

/// Names of the numbers that are stored with a body, and these numbers.
const std::vector<std::string>& layer_parameter_names();
Eigen::RowVectorXd layer_parameters(const Person& person, const LayerReport& report);

}  // namespace ndg
