// SPDX-License-Identifier: Apache-2.0
#include "ndg/body/joint_flesh.h"

#include "ndg/geometry/prism.h"

namespace ndg {

namespace {

constexpr double least_weight = 0.1, least_sum = 0.5;

struct JointBones {
    std::string name, upper, lower;
};

const std::vector<JointBones>& joints()
{
    static const std::vector<JointBones> table = [] {
        std::vector<JointBones> result;
        for (const std::string side : {"left", "right"}) {
            result.push_back({side + "_knee", side + "_thigh", side + "_shin"});
            result.push_back({side + "_hip", "pelvis", side + "_thigh"});
            result.push_back({side + "_shoulder", side + "_clavicle", side + "_upper_arm"});
        }
        return result;
    }();
    return table;
}

double weight_of(const SkinningWeights& weights, int row, int joint)
{
    double weight = 0;
    for (int k = 0; k < max_influences; ++k) {
        if (weights.joints(row, k) == joint) weight += weights.weights(row, k);
    }
    return weight;
}

}  // namespace

const std::vector<std::string>& flesh_joint_names()
{
    static const std::vector<std::string> names = [] {
        std::vector<std::string> result;
        for (const JointBones& joint : joints()) result.push_back(joint.name);
        return result;
    }();
    return names;
}

JointFlesh::JointFlesh(const Template& body_template) : all_prisms_(body_template.prisms)
{
    const SkinningWeights weights = body_template.prism_weights();
    for (const JointBones& joint : joints()) {
        const int upper = body_template.skeleton.joint(joint.upper), lower = body_template.skeleton.joint(joint.lower);
        prisms_.emplace_back();
        for (int p = 0; p < body_template.num_prisms(); ++p) {
            const double a = weight_of(weights, p, upper), b = weight_of(weights, p, lower);
            if (a >= least_weight && b >= least_weight && a + b >= least_sum) prisms_.back().push_back(p);
        }
    }
}

std::vector<double> JointFlesh::volume_changes(const Eigen::Ref<const Points>& rest_vertices,
                                               const Eigen::Ref<const Points>& vertices) const
{
    std::vector<double> changes;
    for (const std::vector<int>& prisms : prisms_) {
        double rest = 0, posed = 0;
        for (const int p : prisms) {
            rest += prism_volume(gather_prism(rest_vertices, all_prisms_, p));
            posed += prism_volume(gather_prism(vertices, all_prisms_, p));
        }
        changes.push_back(rest > 0 ? posed / rest - 1 : 0);
    }
    return changes;
}

}  // namespace ndg
