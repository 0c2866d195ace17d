// SPDX-License-Identifier: Apache-2.0
// The runtime as a way to pose the flesh: what libndg shows, in files.
#include "ndg/core/error.h"
#include "ndg/deform/deformer.h"
#include "ndg/runtime/runtime.h"

namespace ndg {
namespace {

class RuntimeDeformer : public Deformer {
public:
    RuntimeDeformer(const BodyPoser& poser, const std::string& model_path)
        : model_(model_path), runtime_(poser.body_template(), model_)
    {
        require_input(model_.traits.posing.bone_wrap == poser.options().bone_wrap,
                      "{}: was trained on bodies posed with bone-wrap {}, these are posed with {}", model_path,
                      to_name(model_.traits.posing.bone_wrap), to_name(poser.options().bone_wrap));
    }

    Points deform(const PosedBody& posed) override
    {
        pose(posed);
        return runtime_.volume().cast<double>();
    }

    Points anatomy(const PosedBody& posed, const Eigen::Ref<const Points>&, const Eigen::Ref<const Points>&) override
    {
        pose(posed);
        return runtime_.anatomy().cast<double>();
    }

private:
    void pose(const PosedBody& posed)
    {
        if (&posed.body() != body_) runtime_.set_body(posed.body());
        body_ = &posed.body();
        runtime_.set_pose(posed.pose());
    }

    RuntimeModel model_;
    Runtime runtime_;
    const Body* body_ = nullptr;
};

}  // namespace

/// "runtime".
void register_runtime(MethodTable& table)
{
    const auto path = std::make_shared<std::string>();
    table.add({"runtime", "NDG runtime", "a trained network as libndg uses it, from a file of export-runtime",
               [path](Tool& tool) { tool.input("runtime-model", *path, "runtime model", false); },
               [path](const BodyPoser& poser) {
                   require_input(!path->empty(), "the method runtime needs --runtime-model");
                   return std::make_unique<RuntimeDeformer>(poser, *path);
               }});
}

}  // namespace ndg
