// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/reconstruct.h"

#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/core/progress.h"
#include "ndg/dataset/anatomy_file.h"
#include "ndg/deform/posed_body.h"
#include "ndg/deform/rest_cache.h"

#include <optional>

namespace ndg {

DeformationSet reconstruct_samples(const Template& body_template, const BodySet& bodies, const PoseSet& poses,
                                   const GradientReader& gradients, const std::string& anatomy_path,
                                   const Provenance& provenance)
{
    const BodyPoser poser(body_template);
    RestCache rest(body_template, bodies);
    DeformationSet set;
    set.method = gradients.index().method;
    set.num_volume_vertices = body_template.num_volume_vertices();
    for (const SamplePair& pair : gradients.index().pairs) require_pair(pair, bodies.bodies.size(), poses.poses.size());
    std::optional<AnatomyWriter> anatomy;
    if (!anatomy_path.empty()) {
        anatomy.emplace(anatomy_path, gradients.index(), body_template.anatomy_triangles,
                        static_cast<int>(body_template.anatomy_vertices.rows()), provenance);
    }
    Progress progress("reconstructing", gradients.index().pairs.size());
    for (int i = 0; i < gradients.size(); ++i) {
        const SamplePair& pair = gradients.index().pairs[static_cast<std::size_t>(i)];
        const Body& body = bodies.bodies[static_cast<std::size_t>(pair.body_idx)];
        const auto world_from_rest = poser.world_from_rest(body, poses.poses[static_cast<std::size_t>(pair.pose_idx)]);
        const std::vector<float> stored = gradients.read(i);
        const Eigen::Map<const GradientsF> sample(stored.data(), gradients.num_prisms(), 9);
        const Points vertices = rest.poisson(pair.body_idx).reconstruct(sample, poser.bone_wrap(body, world_from_rest));
        set.add(pair, gradients.index().pair_splits[static_cast<std::size_t>(i)], vertices);
        if (anatomy) {
            anatomy->write(i, deformed_anatomy(body_template, anatomy_at_rest(body_template, body), vertices,
                                               poser.interior(body, world_from_rest), world_from_rest));
        }
        progress.advance();
    }
    if (anatomy) anatomy->commit();
    return set;
}

}  // namespace ndg
