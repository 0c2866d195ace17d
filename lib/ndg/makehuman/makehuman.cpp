// SPDX-License-Identifier: Apache-2.0
#include "ndg/makehuman/makehuman.h"

#include "ndg/core/error.h"
#include "ndg/io/mesh.h"
#include "ndg/makehuman/files.h"
#include "ndg/makehuman/rig.h"

#include <cmath>
#include <map>
#include <mutex>
#include <set>
#include <vector>

namespace ndg {

const char* const makehuman_licence = "Body shapes: MakeHuman base mesh, targets, rig and weights (CC0 1.0)";

void MakeHumanParameters::check() const
{
    constexpr double max_fullness = 3.0;
    const auto in_range = [](const char* name, double value, double low, double high = 1.0) {
        require_input(std::isfinite(value) && value >= low && value <= high,
                      "MakeHuman parameter {} is {}, allowed is {} to {}", name, value, low, high);
    };
    in_range("sex", sex, 0.0);
    in_range("age", age, 0.5);
    in_range("weight", weight, 0.0);
    in_range("muscle", muscle, 0.0);
    in_range("height", height, 0.0);
    in_range("proportions", proportions, 0.0);
    in_range("fullness", fullness, 0.0, max_fullness);
    require_input(details.empty() || details.size() == makehuman_details().size(),
                  "MakeHuman's body was given {} details, it has {}", details.size(), makehuman_details().size());
    for (std::size_t i = 0; i < details.size(); ++i) in_range(makehuman_details()[i].c_str(), details[i], -1.0);
}

const std::vector<std::string>& makehuman_details()
{
    static const std::vector<std::string> names = {"torso/torso-scale-horiz",
                                                   "torso/torso-scale-depth",
                                                   "torso/torso-vshape",
                                                   "torso/torso-muscle-pectoral",
                                                   "torso/torso-muscle-dorsi",
                                                   "torso/measure-shoulder-dist",
                                                   "torso/measure-bust-circ",
                                                   "torso/measure-underbust-circ",
                                                   "torso/measure-waist-circ",
                                                   "torso/measure-hips-circ",
                                                   "torso/measure-napetowaist-dist",
                                                   "torso/measure-waisttohip-dist",
                                                   "hip/hip-scale-horiz",
                                                   "hip/hip-scale-depth",
                                                   "stomach/stomach-tone",
                                                   "stomach/stomach-pregnant",
                                                   "buttocks/buttocks-volume",
                                                   "pelvis/pelvis-tone",
                                                   "neck/measure-neck-circ",
                                                   "neck/measure-neck-height",
                                                   "arms/side-upperarm-fat",
                                                   "arms/side-lowerarm-fat",
                                                   "arms/side-upperarm-muscle",
                                                   "arms/side-lowerarm-muscle",
                                                   "arms/side-upperarm-shoulder-muscle",
                                                   "arms/measure-upperarm-length",
                                                   "arms/measure-lowerarm-length",
                                                   "legs/side-upperleg-fat",
                                                   "legs/side-lowerleg-fat",
                                                   "legs/side-upperleg-muscle",
                                                   "legs/side-lowerleg-muscle",
                                                   "legs/measure-upperleg-height",
                                                   "legs/measure-lowerleg-height",
                                                   "legs/measure-knee-circ",
                                                   "legs/measure-thigh-circ",
                                                   "legs/measure-calf-circ"};
    return names;
}

double makehuman_age_years(double age)
{
    return 25.0 + (age - 0.5) * 130.0;
}

namespace {

constexpr int num_body_vertices = 13380;
constexpr double metres_per_decimetre = 0.1;

using Components = std::vector<std::pair<std::string, double>>;

/// Two or three named components of a slider and their weights, MakeHuman's piecewise linear rule.
Components three_way(const std::string& name, double value)
{
    const double low = std::max(0.0, 1.0 - 2.0 * value), high = std::max(0.0, 2.0 * value - 1.0);
    return {{"min" + name, low}, {"average" + name, 1.0 - low - high}, {"max" + name, high}};
}

struct WeightedTarget {
    std::string file;
    double weight;
};

/// All macro targets with a non-zero product of component weights (macrodetails/macro.json, "combinations").
std::vector<WeightedTarget> macro_targets(const MakeHumanParameters& p)
{
    const Components sexes = {{"female", 1.0 - p.sex}, {"male", p.sex}};
    const double old = 2.0 * (p.age - 0.5);
    const Components ages = {{"young", 1.0 - old}, {"old", old}};
    const Components heights = {{"minheight", std::max(0.0, 1.0 - 2.0 * p.height)},
                                {"maxheight", std::max(0.0, 2.0 * p.height - 1.0)}};
    const Components proportions = {{"uncommonproportions", std::max(0.0, 1.0 - 2.0 * p.proportions)},
                                    {"idealproportions", std::max(0.0, 2.0 * p.proportions - 1.0)}};
    std::vector<WeightedTarget> targets;
    const auto add = [&](const std::string& file, double weight) {
        if (weight > 1e-9) targets.push_back({"targets/macrodetails/" + file + ".target.gz", weight});
    };
    for (const auto& [sex, w_sex] : sexes)
        for (const auto& [age, w_age] : ages) {
            for (const char* race : {"african", "asian", "caucasian"})
                add(std::string(race) + "-" + sex + "-" + age, w_sex * w_age / 3.0);
            for (const auto& [muscle, w_muscle] : three_way("muscle", p.muscle))
                for (const auto& [weight, w_weight] : three_way("weight", p.weight)) {
                    const std::string person = sex + "-" + age + "-" + muscle + "-" + weight;
                    const double product = w_sex * w_age * w_muscle * w_weight;
                    add("universal-" + person, product);
                    for (const auto& [height, w] : heights) add("height/" + person + "-" + height, product * w);
                    for (const auto& [proportion, w] : proportions)
                        add("proportions/" + person + "-" + proportion, product * w);
                }
        }
    return targets;
}

/// Measure targets that make a heavy body heavier where fat lies, and how much of each one unit of fullness is.
const Components& fullness_targets()
{
    static const Components targets = {
        {"torso/measure-underbust-circ-incr", 1.0}, {"torso/measure-waist-circ-incr", 1.0},
        {"torso/measure-hips-circ-incr", 1.0},      {"legs/measure-thigh-circ-incr", 0.8},
        {"legs/measure-calf-circ-incr", 0.4},       {"arms/measure-upperarm-circ-incr", 0.8},
        {"neck/measure-neck-circ-incr", 0.6},
    };
    return targets;
}

void add_detail_targets(const MakeHumanParameters& parameters, std::vector<WeightedTarget>& targets)
{
    if (parameters.fullness > 0.0)
        for (const auto& [name, share] : fullness_targets())
            targets.push_back({"targets/" + name + ".target.gz", share * parameters.fullness});
    for (std::size_t i = 0; i < parameters.details.size(); ++i) {
        const double value = parameters.details[i];
        if (value == 0.0) continue;
        const std::string& name = makehuman_details()[i];
        const std::size_t slash = name.find('/');
        const std::string folder = name.substr(0, slash + 1), rest = name.substr(slash + 1);
        const std::string end = std::string(value > 0.0 ? "-incr" : "-decr") + ".target.gz";
        // Targets of one limb stand for both.
        const bool one_side = rest.rfind("side-", 0) == 0;
        for (const char* side : {"l-", "r-"}) {
            const std::string file = one_side ? side + rest.substr(5) : rest;
            targets.push_back({"targets/" + folder + file + end, std::abs(value)});
            if (!one_side) break;
        }
    }
}

}  // namespace

struct MakeHuman::State {
    std::string folder;
    Points base_vertices;  ///< all vertices with the helpers', decimetre
    Triangles triangles;
    std::map<std::string, std::vector<int>> joint_cubes;
    RowMatrix weights;
    std::map<std::string, MakeHumanTarget> targets;
    std::mutex targets_mutex;

