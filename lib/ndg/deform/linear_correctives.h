// SPDX-License-Identifier: Apache-2.0
// Linear blend skinning with correctives that are linear in the pose: the structure of SMPL (Loper et al. 2015) and
// SKEL (Keller et al. 2023), fitted to samples of ours (fit_correctives.h).
#pragma once

#include "ndg/deform/deformer.h"
#include "ndg/deform/rest_offsets.h"

#include <string>
#include <vector>

namespace ndg {

/// X = LBS(X_rest + offsets), offsets = sum_k f_k B_k, where f are the entries of R_j - I of the joints that flesh can
/// see, and B_k blend shapes that all bodies share. The rest pose has no offsets.
struct LinearCorrectives {
    std::vector<int> joints;  ///< K, Template::visible_joints as a list
    PosingOptions posing;     ///< of the samples
    RowMatrixF blend_shapes;  ///< 9 K x 6 N_w: rows as features(), columns x y z of every free vertex, m
    double ridge = 0;         ///< that of the fit
    std::string template_sha256;

    /// R_j - I row by row, joint after joint; 9 K.
    Eigen::RowVectorXf features(const Pose& pose) const;
    /// For RestOffsets::vertices; 2 N_w x 3.
    Points offsets(const Pose& pose) const;
};

/// The joints that correctives see. Throws InputError where flesh can see none.
std::vector<int> corrective_joints(const Template& body_template);

/// Format "ndg-correctives", version 1 (docs/formats.md).
void write_correctives(const std::string& path, const LinearCorrectives& correctives, const Template& body_template,
                       const Provenance& provenance);
/// Throws InputError where the file does not fit the template.
LinearCorrectives read_correctives(const std::string& path, const Template& body_template);

/// "linear-correctives", with the option --correctives.
void register_linear_correctives(MethodTable& table);

}  // namespace ndg
