// SPDX-License-Identifier: Apache-2.0
#include "ndg/protrusion/body_protrusion.h"

#include "geometry/shapes.h"
#include "ndg/body/anatomy.h"
#include "ndg/core/error.h"
#include "ndg/protrusion/coarse_parts.h"
#include "ndg/protrusion/protrusion_json.h"
#include "support/support.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

using namespace ndg;

namespace {

/// Five cubes apart from each other, one for each coarse part; the last one hangs halfway between a thigh and the
/// trunk.
Template cubes()
{
    Template body;
    body.skeleton = standard_skeleton();
    const test::Surface cube = test::cube();
    const std::vector<const char*> joints = {"spine_3",    "left_forearm", "right_hand",
                                             "left_thigh", "right_toes",   "left_thigh"};
    const int count = int(joints.size());
    body.rest.skin_vertices.resize(8 * count, 3);
    body.skin_triangles.resize(12 * count, 3);
    RowMatrix weights = RowMatrix::Zero(8 * count, num_standard_joints);
    for (int i = 0; i < count; ++i) {
        body.rest.skin_vertices.middleRows(8 * i, 8) = cube.vertices.rowwise() + Eigen::RowVector3d(2.0 * i, 0, 0);
        body.skin_triangles.middleRows(12 * i, 12) = cube.triangles.array() + 8 * i;
        weights.col(body.skeleton.joint(joints[i])).segment(8 * i, 8).setConstant(i == 5 ? 0.5 : 1.0);
        if (i == 5) weights.col(body.skeleton.joint("spine_1")).segment(8 * i, 8).setConstant(0.5);
    }
    body.skin_weights = sparsify_weights(weights);
    return body;
}

/// The skin with cube i moved by `x`.
Points moved(const Template& body, int i, const Eigen::RowVector3d& by)
{
    Points skin = body.rest.skin_vertices;
    skin.middleRows(8 * i, 8).rowwise() += by;
    return skin;
}

struct Tube {
    Template tube = test::tube_template();
    BodySet bodies;
    std::vector<Pose> poses = {test::tube_pose(0.0), test::tube_pose(0.5)};
    std::vector<SamplePair> pairs = {{0, 0}, {0, 1}};

    Tube() { bodies.bodies = {tube.rest}; }

    /// The posed tube with its skin drawn in to a share of its distance from the bone wrap.
    ProtrusionInput file(const std::string& method, double share) const
    {
        ProtrusionInput input{method + ".h5", {}};
        input.set.method = method;
        input.set.posing = test::bending;
        const BodyPoser poser(tube, test::bending);
        const int num_wrap = tube.num_wrap_vertices();
        for (const SamplePair& pair : pairs) {
            Points volume = poser.pose(tube.rest, poses[pair.pose_idx]).skinned_volume();
            const Points bone_wrap = poser.pose(tube.rest, poses[pair.pose_idx]).bone_wrap();
            volume.topRows(num_wrap) = bone_wrap;
            volume.bottomRows(num_wrap) = bone_wrap + share * (volume.bottomRows(num_wrap) - bone_wrap);
            input.set.add(pair, "test", volume);
        }
        return input;
    }
};

}  // namespace

TEST_CASE("Coarse parts collide where they pass into each other, not where they touch")
{
    const Template body = cubes();
    const CoarseParts parts(body);
    CHECK_FALSE(parts.collide(body.rest.skin_vertices));
    // An arm against the trunk, then into it.
    CHECK_FALSE(parts.collide(moved(body, 1, {-1.0, 0, 0})));
    CHECK(parts.collide(moved(body, 1, {-1.01, 0.3, 0.2})));
    // A foot into a thigh, a hand into the other arm.
    CHECK(parts.collide(moved(body, 4, {-1.5, 0.3, 0.2})));
    CHECK(parts.collide(moved(body, 2, {-1.5, 0.3, 0.2})));
    // What is half thigh and half trunk is a fold of the groin, not a part.
    CHECK_FALSE(parts.collide(moved(body, 5, {-3.5, 0.3, 0.2})));
}

TEST_CASE_METHOD(Tube, "Embedded anatomy follows the flesh of each method and is compared with its skin")
{
    const BodyProtrusion measured(tube);
    const Points anatomy_rest = anatomy_at_rest(tube, tube.rest);
    const BodyPoser poser(tube, test::bending);
    const PosedBody posed = poser.pose(tube.rest, poses[1]);
    const FrameProtrusion whole = measured.posed(posed, anatomy_rest, file("A", 1.0).set.points(1));
    const FrameProtrusion drawn_in = measured.posed(posed, anatomy_rest, file("B", -1.0).set.points(1));
    CHECK(whole.intersecting.empty());
    CHECK(whole.protruding_vertices == 0);
    CHECK(drawn_in.protruding_vertices > 0);
    CHECK(measured.deepest_part(drawn_in) == "muscle");  // further out than the bone
    CHECK(measured.deepest_part(whole).empty());
}

TEST_CASE_METHOD(Tube, "Files that do not fit are refused by name")
{
    ProtrusionInput incomplete = file("A", 1.0);
    incomplete.set.pairs.back() = {0, 7};
    CHECK_THROWS_WITH(body_protrusion(tube, bodies, poses, pairs, {incomplete}),
                      Catch::Contains("A.h5") && Catch::Contains("body 0 in pose 1"));
    ProtrusionInput rigid = file("B", 1.0);
    rigid.set.posing.bone_wrap = BoneWrap::rigid;
    CHECK_THROWS_WITH(body_protrusion(tube, bodies, poses, pairs, {file("A", 1.0), rigid}), Catch::Contains("B.h5"));
    CHECK_THROWS_AS(body_protrusion(tube, bodies, poses, pairs, {}), InputError);
    Template bare = tube;
    bare.anatomy_triangles.resize(0, 3);
    CHECK_THROWS_AS(BodyProtrusion(bare), InputError);
}

TEST_CASE_METHOD(Tube, "Table 3 over pairs")
{
    const ProtrusionTable table = body_protrusion(tube, bodies, poses, pairs, {file("A", 1.0), file("B", -1.0)});
    CHECK(table.pairs == 2);
    CHECK(table.colliding_pairs == 0);
    CHECK(table.bodies == 1);
    REQUIRE(table.rows.size() == 2);
    CHECK(table.rows[0].method == "A");
    CHECK(table.rows[0].protruding_frames == 0);
    CHECK(table.rows[1].protruding_frames == 100);
    CHECK(table.rows[1].protrusion_mm > 0);
    const nlohmann::json json = nlohmann::json::parse(protrusion_json(table, {}));
    CHECK(json["table3"]["B"]["protruding_frames"] == 100.0);
    CHECK(json["counts"]["table3_pairs"] == 2);
}
