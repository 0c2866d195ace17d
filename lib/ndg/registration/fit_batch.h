// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/dataset/part_store.h"
#include "ndg/registration/fit_body.h"

#include <functional>
#include <string>
#include <vector>

namespace ndg {

/// Every mesh or point cloud among `paths`; of folders, those directly in them, by name. Throws InputError for a folder
/// without any and for two files whose names without extension are equal.
std::vector<std::string> scan_files(const std::vector<std::string>& paths);

/// One scan's outcome: a body, or the sentence that says why there is none.
struct BatchEntry {
    std::string file;
    FittedBody fitted;
    std::string failure;  ///< empty: fitted
    /// Of the body: the file's name without folder and extension.
    std::string name() const;
    /// Fitted, and the quality gate holds.
    bool passed() const { return failure.empty() && fitted.report.defects.empty(); }
};

struct BatchOptions {
    std::string landmarks;  ///< file of landmarks, or folder of NAME.json; empty: none
    std::string surfaces;   ///< folder for NAME.ply, the registered skin in the scan's place; empty: none
};

/// Fits all scans, in parallel, logging a line about each; finished ones are kept in `store`, whose key must hold all
/// that the fits depend on but the scans and their landmarks. A scan that cannot be read or fitted is entered with its
/// failure and skipped. Throws Interrupted, parts kept, once `stop` returns true. The result does not depend on threads
/// or interruptions.
std::vector<BatchEntry> fit_batch(const BodyFitter& fitter, const std::vector<std::string>& files,
                                  const FitOptions& fit_options, const Eigen::Ref<const Triangles>& triangles,
                                  const BatchOptions& options, const PartStore& store,
                                  const std::function<bool()>& stop);

/// Skins of the entries that passed the gate (or, with `keep_failed`, of all that were fitted), with parameters sex,
/// age_years, stature_m and fit_mean_m, and their poses. `person`: sex (0 female, 1 male) and age of a name.
SkinSet batch_skins(const std::vector<BatchEntry>& entries, bool keep_failed,
                    const std::function<std::pair<double, double>(const std::string&)>& person);
PoseSet batch_poses(const std::vector<BatchEntry>& entries, bool keep_failed);

}  // namespace ndg
