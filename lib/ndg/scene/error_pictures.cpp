// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/error_pictures.h"

#include "ndg/core/error.h"

#include <algorithm>
#include <functional>

namespace ndg {

namespace {

/// Calls use(pair, distances of the volume vertices, N_v) for every sample of the split.
void for_each_difference(const Template& body_template, const DeformationSet& reference,
                         const DeformationSet& prediction, const std::string& split,
                         const std::function<void(const SamplePair&, const Eigen::VectorXd&)>& use)
{
    const auto converged = reference.statistics.find("converged");
    for (int i = 0; i < reference.size(); ++i) {
        if (reference.pair_splits[i] != split) continue;
        if (converged != reference.statistics.end() && converged->second[i] == 0) continue;
        const SamplePair& pair = reference.pairs[i];
        const auto found = std::find(prediction.pairs.begin(), prediction.pairs.end(), pair);
        require_input(found != prediction.pairs.end(), "The {} file has no sample of {}", prediction.method,
                      describe(pair));
        const Points target = reference.points(i), predicted = prediction.points(int(found - prediction.pairs.begin()));
        require_input(target.rows() == body_template.num_volume_vertices() && predicted.rows() == target.rows(),
                      "{} and {} have {} and {} vertices, the template has {}", reference.method, prediction.method,
                      target.rows(), predicted.rows(), body_template.num_volume_vertices());
        use(pair, (predicted - target).rowwise().norm());
    }
}

}  // namespace

Eigen::VectorXd mean_vertex_errors(const Template& body_template, const DeformationSet& reference,
                                   const DeformationSet& prediction, const std::string& split)
{
    const int num_wrap = body_template.num_wrap_vertices();
    Eigen::VectorXd errors = Eigen::VectorXd::Zero(num_wrap);
    int count = 0;
    for_each_difference(body_template, reference, prediction, split,
                        [&](const SamplePair&, const Eigen::VectorXd& distances) {
                            errors += 0.5 * (distances.segment(num_wrap, num_wrap) + distances.tail(num_wrap));
                            ++count;
                        });
    require_input(count > 0, "The {} file has no converged sample of split {}", reference.method, split);
    return errors / count;
}

Image errors_picture(const Template& body_template, const std::vector<DeformationSet>& files, const std::string& split,
                     double range_mm, const PictureSettings& settings)
{
    require_input(files.size() >= 2, "A picture of errors needs a reference and a prediction at least");
    const BodyGeometry geometry = rest_geometry(body_template, body_template.rest);
    const Eigen::RowVector3f none(0.97f, 0.97f, 0.97f), full(0.75f, 0.05f, 0.10f), beyond_cuts(0.72f, 0.74f, 0.77f);
    std::vector<Image> images(2 * (files.size() - 1));
    SheetLabels labels;
    labels.footer = fmt::format("mean distance to {} of skin and muscle vertices: white none, red {:g} mm or more",
                                files[0].method, range_mm);
    for (std::size_t f = 1; f < files.size(); ++f) {
        const Eigen::VectorXd errors = mean_vertex_errors(body_template, files[0], files[f], split);
        labels.columns.push_back(fmt::format("{} {:.2f} mm", files[f].method, 1e3 * errors.mean()));
        SceneSurface surface = skin_surface(body_template, geometry);
        surface.gloss = 0.05f;
        surface.vertex_colours = beyond_cuts.replicate(surface.vertices.rows(), 1);
        for (int w = 0; w < errors.size(); ++w) {
            const float share = float(std::min(1.0, 1e3 * errors[w] / range_mm));
            surface.vertex_colours.row(body_template.wrap_to_skin[w]) = (1 - share) * none + share * full;
        }
        images[f - 1] = surface_picture(surface, View::front, settings);
        images[files.size() - 1 + f - 1] = surface_picture(surface, View::back, settings);
    }
    return tile_images(images, int(files.size()) - 1, labels);
}

std::vector<SamplePair> worst_samples(const Template& body_template, const DeformationSet& reference,
                                      const DeformationSet& prediction, const std::string& split, int count)
{
    std::vector<std::pair<double, SamplePair>> samples;
    const int num_free = body_template.num_volume_vertices() - body_template.num_wrap_vertices();
    for_each_difference(body_template, reference, prediction, split,
                        [&](const SamplePair& pair, const Eigen::VectorXd& distances) {
                            samples.emplace_back(-distances.tail(num_free).mean(), pair);
                        });
    std::sort(samples.begin(), samples.end());
    std::vector<SamplePair> worst;
    for (int i = 0; i < std::min(count, int(samples.size())); ++i) worst.push_back(samples[i].second);
    return worst;
}

}  // namespace ndg
