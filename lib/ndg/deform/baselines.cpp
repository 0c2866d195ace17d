// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/baselines.h"

#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/deform/rest_cache.h"

namespace ndg {

Points gradient_skinning(const BodyPoser& poser, const PoissonReconstruction& poisson, const Body& body,
                         const std::vector<Eigen::Isometry3d>& world_from_rest)
{
    return poisson.reconstruct(poser.prism_rotations(world_from_rest), poser.bone_wrap(body, world_from_rest));
}

Baseline parse_baseline(const std::string& name)
{
    if (name == "gradient-skinning") return Baseline::gradient_skinning;
    if (name == "lbs") return Baseline::linear_blend_skinning;
    throw InputError(fmt::format("unknown baseline \"{}\"; known are gradient-skinning and lbs", name));
}

std::string baseline_name(Baseline baseline)
{
    return baseline == Baseline::gradient_skinning ? "Gradient Skinning" : "LBS";
}

DeformationSet animate_baseline(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                const std::vector<SamplePair>& pairs, const std::string& split, Baseline baseline)
{
    const BodyPoser poser(body_template);
    RestCache rest(body_template, bodies);
    DeformationSet set;
    set.method = baseline_name(baseline);
    set.num_volume_vertices = body_template.num_volume_vertices();
    Progress progress("animating by " + set.method, pairs.size());
    for (const SamplePair& pair : pairs) {
        require_pair(pair, bodies.bodies.size(), poses.poses.size());
        const Body& body = bodies.bodies[static_cast<std::size_t>(pair.body_idx)];
        const auto world_from_rest = poser.world_from_rest(body, poses.poses[static_cast<std::size_t>(pair.pose_idx)]);
        set.add(pair, split,
                baseline == Baseline::gradient_skinning
                    ? gradient_skinning(poser, rest.poisson(pair.body_idx), body, world_from_rest)
                    : poser.volume(body, world_from_rest));
        progress.advance();
    }
    return set;
}

}  // namespace ndg
