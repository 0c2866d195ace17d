// SPDX-License-Identifier: Apache-2.0
// What becomes of bones and bone wrap in poses, moved by linear blend skinning and as rigid bones: rigidity, bones
// outside their wrap, gaps in knees and shoulders, collapse at joints, attachments of muscles, and the time a frame.
#include "clinical_pose.h"
#include "ndg/body/anatomy.h"
#include "ndg/body/pose_set.h"
#include "ndg/bones/bone_rig.h"
#include "ndg/core/error.h"
#include "ndg/core/stopwatch.h"
#include "ndg/core/tool.h"
#include "ndg/deform/posed_body.h"
#include "ndg/geometry/closest_point.h"
#include "ndg/geometry/rotation.h"
#include "ndg/motion/clinical_angles.h"
#include "ndg/scene/body_surfaces.h"
#include "ndg/scene/render.h"
#include "ndg/wraps/bone_interior.h"
#include "report.h"
#include "wrap_folds.h"

#include <Eigen/SVD>

#include <map>
#include <numeric>

using namespace ndg;

namespace {

using bench::NamedPose;

constexpr double mm = 1000.0;

/// Largest distance of points from the best rigid motion of where they were, m (Kabsch 1976).
double rigidity_defect(const Eigen::Ref<const Points>& rest, const Eigen::Ref<const Points>& posed)
{
    const Eigen::RowVector3d from = rest.colwise().mean(), to = posed.colwise().mean();
    const Eigen::Matrix3d covariance = (posed.rowwise() - to).transpose() * (rest.rowwise() - from);
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Vector3d sign = Eigen::Vector3d::Ones();
    if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0) sign[2] = -1.0;
    const Eigen::Matrix3d rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
    return ((rest.rowwise() - from) * rotation.transpose() - (posed.rowwise() - to)).rowwise().norm().maxCoeff();
}

