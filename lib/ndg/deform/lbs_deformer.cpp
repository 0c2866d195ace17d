// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/lbs_deformer.h"

namespace ndg {

namespace {

class LbsDeformer : public Deformer {
public:
    Points deform(const PosedBody& posed) override { return posed.skinned_volume(); }
};

}  // namespace

void register_lbs(MethodTable& table)
{
    table.add(
        {"lbs", "LBS", "linear blend skinning", {}, [](const BodyPoser&) { return std::make_unique<LbsDeformer>(); }});
}

}  // namespace ndg
