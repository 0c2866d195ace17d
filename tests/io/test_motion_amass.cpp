// SPDX-License-Identifier: Apache-2.0
// AMASS archives as numpy itself writes them.
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/io/motion.h"
#include "ndg/io/npz.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <iostream>
#include <map>

using namespace ndg;
using Catch::Matchers::Contains;

namespace {

/// Frame 0 stands in the T pose; in frame 1 the root turns by 120 degrees about (1, 1, 1) on top of that, the left
/// thigh swings forward by 90 degrees and the right elbow folds by 90 degrees about y.
constexpr const char* script = R"(import numpy as np
h = np.pi / 2
poses = np.zeros((2, 156))
poses[:, 0] = h
poses[1, 3:6] = [-h, 0, 0]
poses[1, 3 * 19:3 * 19 + 3] = [0, h, 0]
# The 120 degrees times the turn of the T pose are half a turn about (1, 1, 0): x and y change places, z turns round.
poses[1, :3] = np.pi / np.sqrt(2) * np.array([1, 1, 0])
trans = np.array([[1., 2, 3], [4, 5, 6]])
good = dict(poses=poses, trans=trans, mocap_framerate=np.array(120.), gender=np.array('neutral'),
            betas=np.zeros(16))
np.savez('stored_poses.npz', **good)
np.savez_compressed('deflated_poses.npz', **good)
np.savez('stageii.npz', root_orient=poses[:, :3], pose_body=poses[:, 3:66], pose_hand=poses[:, 66:156],
         trans=trans.astype(np.float32), mocap_frame_rate=np.int64(60), poses=np.zeros((2, 165)))
np.savez('shape.npz', betas=np.zeros(16))
def bad(name, **changes):
    items = {**good, **changes}
    np.savez(name, **{k: v for k, v in items.items() if v is not None})
wrong = poses.copy(); wrong[1, 7] = np.nan
bad('nan.npz', poses=wrong)
wrong = trans.copy(); wrong[0, 2] = -np.inf
bad('inf.npz', trans=wrong)
wrong = poses.copy(); wrong[1, 4] = 1e9
bad('spin.npz', poses=wrong)
bad('objects.npz', poses=np.array([None, 1], dtype=object))
bad('records.npz', poses=np.zeros(2, dtype=[('a', 'f4'), ('b', 'f4')]))
bad('text.npz', poses=np.array(['a', 'b']))
bad('big.npz', poses=poses.astype('>f8'))
bad('fortran.npz', poses=np.asfortranarray(poses + np.arange(156) * 1e-3))
bad('ordered.npz', poses=poses + np.arange(156) * 1e-3)
bad('smpl.npz', poses=poses[:, :72])
bad('narrow.npz', poses=poses[:, :60])
bad('flat.npz', poses=poses.ravel())
bad('short.npz', trans=trans[:1])
bad('empty.npz', poses=poses[:0], trans=trans[:0])
bad('nopath.npz', trans=None)
bad('norate.npz', mocap_framerate=None)
bad('rate.npz', mocap_framerate=np.array(0.))
bad('rates.npz', mocap_framerate=np.array([30., 60.]))
bad('noposes.npz', poses=None)
import zipfile
def raw(name, header, data=bytes(16), version=1, length=None, method=zipfile.ZIP_STORED):
    length = (len(header) if length is None else length).to_bytes(2 if version == 1 else 4, 'little')
    with zipfile.ZipFile(name, 'w', method) as archive:
        archive.writestr('poses.npy', b'\x93NUMPY' + bytes([version, 0]) + length + header.encode() + data)
start = "{'descr': '<f8', 'fortran_order': False, "
raw('version.npz', start + "'shape': (2,)}", version=3)
raw('long.npz', start + "'shape': (2,)}", length=9999)
raw('huge.npz', start + "'shape': (4000000000, 4000000000, 4000000000)}")
raw('more.npz', start + "'shape': (1000000000, 66)}")
raw('negative.npz', start + "'shape': (-2,)}")
raw('open.npz', start + "'shape': (2,")
raw('shapeless.npz', start + "}")
raw('key.npz', start + "'shape': (2,), 'x': 1}")
raw('method.npz', start + "'shape': (2,)}", method=zipfile.ZIP_BZIP2)
raw('second.npz', "{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}", version=2)
np.savez_compressed('types.npz', f4=np.array([[1.5, -2]], 'f4'), i1=np.array([-3], 'i1'), u2=np.array([65535], 'u2'),
                    i8=np.array(-5), u8=np.array([7], 'u8'), none=np.zeros((0, 3)))
)";