/// Of a point outside the wrap whose nearest place lies on the rim of a cap: whether it is the cap that it is over.
bool went_through_cap(const ClosedBoneWrap& closed, Eigen::Index num_wrap_triangles, const TriangleTree& caps,
                      const ClosestPoint& nearest, const Eigen::Vector3d& point)
{
    constexpr double rounding = 1e-9;  // m
    const ClosestPoint on_cap = caps.closest(point);
    if (on_cap.distance > nearest.distance + rounding) return false;
    const auto height = [&](Eigen::Index t) {
        const auto corner = [&](int k) -> Eigen::Vector3d { return closed.vertices.row(closed.triangles(t, k)); };
        return (point - corner(0)).dot((corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized());
    };
    return height(num_wrap_triangles + on_cap.triangle_idx) > height(nearest.triangle_idx);
}

/// Volume of tetrahedra and lengths of wrap edges near a joint, against rest.
struct Region {
    std::string name;
    std::vector<int> tetrahedra;
    std::vector<std::array<int, 2>> edges;
    double volume = 0;
};

class Bench {
public:
    Bench(const Template& body_template, const Body& body) : template_(body_template), body_(body), list_(body_template)
    {
        anatomy_rest_ = anatomy_at_rest(body_template, body);
        inside_.resize(body_template.num_wrap_vertices() + body.interior_vertices.rows(), 3);
        stack_interior(body.volume_vertices, body.interior_vertices, inside_);
        for (const std::string joint : {"shin", "thigh", "upper_arm", "forearm"}) add_region(joint);
        find_attachments();
    }

    void measure(const std::string& mode, const std::vector<NamedPose>& poses, bool each, bench::Report& report);

    const BodyPoser& poser(const std::string& mode)
    {
        auto& poser = posers_[mode];
        if (!poser) poser = std::make_unique<BodyPoser>(template_, PosingOptions{parse_name<BoneWrap>(mode)});
        return *poser;
    }

private:
    /// Seconds of this thread are added: motions of bones, blending, clearance.
    void time_parts(const PosedBody& posed, std::array<double, 3>& seconds)
    {
        if (!rigged_) rigged_ = std::make_unique<RiggedBodies>(template_);
        const auto rig = rigged_->of(body_);
        const auto rest_wrap = body_.volume_vertices.topRows(template_.num_wrap_vertices());
        const double start = thread_seconds();
        const auto segments = rig->motion.segments(posed.world_from_rest());
        const double moved = thread_seconds();
        Points wrap = dual_quaternion_blending(rest_wrap, rigged_->rig().wrap_weights, segments);
        const double blended = thread_seconds();
        rig->clearance.push_out(segments, wrap);
        seconds[0] += moved - start;
        seconds[1] += blended - moved;
        seconds[2] += thread_seconds() - blended;
    }

    struct Attachment {
        int vertex;
        Eigen::RowVector3i triangle;
        ClosestPoint on_bone;
    };

    static void stack_interior(const Points& volume, const Points& interior, Points& inside)
    {
        const Eigen::Index wrap = inside.rows() - interior.rows();
        inside.topRows(wrap) = volume.topRows(wrap);
        inside.bottomRows(interior.rows()) = interior;
    }

    static double volume_of(const Points& x, const Eigen::RowVector4i& t)
    {
        const Eigen::Vector3d a = x.row(t[1]) - x.row(t[0]), b = x.row(t[2]) - x.row(t[0]),
                              c = x.row(t[3]) - x.row(t[0]);
        return a.cross(b).dot(c) / 6.0;
    }

    void add_region(const std::string& joint)
    {
        constexpr double reach = 0.09;
        Region region;
        region.name = joint;
        for (const std::string side : {"left_", "right_"}) {
            const Eigen::RowVector3d centre = body_.joint_positions.row(template_.skeleton.joint(side + joint));
            for (Eigen::Index t = 0; t < template_.tetrahedra.rows(); ++t) {
                Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
                for (int k = 0; k < 4; ++k) middle += 0.25 * inside_.row(template_.tetrahedra(t, k));
                if ((middle - centre).norm() < reach) region.tetrahedra.push_back(int(t));
            }
            for (Eigen::Index t = 0; t < template_.wrap_triangles.rows(); ++t)
                for (int k = 0; k < 3; ++k) {
                    const int a = template_.wrap_triangles(t, k), b = template_.wrap_triangles(t, (k + 1) % 3);
                    if (a < b && (0.5 * (inside_.row(a) + inside_.row(b)) - centre).norm() < reach)
                        region.edges.push_back({a, b});
                }
        }
        for (const int t : region.tetrahedra) region.volume += volume_of(inside_, template_.tetrahedra.row(t));
        regions_.push_back(region);
    }

    /// Muscle vertices within 3 mm of a bone at rest, and where on the nearest.
    void find_attachments()
    {
        constexpr double reach = 0.003;
        std::map<int, Attachment> nearest;
        for (const BoneList::Bone& bone : list_.bones) {
            const TriangleTree tree(anatomy_rest_, template_.anatomy_triangles.middleRows(
                                                       bone.triangle_begin, bone.triangle_end - bone.triangle_begin));
            Eigen::AlignedBox3d box;
            for (int v = bone.vertex_begin; v < bone.vertex_end; ++v) box.extend(anatomy_rest_.row(v).transpose());
            for (const AnatomyPart& part : template_.anatomy_parts) {
                if (part.layer != AnatomyLayer::muscle) continue;
                for (int v = part.vertex_begin; v < part.vertex_end; ++v) {
                    const Eigen::Vector3d x = anatomy_rest_.row(v).transpose();
                    if (template_.embedding.elements[v] < 0 || box.exteriorDistance(x) > reach) continue;
                    const ClosestPoint closest = tree.closest(x);
                    if (closest.distance > reach) continue;
                    const auto [known, is_new] = nearest.try_emplace(v);
                    if (!is_new && known->second.on_bone.distance <= closest.distance) continue;
                    known->second = {v, template_.anatomy_triangles.row(bone.triangle_begin + closest.triangle_idx),
                                     closest};
                }
            }
        }
        for (const auto& [v, attachment] : nearest) attachments_.push_back(attachment);
    }

    const Template& template_;
    const Body& body_;
    BoneList list_;
    Points anatomy_rest_, inside_;
    std::vector<Region> regions_;
    std::vector<Attachment> attachments_;
    std::map<std::string, std::unique_ptr<BodyPoser>> posers_;
    std::unique_ptr<RiggedBodies> rigged_;
};

void Bench::measure(const std::string& mode, const std::vector<NamedPose>& poses, bool each, bench::Report& report)
{
    const BodyPoser& poser_of_mode = poser(mode);
    std::array<double, 3> parts = {};
    double worst_rigid = 0, worst_outside = 0, seconds = 0, worst_attached = 0;
    std::string worst_rigid_name, worst_outside_name, worst_attached_name;
    std::vector<double> outside_millimetres, attached, folded;
    std::map<std::string, double> folded_at;  // nearest joint
    std::map<std::string, double> outside_of;
    std::map<std::string, std::vector<double>> volumes, shortest, longest;
    for (const NamedPose& named : poses) {
        poser_of_mode.pose(body_, named.pose).bone_wrap();
        const double start = thread_seconds();
        const PosedBody posed = poser_of_mode.pose(body_, named.pose);
        posed.bone_wrap();
        seconds += thread_seconds() - start;
        if (mode == "rigid") time_parts(posed, parts);
        const Points volume = posed.skinned_volume(), anatomy = posed.anatomy(anatomy_rest_, volume);
        Points inside(inside_.rows(), 3);
        stack_interior(volume, posed.bone_interior(), inside);

        double pose_outside = 0;
        std::string pose_outside_name;
        const ClosedBoneWrap closed = close_bone_wrap(posed.bone_wrap(), template_.wrap_triangles);
        const TriangleTree wrap(closed.vertices, closed.triangles);
        const TriangleTree caps(closed.vertices,
                                closed.triangles.bottomRows(closed.triangles.rows() - template_.wrap_triangles.rows()));
        std::vector<int> suspects;
        std::vector<double> distances;
        std::vector<std::string> names;
        for (const AnatomyPart& part : template_.anatomy_parts) {
            if (part.layer != AnatomyLayer::bone) continue;
            const int begin = part.vertex_begin, count = part.vertex_end - begin;
            const double defect =
                rigidity_defect(anatomy_rest_.middleRows(begin, count), anatomy.middleRows(begin, count));
            if (defect > worst_rigid) {
                worst_rigid = defect;
                worst_rigid_name = part.name + " in " + named.name;
            }
            for (int v = begin; v < part.vertex_end; ++v) {
                if (template_.embedding.elements[v] < 0) continue;
                ClosestPoint nearest;
                const double distance = wrap.signed_distance(anatomy.row(v).transpose(), &nearest);
                // Through the caps bones go on into head, hands and toes.
                if (distance < 0.0005 || nearest.triangle_idx >= template_.wrap_triangles.rows()) continue;
                if (went_through_cap(closed, template_.wrap_triangles.rows(), caps, nearest,
                                     anatomy.row(v).transpose()))
                    continue;
                suspects.push_back(v);
                distances.push_back(distance);
                names.push_back(part.name);
            }
        }
        // Where the wrap touches itself the nearest triangle may belong to the other side.
        Points points(Eigen::Index(suspects.size()), 3);
        for (std::size_t i = 0; i < suspects.size(); ++i) points.row(Eigen::Index(i)) = anatomy.row(suspects[i]);
        const Eigen::VectorXd winding = winding_numbers(closed.vertices, closed.triangles, points);
        int count_outside = 0;
        for (std::size_t i = 0; i < suspects.size(); ++i) {
            if (winding[Eigen::Index(i)] > 0.5) continue;
            outside_millimetres.push_back(mm * distances[i]);
            double& known = outside_of[names[i] + " in " + named.name];
            known = std::max(known, mm * distances[i]);
            count_outside += distances[i] > 0.001;
            if (distances[i] > pose_outside) {
                pose_outside = distances[i];
                pose_outside_name = names[i];
            }
        }
        if (pose_outside > worst_outside) {
            worst_outside = pose_outside;
            worst_outside_name = pose_outside_name + " in " + named.name;
        }
        const std::vector<int> folds = bench::folded_vertices(posed.bone_wrap(), template_.wrap_triangles);
        folded.push_back(double(folds.size()));
        for (const int v : folds) {
            Eigen::Index joint = 0;
            (body_.joint_positions.rowwise() - inside_.row(v)).rowwise().squaredNorm().minCoeff(&joint);
            folded_at[template_.skeleton.joint_names[joint]] += 1.0 / double(poses.size());
        }
        for (const Region& region : regions_) {
            double now = 0;
            for (const int t : region.tetrahedra) now += volume_of(inside, template_.tetrahedra.row(t));
            std::vector<double> ratios;
            for (const auto& [a, b] : region.edges)
                ratios.push_back((inside.row(a) - inside.row(b)).norm() / (inside_.row(a) - inside_.row(b)).norm());
            volumes[region.name].push_back(now / region.volume);
            shortest[region.name].push_back(bench::quantile(ratios, 0.01));
            longest[region.name].push_back(bench::quantile(ratios, 0.99));
        }
        for (const Attachment& one : attachments_) {
            Eigen::Vector3d on_bone = Eigen::Vector3d::Zero();
            for (int k = 0; k < 3; ++k)
                on_bone += one.on_bone.barycentric[k] * anatomy.row(one.triangle[k]).transpose();
            const double gap = (anatomy.row(one.vertex).transpose() - on_bone).norm() - one.on_bone.distance;
            attached.push_back(mm * gap);
            if (gap > worst_attached) {
                worst_attached = gap;
                for (const AnatomyPart& part : template_.anatomy_parts)
                    if (one.vertex >= part.vertex_begin && one.vertex < part.vertex_end)
                        worst_attached_name = part.name + " in " + named.name;
            }
        }
        if (each) {
            fmt::print("{:<6} {:<15} outside {:5.1f} mm ({}, {} vertices > 1 mm), {} folded;", mode, named.name,
                       mm * pose_outside, pose_outside_name, count_outside, folds.size());
            for (const Region& region : regions_)
                fmt::print(" {} {:.2f} ({:.2f}-{:.2f})", region.name, volumes[region.name].back(),
                           shortest[region.name].back(), longest[region.name].back());
            fmt::print("\n");
        }
    }
    fmt::print("{}: not rigid by {:.3f} mm: {}; {:.1f} mm outside the wrap: {}; attachments off by {:.1f} mm: {}\n",
               mode, mm * worst_rigid, worst_rigid_name, mm * worst_outside, worst_outside_name, mm * worst_attached,
               worst_attached_name);
    if (!each) {
        std::vector<std::pair<double, std::string>> sorted;
        for (const auto& [name, value] : outside_of)
            if (value > 0.9) sorted.emplace_back(value, name);
        std::sort(sorted.rbegin(), sorted.rend());
        fmt::print("outside in {} cases:", sorted.size());
        for (std::size_t i = 0; i < std::min<std::size_t>(sorted.size(), 25); ++i)
            fmt::print(" {} {:.1f};", sorted[i].second, sorted[i].first);
        sorted.clear();
        for (const auto& [name, value] : folded_at) sorted.emplace_back(value, name);
        std::sort(sorted.rbegin(), sorted.rend());
        fmt::print("\nfolded:");
        for (std::size_t i = 0; i < std::min<std::size_t>(sorted.size(), 20); ++i)
            fmt::print(" {} {:.2f}", sorted[i].second, sorted[i].first);
        fmt::print("\n");
    }
    report.add(mode + "_folded_vertices", std::accumulate(folded.begin(), folded.end(), 0.0) / double(folded.size()));
    report.add(mode + "_rigidity_defect_mm", mm * worst_rigid);
    report.add(mode + "_bones_outside_mm", mm * worst_outside);
    report.add(mode + "_bone_vertices_outside_1mm",
               double(std::count_if(outside_millimetres.begin(), outside_millimetres.end(),
                                    [](double d) { return d > 1.0; })) /
                   double(poses.size()));
    for (const Region& region : regions_) {
        report.add(mode + "_" + region.name + "_volume_min", bench::quantile(volumes[region.name], 0));
        report.add(mode + "_" + region.name + "_edge_p1_min", bench::quantile(shortest[region.name], 0));
        report.add(mode + "_" + region.name + "_edge_p99_max", bench::quantile(longest[region.name], 1));
    }
    if (!attached.empty()) {
        report.add(mode + "_attachment_gap_p50_mm", bench::quantile(attached, 0.5));
        report.add(mode + "_attachment_gap_p99_mm", bench::quantile(attached, 0.99));
        report.add(mode + "_attachment_gap_max_mm", bench::quantile(attached, 1));
    }
    if (mode == "rigid") {
        report.add("rigid_bone_motions_ms", 1000 * parts[0] / double(poses.size()));
        report.add("rigid_blending_ms", 1000 * parts[1] / double(poses.size()));
        report.add("rigid_clearance_ms", 1000 * parts[2] / double(poses.size()));
    }
    report.add(mode + "_milliseconds_a_frame", 1000 * seconds / double(poses.size()));
}

/// Bone wrap with bones, and bones alone, whole and close to joints: one row a view.
void write_picture(const std::string& path, const PosedBody& posed, const std::string& joint)
{
    const Template& body_template = posed.body_template();
    const BodyGeometry geometry = skinned_geometry(posed);
    const std::vector<SceneSurface> anatomy = anatomy_surfaces(body_template, geometry);
    SceneSurface wrap = bone_wrap_surface(body_template, geometry);
    SceneSurface glass = wrap;
    glass.opacity = 0.25f;
    glass.edge_opacity = 0.7f;
    const std::vector<std::vector<SceneSurface>> columns = {{wrap}, {glass, anatomy[0]}};
    Points framed = geometry.skin_vertices;
    if (!joint.empty()) {
        const int j = body_template.skeleton.joint(joint);
        const Eigen::RowVector3d centre =
            (posed.world_from_rest()[j] * posed.body().joint_positions.row(j).transpose()).transpose();
        framed.resize(2, 3);
        framed << centre.array() - 0.09, centre.array() + 0.09;
    }
    std::vector<Image> images;
    RenderSettings settings;
    settings.width = settings.height = 600;
    settings.samples_per_axis = 1;
    settings.occlusion_rays = 12;
    for (const View view : {View::left, View::three_quarter})
        for (const auto& surfaces : columns)
            images.push_back(
                render(surfaces, frame_points(framed, view_direction(view, geometry.heading), 1.0), settings));
    write_png(path, tile_images(images, 4, {}, {244, 245, 246}));
}

}  // namespace

