// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/body/template.h"
#include "ndg/registration/nonrigid_fit.h"
#include "ndg/registration/placement.h"
#include "ndg/registration/rest_pose.h"
#include "ndg/registration/shape_prior.h"
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
    int placements = 3;           ///< that are fitted to the end where several are likely
    // Quality gate.
    double max_mean = 0.004;            ///< mean distance of covered scan points to the skin, m, scan noise included
    double min_coverage = 0.9;          ///< share of the scan's points within `covered` of the skin
    double min_seen = 0.7;              ///< share of the skin with a scan point within `covered`
    double covered = 0.015;             ///< m
    double min_segment_seen = 0.5;      ///< share of a segment that the scan shows; hands and feet 0.6 of that
    double min_segment_coverage = 0.8;  ///< share of the scan's points at a segment within `covered` of it
    double max_segment_mean = 0.006;    ///< mean distance of these, m
    double max_taller = 0.06;           ///< height of the fit over the scan's, m: crown and soles may be missing
    double max_shorter = 0.05;          ///< and below it; 6 cm more with shoes or hair
    double min_stature = 1.2, max_stature = 2.35;                     ///< m
    double min_shoulder_breadth = 0.15, max_shoulder_breadth = 0.26;  ///< between the joints, share of the stature
    double max_flipped = 0.001;                                       ///< share of the triangles
};
void describe(OptionList& list, FitOptions& options);

/// To be raised whenever the same options, template and scans come to give other fits: no batch is resumed then that
/// another method began.
inline constexpr int fit_method_version = 3;
/// What all fits of a batch depend on; `input_sha256`: of the template and, where there are any, the examples.
std::string fit_key(const FitOptions& options, const std::vector<std::string>& input_sha256);

/// How well a skin fits a scan at one of its segments. Covered skin is left out.
struct SegmentReport {
    std::string name;
    double seen = 0.0;      ///< share of the area near a scan point
    double coverage = 0.0;  ///< share of the scan's points at the segment that lie near it
    double mean = 0.0;      ///< distance of these to it, m
    double covered = 0.0;   ///< share of the area that clothes, shoes or hair cover, or that is another hand's shape
};

/// How well a skin fits a scan. Distances, coverage and what is seen are those of bare skin.
struct FitReport {
    std::string name, file, unit, up;
    bool unit_guessed = false, up_guessed = false;
    std::size_t file_points = 0, points = 0;
    double heading_degrees = 0.0;    ///< about the vertical, from the template's
    double scan_to_skin_mean = 0.0;  ///< of covered points, m
    double scan_to_skin_p95 = 0.0, scan_to_skin_max = 0.0;
    double skin_to_scan_mean = 0.0;  ///< of vertices that the scan shows, m
    double skin_to_scan_p95 = 0.0, skin_to_scan_max = 0.0;
    double coverage = 0.0;                       ///< share of the scan's points near the skin
    double seen = 0.0;                           ///< share of the skin's area near a scan point
    double stature = 0.0;                        ///< of the skin at rest, m
    double fit_height = 0.0, scan_height = 0.0;  ///< in the scan's pose, m
    double shoulder_breadth = 0.0;               ///< between the upper arms' joints at rest, m
    std::vector<SegmentReport> segments;
    int flipped_triangles = 0;         ///< turned by more than 90 degrees against the fitted template
    double smallest_area_ratio = 0.0;  ///< of a triangle over the fitted template's
    std::vector<int> worst_triangles;  ///< the five with the smallest area ratio
    double seconds = 0.0;
    std::vector<std::string> notes;     ///< what was done to the scan
    std::vector<std::string> warnings;  ///< what of the scan is not skin
    std::vector<std::string> defects;   ///< why the gate failed; empty when it holds
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

/// Landmarks of a scan by the template's names.
struct NamedLandmarks {
    Points in_file, on_template;          ///< L x 3, metres
    std::vector<LandmarkTarget> targets;  ///< positions in the template's place, once that is known
};

/// The template's skin fitted to a scan. Throws InputError for a scan that cannot be one (see prepare_scan) and for
/// landmarks that the template does not have. A fit that misses the quality gate is returned with its defects.
class BodyFitter {
public:
    /// `examples`: skins of the template's tessellation and pose with known joints, from which joints are learned and
    /// what people look like; may be empty. The template must outlive the fitter.
    BodyFitter(const Template& body_template, const FitOptions& options,
               const std::vector<JointExample>& examples = {});
    FittedBody fit(const std::string& name, const ScanPoints& scan, const ScanLandmarks& landmarks = {}) const;

private:
    struct State;
    NamedLandmarks find_landmarks(const std::string& name, const ScanLandmarks& landmarks,
                                  double metres_per_unit) const;
    State first_surface(const std::string& name, const ScanPoints& scan, NamedLandmarks landmarks) const;
    void take_likeliest_shape(State& state) const;
    void fit_pose_and_surface(State& state) const;
    Points to_rest(const State& state, const Pose& pose, Points& joints) const;

    const Template& template_;
    FitOptions options_;
    ArticulatedModel model_;
    Eigen::VectorXd areas_, stiffness_;  ///< of the vertices
    std::vector<SkinSegment> segments_;
    JointRegressor regressor_;
    ShapePrior prior_;
};

}  // namespace ndg
