// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/stored_gradients.h"

#include "ndg/core/error.h"

namespace ndg {

StoredGradients::StoredGradients(const Template& body_template, const std::string& path)
    : path_(path), file_(path, body_template.num_prisms()), rest_(body_template)
{
    for (int i = 0; i < file_.size(); ++i) {
        const SamplePair& pair = index().pairs[i];
        require_input(sample_of_pair_.emplace(pair, i).second, "{}: holds {} twice", path, describe(pair));
    }
}

Points StoredGradients::deform(const PosedBody& posed)
{
    const auto sample = sample_of_pair_.find(posed.pair());
    require_input(sample != sample_of_pair_.end(), "{}: has no gradients of {}", path_, describe(posed.pair()));
    const std::vector<float> stored = file_.read(sample->second);
    return rest_.poisson(posed.body())
        .reconstruct(Eigen::Map<const GradientsF>(stored.data(), file_.num_prisms(), 9), posed.bone_wrap());
}

void register_stored_gradients(MethodTable& table)
{
    const auto path = std::make_shared<std::string>();
    table.add({"gradients", "Stored gradients", "deformation gradients of a file, then a Poisson solve",
               [path](Tool& tool) {
                   tool.input("gradients", *path, "deformation gradients, for the method \"gradients\"", false);
               },
               [path](const BodyPoser& poser) {
                   require_input(!path->empty(), "the method \"gradients\" needs --gradients");
                   auto gradients = std::make_unique<StoredGradients>(poser.body_template(), *path);
                   const BoneWrap stored = gradients->index().posing.bone_wrap;
                   require_input(stored == poser.options().bone_wrap,
                                 "{}: its gradients are of bone-wrap {}, the bodies are posed with {}", *path,
                                 to_name(stored), to_name(poser.options().bone_wrap));
                   return gradients;
               }});
}

}  // namespace ndg