/// A folder with the archives of the script; false where there is no Python with numpy.
bool write_archives(const test::TemporaryFolder& folder)
{
    write_file(folder.file("write.py"), script);
    for (const std::string python : {"/usr/bin/python3", "python3"}) {
        if (test::run_command(python + " -c 'import numpy'").exit_code != 0) continue;
        const test::CommandResult result = test::run_command("cd " + folder.path() + " && " + python + " write.py");
        INFO(result.output);
        REQUIRE(result.exit_code == 0);
        return true;
    }
    std::cout << "Skipped: no python3 with numpy (Debian: python3-numpy)" << std::endl;
    return false;
}

Eigen::Matrix3d rows(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
    Eigen::Matrix3d matrix;
    matrix << a.transpose(), b.transpose(), c.transpose();
    return matrix;
}

}  // namespace

TEST_CASE("AMASS poses turn the T pose as they should, packed or not, SMPL-H or SMPL-X")
{
    const test::TemporaryFolder folder;
    if (!write_archives(folder)) return;
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
    for (const auto& [name, rate] :
         std::map<std::string, double>{{"stored_poses", 120}, {"deflated_poses", 120}, {"stageii", 60}}) {
        INFO(name);
        CHECK(is_amass(folder.file(name + ".npz")));
        const MotionClip clip = read_amass(folder.file(name + ".npz"));
        CHECK(clip.name == name);
        CHECK(clip.frame_rate == rate);
        CHECK_FALSE(clip.frame_rate_assumed);
        REQUIRE(clip.num_joints() == 52);
        REQUIRE(clip.num_frames() == 2);
        for (int j = 0; j < 52; ++j) {
            CHECK(clip.parents[j] < j);
            CHECK((clip.world_from_joint[0][j] - Eigen::Matrix3d::Identity()).norm() < 1e-12);
        }
        CHECK((clip.root_positions.row(0) - Eigen::RowVector3d(1, 3, -2)).norm() == 0.0);
        CHECK((clip.root_positions.row(1) - Eigen::RowVector3d(4, 6, -5)).norm() == 0.0);

        // File x -> y -> z -> x is, with our y the file's z and our z its -y, x -> -z, y -> x, z -> -y.
        const Eigen::Matrix3d root = rows(y, -z, -x);
        CHECK((clip.world_from_joint[1][0] - root).norm() < 1e-12);
        const auto joint = [&](const char* of) { return clip.world_from_joint[1][clip.find_joint(of)]; };
        CHECK((joint("left_hip") - root * rows(x, z, -y)).norm() < 1e-12);
        CHECK((joint("left_foot") - root * rows(x, z, -y)).norm() < 1e-12);
        CHECK((joint("right_knee") - root).norm() < 1e-12);
        CHECK((joint("right_shoulder") - root).norm() < 1e-12);
        CHECK((joint("right_elbow") - root * rows(z, y, -x)).norm() < 1e-12);
        CHECK((joint("right_wrist") - root * rows(z, y, -x)).norm() < 1e-12);
        // The lifted thigh points to the body's front, the folded right forearm as well.
        const Points posed = clip.joint_positions(1);
        const auto bone = [&](const char* from, const char* to) {
            return (posed.row(clip.find_joint(to)) - posed.row(clip.find_joint(from))).transpose().normalized().eval();
        };
        CHECK((bone("left_hip", "left_knee") - root * z).norm() < 1e-12);
        CHECK((bone("right_elbow", "right_wrist") - root * z).norm() < 1e-12);
    }
    CHECK_FALSE(is_amass(folder.file("shape.npz")));
}

TEST_CASE("the T pose of AMASS has its limbs along the axes")
{
    const test::TemporaryFolder folder;
    if (!write_archives(folder)) return;
    const MotionClip clip = read_amass(folder.file("stored_poses.npz"));
    const auto bone = [&](const std::string& from, const std::string& to) {
        const Eigen::RowVector3d end = to.empty() ? clip.zero_pose_tips.row(clip.find_joint(from))
                                                  : clip.zero_pose_positions.row(clip.find_joint(to));
        return (end - clip.zero_pose_positions.row(clip.find_joint(from))).normalized().eval();
    };
    for (const double sign : {1.0, -1.0}) {
        const std::string side = sign > 0 ? "left_" : "right_";
        const Eigen::RowVector3d out(sign, 0, 0), down(0, -1, 0), up(0, 1, 0);
        CHECK((bone(side + "shoulder", side + "elbow") - out).norm() < 1e-12);
        CHECK((bone(side + "elbow", side + "wrist") - out).norm() < 1e-12);
        CHECK((bone(side + "wrist", "") - out).norm() < 1e-12);
        CHECK((bone(side + "hip", side + "knee") - down).norm() < 1e-12);
        CHECK((bone(side + "knee", side + "ankle") - down).norm() < 1e-12);
        CHECK((bone("pelvis", "spine1") - up).norm() < 1e-12);
        CHECK(bone(side + "ankle", side + "foot").z() > 0.8);
        CHECK(bone("pelvis", side + "hip").x() * sign > 0.5);
    }
}