    const MakeHumanTarget& target(const std::string& file)
    {
        const std::lock_guard<std::mutex> lock(targets_mutex);
        const auto found = targets.find(file);
        if (found != targets.end()) return found->second;
        return targets[file] = read_makehuman_target(folder + "/" + file, static_cast<int>(base_vertices.rows()));
    }
};

MakeHuman::MakeHuman(const std::string& folder) : state_(std::make_unique<State>())
{
    state_->folder = folder;
    const std::string mesh_path = folder + "/3dobjs/base.obj";
    const MeshFile mesh = read_mesh(mesh_path);
    std::vector<int> body_rows;
    std::map<std::string, std::set<int>> cubes;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const std::string& group = mesh.triangle_groups[t];
        if (group == "body") body_rows.push_back(static_cast<int>(t));
        if (group.rfind("joint-", 0) == 0)
            for (int k = 0; k < 3; ++k) cubes[group].insert(mesh.triangles(t, k));
    }
    require_input(!body_rows.empty(), "{}: has no faces in a group named 'body'; is this MakeHuman's base mesh?",
                  mesh_path);
    state_->triangles.resize(static_cast<Eigen::Index>(body_rows.size()), 3);
    for (std::size_t i = 0; i < body_rows.size(); ++i) state_->triangles.row(i) = mesh.triangles.row(body_rows[i]);
    require_input(state_->triangles.maxCoeff() + 1 == num_body_vertices && mesh.vertices.rows() >= num_body_vertices,
                  "{}: group 'body' uses {} vertices, MakeHuman's has {}", mesh_path, state_->triangles.maxCoeff() + 1,
                  num_body_vertices);
    for (const auto& [name, vertices] : cubes) state_->joint_cubes[name].assign(vertices.begin(), vertices.end());
    state_->base_vertices = mesh.vertices;
    const ParametricSurface middle = evaluate({});
    state_->weights = makehuman_weights(folder + "/rigs/weights.game_engine.json", middle.vertices, middle.triangles,
                                        middle.joint_positions);
}

MakeHuman::~MakeHuman() = default;

const Triangles& MakeHuman::triangles() const
{
    return state_->triangles;
}
const RowMatrix& MakeHuman::weights() const
{
    return state_->weights;
}

ParametricSurface MakeHuman::evaluate(const MakeHumanParameters& parameters) const
{
    parameters.check();
    Points all = state_->base_vertices;
    std::vector<WeightedTarget> targets = macro_targets(parameters);
    add_detail_targets(parameters, targets);
    for (const WeightedTarget& weighted : targets) {
        const MakeHumanTarget& target = state_->target(weighted.file);
        for (std::size_t i = 0; i < target.vertices.size(); ++i)
            all.row(target.vertices[i]) += weighted.weight * target.offsets.row(static_cast<Eigen::Index>(i));
    }
    all *= metres_per_decimetre;
    ParametricSurface surface;
    surface.triangles = state_->triangles;
    surface.joint_positions = makehuman_joint_positions(all, state_->joint_cubes);
    surface.vertices = all.topRows(num_body_vertices);
    const Eigen::RowVector3d origin(surface.joint_positions(0, 0), surface.vertices.col(1).minCoeff(),
                                    surface.joint_positions(0, 2));
    surface.vertices.rowwise() -= origin;
    surface.joint_positions.rowwise() -= origin;
    return surface;
}

}  // namespace ndg
