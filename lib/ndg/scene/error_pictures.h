// SPDX-License-Identifier: Apache-2.0
// Where on the body predictions are wrong, and which samples they are most wrong on.
#pragma once

#include "ndg/dataset/deformation_file.h"
#include "ndg/scene/pictures.h"

#include <string>
#include <vector>

namespace ndg {

/// Distance to the reference at each vertex of the wraps, N_w, m: half of its skin vertex's and half of its muscle
/// vertex's, averaged over the samples of `split` on which the reference converged (NDG Figure 7). Throws InputError
/// where a file lacks a sample, or where there is none.
Eigen::VectorXd mean_vertex_errors(const Template& body_template, const DeformationSet& reference,
                                   const DeformationSet& prediction, const std::string& split);

/// The template body's skin from the front and from behind, coloured by mean_vertex_errors, a column a prediction:
/// white is no error, full red `range_mm` or more. files[0] is the reference.
Image errors_picture(const Template& body_template, const std::vector<DeformationSet>& files, const std::string& split,
                     double range_mm, const PictureSettings& settings);

/// The `count` samples of `split` on which the mean distance of the free vertices is largest, the worst first; those on
/// which the reference did not converge do not count.
std::vector<SamplePair> worst_samples(const Template& body_template, const DeformationSet& reference,
                                      const DeformationSet& prediction, const std::string& split, int count);

}  // namespace ndg
