// SPDX-License-Identifier: Apache-2.0
// Captures as others write them, whole and broken, and as we do.
#include "tube_capture.h"

#include "ndg/capture/import_capture.h"
#include "ndg/capture/step_poses.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/geometry/rotation.h"
#include "ndg/io/mesh.h"

#include <fmt/ranges.h>
#include <catch2/catch.hpp>

#include <cmath>
#include <filesystem>
#include <limits>

using namespace ndg;

namespace {

struct Fixture {
    Template tube = test::tube_template(5, 6);
    Avatar avatar = test::tube_avatar(tube);
    CaptureSurface surface{avatar.skin_vertices.rows(), avatar.whole_skin_triangles};
    CaptureSequence truth = test::skinned_tube(avatar, 12);
    test::TemporaryFolder folder;
    std::vector<std::string> said;

    std::vector<CaptureSequence> import(const std::string& path, const CaptureImportOptions& options = {})
    {
        said.clear();
        return import_sequences(path, surface, options, [this](const std::string& line) { said.push_back(line); });
    }
    std::string told() const { return fmt::format("{}", fmt::join(said, "\n")); }
    std::string failure(const std::string& path, const CaptureImportOptions& options = {})
    {
        try {
            import(path, options);
        } catch (const InputError& error) {
            return error.what();
        }
        return "";
    }
    /// One OBJ a frame.
    std::string write_folder(const std::string& name, int without = -1)
    {
        const std::string path = folder.file(name);
        std::filesystem::create_directories(path);
        for (int f = 0; f < truth.num_frames(); ++f) {
            if (f == without) continue;
            write_mesh(fmt::format("{}/scan.{:04}.obj", path, f), truth.vertices[static_cast<std::size_t>(f)],
                       surface.triangles);
        }
        return path;
    }
    /// The frames as text that Python reads.
    void python(const std::string& code)
    {
        std::string text;
        for (const Points& vertices : truth.vertices) {
            for (Eigen::Index i = 0; i < vertices.size(); ++i) text += fmt::format("{:.17g} ", vertices.data()[i]);
            text += "\n";
        }
        write_file(folder.file("frames.txt"), text);
        write_file(folder.file("write.py"),
                   fmt::format("import numpy as np, os\nos.chdir('{}')\nx = np.loadtxt('frames.txt').reshape({}, {}, "
                               "3)\n{}\n",
                               folder.path(), truth.num_frames(), surface.num_vertices, code));
        const test::CommandResult result = test::run_command("/usr/bin/python3 " + folder.file("write.py"));
        INFO(result.output);
        REQUIRE(result.exit_code == 0);
    }
    double error(const CaptureSequence& found) const
    {
        double worst = 0;
        for (std::size_t f = 0; f < found.vertices.size(); ++f) {
            const auto number = static_cast<std::size_t>(found.frame_numbers[f]);
            worst = std::max(worst, (found.vertices[f] - truth.vertices[number]).cwiseAbs().maxCoeff());
        }
        return worst;
    }
};

}  // namespace

TEST_CASE_METHOD(Fixture, "Folders of meshes, NumPy's arrays and HDF5 of either order hold the same frames")
{
    const auto from_folder = import(write_folder("walk"));
    REQUIRE(from_folder.size() == 1);
    CHECK(from_folder[0].name == "walk");
    CHECK(from_folder[0].num_frames() == 12);
    CHECK(error(from_folder[0]) < 1e-6);

    python(
        "np.save('hop.npy', x)\nnp.savez('two.npz', a=x, b=x[:5].astype(np.float32), note=np.zeros(3))\n"
        "import h5py\nf = h5py.File('dfaust.hdf5', 'w')\nf['sids/50002/jacks'] = x.transpose(1, 2, 0)\n"
        "f['running'] = x\nf.close()");
    const auto from_npy = import(folder.file("hop.npy"));
    CHECK(from_npy[0].name == "hop");
    CHECK(error(from_npy[0]) < 1e-15);
    const auto from_npz = import(folder.file("two.npz"));
    REQUIRE(from_npz.size() == 2);
    CHECK(from_npz[1].name == "b");
    CHECK(from_npz[1].num_frames() == 5);
    CHECK(error(from_npz[0]) + error(from_npz[1]) < 1e-6);
    const auto from_h5 = import(folder.file("dfaust.hdf5"));
    REQUIRE(from_h5.size() == 2);
    CHECK(told().find("axes swapped") != std::string::npos);
    CHECK(from_h5[0].name == "running");
    CHECK(from_h5[1].name == "50002_jacks");
    CHECK(error(from_h5[0]) + error(from_h5[1]) < 1e-15);
    CaptureImportOptions millimetres;
    millimetres.metres_per_unit = 1e-3;
    CHECK((import(folder.file("hop.npy"), millimetres)[0].vertices[3] - 1e-3 * truth.vertices[3]).norm() < 1e-12);
}