int main(int argc, char** argv)
{
    Tool tool("bench-rigid-bones",
              "Measures bones and bone wrap in poses, by linear blend skinning and as rigid bones.",
              "bench_rigid_bones --template out/desk/template.h5 --poses out/desk/poses.h5");
    std::string template_path, bodies_path, poses_path, output, pictures;
    int body_idx = 0, num_poses = 200, pictured = -1;
    tool.input("template", template_path, "template with bones");
    tool.input("bodies", bodies_path, "bodies; the template's own without it", false);
    tool.input("poses", poses_path, "poses of the motion set; without it only the named ones", false);
    tool.parameter("body", body_idx, "which of the bodies", 0, 1 << 30);
    tool.parameter("pose-count", num_poses, "of the motion set, spread evenly", 1, 100000);
    tool.parameter("pictures", pictures, "folder for pictures of the named poses; empty: none");
    tool.parameter("pictured-pose", pictured, "this pose of --poses instead of the named ones; -1: none", -1, 1 << 30);
    tool.output("output", output, "JSON result", false);
    return tool.run(argc, argv, [&] {
        const Template body_template = read_template(template_path);
        Body body = body_template.rest;
        if (!bodies_path.empty()) {
            const BodySet bodies = read_bodies(bodies_path, body_template);
            require_input(body_idx < int(bodies.bodies.size()), "{}: has {} bodies, --body is {}", bodies_path,
                          bodies.bodies.size(), body_idx);
            body = bodies.bodies[body_idx];
        }
        const ClinicalFrames frames(body.joint_positions);
        std::vector<NamedPose> named = bench::named_poses(frames);
        std::vector<NamedPose> all = named;
        const std::vector<NamedPose> deep = bench::deep_knee_bends(frames);
        all.insert(all.end(), deep.begin(), deep.end());
        if (!poses_path.empty()) {
            const PoseSet poses = read_poses(poses_path);
            if (pictured >= 0 && pictured < poses.size()) {
                named = {{fmt::format("pose-{}", pictured), poses.poses[pictured]}};
                all = named;
            }
            for (int i = 0; pictured < 0 && i < std::min(num_poses, poses.size()); ++i) {
                const int p = int(std::int64_t(i) * poses.size() / std::min(num_poses, poses.size()));
                all.push_back({fmt::format("pose {}", p), poses.poses[p]});
            }
        }
        Bench bench(body_template, body);
        bench::Report report("rigid_bones");
        for (const std::string& mode : names<BoneWrap>()) {
            const BodyPoser& poser = bench.poser(mode);
            bench.measure(mode, named, true, report);
            if (all.size() > named.size()) {
                bench::Report of_all("rigid_bones_" + mode);
                bench.measure(mode, all, false, of_all);
                of_all.print();
            }
            if (pictures.empty()) continue;
            for (const NamedPose& one : named) {
                const PosedBody posed = poser.pose(body, one.pose);
                for (const std::string joint : {"", "left_shin", "left_thigh", "left_upper_arm", "left_forearm"}) {
                    if (joint == "left_forearm" && one.name != "pronated") continue;
                    write_picture(
                        fmt::format("{}/{}-{}{}{}.png", pictures, one.name, joint, joint.empty() ? "" : "-", mode),
                        posed, joint);
                }
            }
        }
        report.print();
        if (!output.empty()) report.write(output);
    });
}
