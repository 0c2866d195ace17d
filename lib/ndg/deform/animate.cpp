// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/animate.h"

#include "ndg/core/error.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/progress.h"
#include "ndg/dataset/anatomy_file.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/deform/rest_cache.h"

#include <algorithm>
#include <numeric>
#include <optional>

namespace ndg {

void for_each_posed_batch(
    const SampleInputs& inputs, int batch_size, const std::string& task,
    const std::function<void(const std::vector<int>& sample_indices, const std::vector<PosedBody>& posed)>& use)
{
    const std::vector<SamplePair>& pairs = inputs.samples.pairs;
    for (const SamplePair& pair : pairs) require_pair(pair, inputs.bodies.bodies.size(), inputs.poses.poses.size());
    std::vector<int> order(pairs.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return pairs[a].body_idx < pairs[b].body_idx; });

    const BodyPoser poser(inputs.body_template, inputs.samples.posing);
    Progress progress(task, order.size());
    for (std::size_t begin = 0; begin < order.size(); begin += batch_size) {
        if (interrupt_requested()) throw Interrupted("stopped; nothing was written");
        const std::size_t end = std::min(begin + batch_size, order.size());
        const std::vector<int> sample_indices(order.begin() + begin, order.begin() + end);
        std::vector<PosedBody> posed;
        for (const int i : sample_indices) {
            const SamplePair& pair = pairs[i];
            posed.push_back(poser.pose(inputs.bodies.bodies[pair.body_idx], inputs.poses.poses[pair.pose_idx], pair));
        }
        use(sample_indices, posed);
        progress.advance(end - begin);
    }
}

void animate_samples(const SampleInputs& inputs, Deformer& deformer, const std::string& method,
                     const AnimationOutputs& outputs, const Provenance& provenance)
{
    const Template& body_template = inputs.body_template;
    DeformationSet head;
    static_cast<SampleIndex&>(head) = inputs.samples;
    head.method = method;
    head.num_volume_vertices = body_template.num_volume_vertices();
    DeformationWriter deformations(outputs.deformations, head, provenance);
    std::optional<AnatomyWriter> anatomy;
    if (!outputs.anatomy.empty()) {
        anatomy.emplace(outputs.anatomy, head, body_template.anatomy_triangles,
                        int(body_template.anatomy_vertices.rows()), provenance);
    }
    RestCache rest(body_template);
    for_each_posed_batch(inputs, deformer.batch_size(), "animating by " + method,
                         [&](const std::vector<int>& sample_indices, const std::vector<PosedBody>& posed) {
                             const std::vector<Points> vertices = deformer.deform_batch(posed);
                             for (std::size_t k = 0; k < posed.size(); ++k) {
                                 deformations.write(sample_indices[k], vertices[k]);
                                 if (anatomy) {
                                     anatomy->write(
                                         sample_indices[k],
                                         deformer.anatomy(posed[k], rest.anatomy(posed[k].body()), vertices[k]));
                                 }
                             }
                         });
    deformations.commit();
    if (anatomy) anatomy->commit();
}

}  // namespace ndg