TEST_CASE_METHOD(Fixture, "Missing frames are gaps, told, and refused where there are many")
{
    const auto found = import(write_folder("walk", 4));
    REQUIRE(found[0].num_frames() == 11);
    CHECK(found[0].num_recorded() == 12);
    CHECK(found[0].frame_numbers[4] == 5);
    CHECK(error(found[0]) < 1e-6);
    CHECK(told().find("1 of them missing, first 4") != std::string::npos);
    CaptureImportOptions strict;
    strict.most_missing = 0.05;
    CHECK(failure(folder.file("walk"), strict).find("lacks 1 of 12 frames") != std::string::npos);
}

TEST_CASE_METHOD(Fixture, "A frame with a vertex that is no number is left out and told")
{
    python("x[7, 3, 1] = np.nan\nnp.save('nan.npy', x)");
    const auto found = import(folder.file("nan.npy"));
    CHECK(found[0].num_frames() == 11);
    CHECK(told().find("frame 7 is left out as missing: vertex 3 is no number") != std::string::npos);
}

TEST_CASE_METHOD(Fixture, "Another topology is refused, naming the file and what differs")
{
    const std::string path = write_folder("walk");
    Triangles turned = surface.triangles;
    std::swap(turned(2, 0), turned(2, 1));
    write_mesh(path + "/scan.0005.obj", truth.vertices[5], turned);
    CHECK(failure(path).find("scan.0005.obj: triangle 2 is") != std::string::npos);
    write_mesh(path + "/scan.0005.obj", truth.vertices[5].topRows(surface.num_vertices), surface.triangles.topRows(4));
    CHECK(failure(path).find("4 triangles, the body's skin has") != std::string::npos);
    python("np.save('few.npy', x[:, :-1])");
    CHECK(failure(folder.file("few.npy")).find("expected frames x") != std::string::npos);
    write_mesh(path + "/other.5.obj", truth.vertices[5], surface.triangles);
    CHECK(failure(path).find("are both frame 5") != std::string::npos);
    python(
        "import h5py\nfor name, face in (('other', 1), ('far', 1e9), ('none', np.nan)):\n"
        "    f = h5py.File(name + '.h5', 'w')\n    f['jacks'] = x\n    f['faces'] = np.full((" +
        std::to_string(surface.triangles.rows()) + ", 3), float(face))\n    f.close()");
    CHECK(failure(folder.file("other.h5")).find("/faces: triangle 0 is 1 1 1") != std::string::npos);
    CHECK(failure(folder.file("far.h5")).find("/faces has 1000000000") != std::string::npos);
    CHECK(failure(folder.file("none.h5")).find("/faces has nan at face 0") != std::string::npos);
    CHECK(failure(folder.file("write.py")).find("expected a folder") != std::string::npos);
    std::filesystem::create_directories(folder.file("empty"));
    CHECK(failure(folder.file("empty")).find("no .obj or .ply") != std::string::npos);
}

TEST_CASE_METHOD(Fixture, "Half the frame rate is seen beside poses of the true one")
{
    PoseSet poses;
    poses.clip_names = {"other", "hop"};
    poses.clip_frame_rates = {60, 60};
    for (int f = 0; f < truth.num_frames(); ++f) {
        poses.poses.push_back(truth.poses[static_cast<std::size_t>(f)]);
        poses.clip_idx.push_back(1);
        poses.frame_idx.push_back(f);
    }
    CaptureSequence sequence = truth;
    sequence.name = "hop";
    sequence.poses.clear();
    attach_poses(sequence, poses, "poses.h5");
    REQUIRE(sequence.poses.size() == 12);
    CHECK(rotation_angle(sequence.poses[7].parent_from_joint[0], truth.poses[7].parent_from_joint[0]) < 1e-9);

    sequence.frame_rate_hertz = 30;
    REQUIRE_THROWS_WITH(attach_poses(sequence, poses, "poses.h5"),
                        Catch::Contains("lasts 0.367 s at 30 Hz, its poses last 0.183 s"));
    CaptureSequence every_second;  // truly 30 Hz
    every_second.name = "hop";
    every_second.frame_rate_hertz = 30;
    for (int f = 0; f < 6; ++f) {
        every_second.frame_numbers.push_back(f);
        every_second.vertices.push_back(truth.vertices[static_cast<std::size_t>(2 * f)]);
    }
    attach_poses(every_second, poses, "poses.h5");
    CHECK(every_second.poses[4].root_translation == truth.poses[8].root_translation);
    sequence.name = "unknown";
    REQUIRE_THROWS_WITH(attach_poses(sequence, poses, "poses.h5"),
                        Catch::StartsWith("poses.h5: there is no motion \"unknown\" among its 2 clips"));
}

