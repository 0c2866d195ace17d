// SPDX-License-Identifier: Apache-2.0
// A trained network as a way to pose the flesh.
#pragma once

#include "ndg/deform/deformer.h"
#include "ndg/deform/rest_cache.h"
#include "ndg/neural/model.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace ndg {

/// What is needed to use a trained network.
struct NetworkInputs {
    std::string model_path;
    Device device = Device::cpu;
    int batch_size = 16;

    /// --model, --device and --batch-size.
    void add_to(Tool& tool, bool required);
};

class NetworkDeformer : public Deformer {
public:
    /// Keeps a reference to the poser's template. Throws InputError when there is no model, or when it was made for
    /// another template or for bodies posed in another way.
    NetworkDeformer(const BodyPoser& poser, const NetworkInputs& inputs);

    Points deform(const PosedBody& posed) override { return deform_batch({posed}).front(); }
    std::vector<Points> deform_batch(const std::vector<PosedBody>& posed) override;
    int batch_size() const override { return batch_size_; }
    /// method_name of the model.
    std::string name() const override { return method_name(model_.options()); }
    const NetworkOptions& options() const { return model_.options(); }

    /// OutputSpace::gradients, N_p x 9 a body. A sample's result may differ in rounding with the number of bodies given
    /// together.
    std::vector<GradientsF> gradients(const std::vector<PosedBody>& posed);

private:
    RowMatrixF predict(const std::vector<PosedBody>& posed);

    NeuralModel model_;
    int batch_size_;
    RestCache rest_;
    std::map<const Body*, Eigen::VectorXd> codes_;
};

/// "ndg" and "vertexnet", with the options of NetworkInputs.
void register_network_deformer(MethodTable& table);

}  // namespace ndg
