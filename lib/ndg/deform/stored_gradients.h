// SPDX-License-Identifier: Apache-2.0
// Vertices from deformation gradients that stand in a file (NDG 4.2).
#pragma once

#include "ndg/dataset/gradient_file.h"
#include "ndg/deform/deformer.h"
#include "ndg/deform/rest_cache.h"

#include <map>
#include <string>

namespace ndg {

/// Knows the samples of its file alone: bodies must be posed with their pair (InputError otherwise).
class StoredGradients : public Deformer {
public:
    /// Keeps a reference to `body_template`. Throws InputError when the file does not fit the template or holds a pair
    /// twice.
    StoredGradients(const Template& body_template, const std::string& path);

    Points deform(const PosedBody& posed) override;
    /// The method the file names.
    std::string name() const override { return file_.index().method; }
    const SampleIndex& index() const { return file_.index(); }

private:
    std::string path_;
    GradientReader file_;
    std::map<SamplePair, int> sample_of_pair_;
    RestCache rest_;
};

/// "gradients", with the option --gradients.
void register_stored_gradients(MethodTable& table);

}  // namespace ndg
