// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/registration/nonrigid_fit.h"
#include "ndg/registration/rest_pose.h"
#include "ndg/registration/start_shape.h"
#include "ndg/scan/scan.h"

#include <string>
#include <utility>
#include <vector>

namespace ndg {

struct FitOptions {
    ScanOptions scan;
    ArticulatedFitOptions articulated;
    NonrigidFitOptions nonrigid;
    double armpit_factor = 1e4;   ///< NDG 4.1
    double armpit_radius = 0.04;  ///< m, around each armpit
    int rounds = 2;               ///< of pose and proportions, then surface
    // Quality gate.
    double max_mean = 0.004;    ///< mean distance of covered scan points to the skin, m, scan noise included
    double min_coverage = 0.9;  ///< share of the scan's points within `covered` of the skin
    double min_seen = 0.7;      ///< share of the skin with a scan point within `covered`
    double covered = 0.015;     ///< m
    double min_stature = 1.2, max_stature = 2.35;  ///< m
    double max_flipped = 0.001;                    ///< share of the triangles
};
void describe(OptionList& list, FitOptions& options);

/// To be raised whenever the same options, template and scans come to give other fits: no batch is resumed then that
/// another method began.
inline constexpr int fit_method_version = 1;
/// What all fits of a batch depend on; `input_sha256`: of the template and, where there are any, the examples.
std::string fit_key(const FitOptions& options, const std::vector<std::string>& input_sha256);

/// How well a skin fits a scan.
struct FitReport {
    std::string name, file, unit, up;
    bool unit_guessed = false, up_guessed = false;
    std::size_t file_points = 0, points = 0;
    double heading_degrees = 0.0;    ///< about the vertical, from the template's
    double scan_to_skin_mean = 0.0;  ///< of covered points, m
    double scan_to_skin_p95 = 0.0, scan_to_skin_max = 0.0;
    double skin_to_scan_mean = 0.0;  ///< of vertices that the scan shows, m
    double skin_to_scan_p95 = 0.0, skin_to_scan_max = 0.0;
    double coverage = 0.0;             ///< share of the scan's points near the skin
    double seen = 0.0;                 ///< share of the skin's area near a scan point
    double stature = 0.0;              ///< of the skin at rest, m
    int flipped_triangles = 0;         ///< turned by more than 90 degrees against the fitted template
    double smallest_area_ratio = 0.0;  ///< of a triangle over the fitted template's
    std::vector<int> worst_triangles;  ///< the five with the smallest area ratio
    double seconds = 0.0;
    std::vector<std::string> defects;  ///< why the gate failed; empty when it holds
};

struct FittedBody {
    Skin body;            ///< skin and joints at rest, in the template's pose, feet on y = 0
    Pose pose;            ///< moves them onto the scan (metres, y up)
    Points posed_skin;    ///< N_s x 3: linear_blend_skinning of the body in the pose
    Points posed_joints;  ///< J x 3
    FitReport report;
};

/// Landmarks of a scan in the file's axes and unit, by the template's names.
using ScanLandmarks = std::vector<std::pair<std::string, Eigen::Vector3d>>;
/// JSON object {"name": [x, y, z], ...}. Throws InputError naming file and key.
ScanLandmarks read_scan_landmarks(const std::string& path);

/// The template's skin fitted to a scan. Throws InputError for a scan that cannot be one (see prepare_scan) and for
/// landmarks that the template does not have. A fit that misses the quality gate is returned with its defects.
class BodyFitter {
public:
    /// `examples`: skins of the template's tessellation and pose with known joints, from which joints are learned and
    /// start shapes are taken; may be empty. The template must outlive the fitter.
    BodyFitter(const Template& body_template, const FitOptions& options,
               const std::vector<JointExample>& examples = {});
    FittedBody fit(const std::string& name, const ScanPoints& scan, const ScanLandmarks& landmarks = {}) const;

private:
    Points to_rest(const Points& registered, const Pose& pose, Points& joints) const;

    const Template& template_;
    FitOptions options_;
    ArticulatedModel model_;
    Eigen::VectorXd stiffness_;
    JointRegressor regressor_;
    StartShapes starts_;
};

}  // namespace ndg
