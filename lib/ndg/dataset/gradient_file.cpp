// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/gradient_file.h"

namespace ndg {

namespace {

const SamplePayload payload = {
    "ndg-gradients", 1, "/gradients", "/gradients/F", "prisms", 9, "deformation gradient of each prism, row-major"};

}  // namespace

GradientWriter::GradientWriter(const std::string& path, const SampleIndex& index, int num_prisms,
                               const Provenance& provenance)
    : SampleWriter(path, payload, index, num_prisms, provenance)
{
}

GradientReader::GradientReader(const std::string& path, int num_prisms) : SampleReader(path, payload, num_prisms) {}

}  // namespace ndg
