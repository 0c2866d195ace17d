// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/core/provenance.h"

#include <string>
#include <vector>

namespace ndg {

/// What is known of a simulated scan: where every skin vertex and joint of the template really is.
struct TrueBody {
    std::string name;
    Points posed_skin;    ///< N_s x 3, m, in the scan's place, y up
    Points posed_joints;  ///< J x 3
    Points rest_skin;     ///< N_s x 3, the skin that was posed
    Points rest_joints;   ///< J x 3
};
struct ScanTruth {
    std::vector<TrueBody> bodies;
    /// Null if there is none of that name.
    const TrueBody* find(const std::string& name) const;
};

/// Format "ndg-scan-truth", version 1: /bodies/names (B), /bodies/posed_skin and /bodies/rest_skin (B x N_s x 3),
/// /bodies/posed_joints and /bodies/rest_joints (B x J x 3), float32, metres. read_scan_truth checks the sizes against
/// the template (InputError).
void write_scan_truth(const std::string& path, const ScanTruth& truth, const Provenance& provenance);
ScanTruth read_scan_truth(const std::string& path, const Template& body_template);

}  // namespace ndg