TEST_CASE_METHOD(Fixture, "Captures come back from their files, and broken ones are refused")
{
    Capture capture = test::tube_capture(avatar, 6);
    capture.sequences.push_back(capture.sequences[0]);
    capture.sequences[1].name = "again";
    capture.sequences[1].frame_rate_hertz = 30;
    capture.sequences[1].frame_numbers = {0, 1, 2, 5, 6, 9};
    capture.true_stiffness.assign(static_cast<std::size_t>(surface.num_vertices), 1.5);
    const std::string path = folder.file("capture.h5");
    write_capture(path, capture, {});
    const Capture found = read_capture(path);
    CHECK(found.subject == "tube");
    CHECK(found.triangles == capture.triangles);
    CHECK(found.sequence("again").frame_numbers == capture.sequences[1].frame_numbers);
    CHECK(found.sequence("again").frame_rate_hertz == 30);
    CHECK(found.true_stiffness == capture.true_stiffness);
    CHECK((found.sequences[1].vertices[4] - capture.sequences[1].vertices[4]).cwiseAbs().maxCoeff() < 1e-6);
    CHECK(found.sequences[0].poses[3].root_translation == capture.sequences[0].poses[3].root_translation);
    REQUIRE_THROWS_AS(found.sequence("none"), InputError);
    capture.sequences[0].vertices[2](1, 1) = std::numeric_limits<double>::quiet_NaN();
    REQUIRE_THROWS_AS(write_capture(path, capture, {}), InputError);
    capture.sequences[0].vertices[2](1, 1) = 0;
    capture.sequences[0].poses.clear();
    REQUIRE_THROWS_AS(write_capture(path, capture, {}), InputError);
}

TEST_CASE("Poses at the step rate meet the frames' and have no kinks between them")
{
    CaptureSequence sequence;
    sequence.name = "sine";
    const auto height = [](double seconds) { return 0.1 * std::sin(2 * M_PI * 3 * seconds); };
    for (int f = 0; f <= 60; ++f) {
        if (f == 20) continue;
        Pose pose = test::tube_pose(0.4 * std::sin(2 * M_PI * 2 * f / 60.0));
        pose.root_translation.y() = height(f / 60.0);
        sequence.frame_numbers.push_back(f + 3);
        sequence.poses.push_back(pose);
        sequence.vertices.emplace_back(Points::Zero(1, 3));
    }
    const std::vector<Pose> poses = step_poses(sequence, 240);
    REQUIRE(poses.size() == 241);
    CHECK(poses[4 * 30].root_translation == sequence.poses[29].root_translation);
    double cubic = 0, linear = 0;
    for (int s = 120; s < 232; ++s) {
        const double share = (s % 4) / 4.0, time = s / 240.0, before = (s - s % 4) / 240.0;
        cubic = std::max(cubic, std::abs(poses[static_cast<std::size_t>(s)].root_translation.y() - height(time)));
        linear =
            std::max(linear, std::abs((1 - share) * height(before) + share * height(before + 1 / 60.0) - height(time)));
        const auto& rotation = poses[static_cast<std::size_t>(s)].parent_from_joint;
        for (const Eigen::Matrix3d& r : rotation)
            CHECK((r.transpose() * r - Eigen::Matrix3d::Identity()).norm() < 1e-12);
    }
    CHECK(cubic < 0.2 * linear);
    CHECK(linear > 1e-3);
    sequence.frame_rate_hertz = 50;
    REQUIRE_THROWS_AS(step_poses(sequence, 120), InputError);
}