TEST_CASE("arrays in Fortran order are those in C order; SMPL's files have no fingers")
{
    const test::TemporaryFolder folder;
    if (!write_archives(folder)) return;
    const NpzFile fortran(folder.file("fortran.npz")), ordered(folder.file("ordered.npz"));
    CHECK(fortran.read("poses").values == ordered.read("poses").values);
    CHECK(fortran.read("poses").shape == std::vector<std::int64_t>{2, 156});
    CHECK(read_amass(folder.file("smpl.npz")).num_joints() == 22);
}

TEST_CASE("numpy's number types are read as numbers")
{
    const test::TemporaryFolder folder;
    if (!write_archives(folder)) return;
    const NpzFile file(folder.file("types.npz"));
    CHECK(file.read("f4").shape == std::vector<std::int64_t>{1, 2});
    CHECK(file.read("f4").values == std::vector<double>{1.5, -2});
    CHECK(file.read("i1").values == std::vector<double>{-3});
    CHECK(file.read("u2").values == std::vector<double>{65535});
    CHECK(file.read("i8").shape.empty());
    CHECK(file.read("i8").values == std::vector<double>{-5});
    CHECK(file.read("u8").values == std::vector<double>{7});
    CHECK(file.read("none").shape == std::vector<std::int64_t>{0, 3});
    CHECK(file.read("none").values.empty());
}

TEST_CASE("malformed AMASS archives are refused with file, array and value")
{
    const test::TemporaryFolder folder;
    if (!write_archives(folder)) return;
    const std::map<std::string, std::string> messages = {
        {"nan", "\"poses\": value 163 is nan"},
        {"inf", "\"trans\": value 2 is -inf"},
        {"spin", "\"left_hip\" turns by 1000000000"},
        {"objects", "\"poses\": is an array of pickled Python objects"},
        {"records", "\"poses\": holds records"},
        {"text", "\"poses\": has the type '<U1'"},
        {"big", "\"poses\": has the type '>f8'"},
        {"narrow", "\"poses\" has the shape (2, 60), (frames, 72 or 156 or 165) is needed"},
        {"flat", "\"poses\" has the shape (312)"},
        {"short", "\"trans\" has the shape (1, 3), (2, 3) is needed"},
        {"empty", "\"poses\" has 0 frames"},
        {"nopath", "has no array \"trans\""},
        {"norate", "has no array \"mocap_framerate\""},
        {"rate", "\"mocap_framerate\" is 0"},
        {"rates", "\"mocap_framerate\" has 2 values instead of 1"},
        {"noposes", "has no array \"poses\""},
        {"version", "is a .npy array of version 3"},
        {"long", "its array header has 9999 bytes, 71 are there"},
        {"huge", "its shape is too large"},
        {"more", "has 16 bytes of numbers, its shape needs 528000000000"},
        {"negative", "its array header breaks off or is malformed at character 51"},
        {"open", "its array header breaks off or is malformed"},
        {"shapeless", "its array header breaks off or is malformed"},
        {"key", "its array header breaks off or is malformed"},
        {"method", "is packed by zip method 12, not stored or deflated"},
        {"second", "\"poses\" has the shape (2), (frames"}};
    for (const auto& [name, message] : messages) {
        INFO(name);
        const std::string path = folder.file(name + ".npz");
        CHECK_THROWS_AS(read_amass(path), InputError);
        CHECK_THROWS_WITH(read_amass(path), Contains(path) && Contains(message));
    }
    write_file(folder.file("no.npz"), "no archive");
    CHECK_THROWS_WITH(read_amass(folder.file("no.npz")), Contains("no.npz: is no zip archive or is truncated"));
    CHECK_THROWS_AS(read_amass(folder.file("missing.npz")), InputError);
}

TEST_CASE("a cut or damaged archive is refused or read, never trusted")
{
    const test::TemporaryFolder folder;
    if (!write_archives(folder)) return;
    const std::string path = folder.file("damaged.npz");
    for (const std::string name : {"stored_poses.npz", "deflated_poses.npz"}) {
        const std::string good = read_file(folder.file(name));
        for (std::size_t size = 0; size < good.size(); size += 1 + good.size() / 40) {
            write_file(path, good.substr(0, size));
            CHECK_THROWS_AS(read_amass(path), InputError);
        }
        // A flipped byte may hit a date or a comment, else a check.
        int num_refused = 0, num_read = 0;
        for (std::size_t at = 0; at < good.size(); at += 1 + good.size() / 500) {
            std::string bytes = good;
            bytes[at] = static_cast<char>(bytes[at] ^ 0xff);
            write_file(path, bytes);
            try {
                read_amass(path);
                ++num_read;
            } catch (const InputError&) {
                ++num_refused;
            }
        }
        CHECK(num_refused > 100);
        CHECK(num_read > 0);
    }
}
