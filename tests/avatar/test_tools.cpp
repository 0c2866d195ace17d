// SPDX-License-Identifier: Apache-2.0
// The tool make-avatar, and the page that says how to bring one's own body.
#include "support/h5_damage.h"
#include "tube_body.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

using namespace ndg;

namespace {

std::string read_text(const std::string& path)
{
    std::ifstream file(path);
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

void write_text(const std::string& path, const std::string& text)
{
    std::ofstream(path) << text;
}

}  // namespace

TEST_CASE("make-avatar makes an avatar of a person, and says what is wrong in one line")
{
    const test::TubeBody scene(13, 8);
    const test::TemporaryFolder folder;
    const std::string body = folder.file("body.h5"), output = folder.file("avatar.h5"),
                      field = folder.file("field.json");
    write_statistical_body(body, scene.body, test::example_provenance());
    const std::string command = test::tool_path("make-avatar") + " --control-points 3 --body " + body;
    const auto run = [&](const std::string& arguments) { return test::run_command(command + " " + arguments); };

    write_text(field, R"({"thickness": [0.01, 0.02, 0.03]})");
    const std::string picture = folder.file("avatar.png");
    const auto done = run("--person tube_4 --thickness-field " + field + " --picture-height 300 --picture " + picture +
                          " --output " + output);
    INFO(done.output);
    REQUIRE(done.exit_code == 0);
    CHECK(done.output.find("tube_4") != std::string::npos);
    CHECK(std::filesystem::file_size(picture) > 1000);
    const Avatar avatar = read_avatar(output);
    CHECK(avatar.name == "tube_4");
    CHECK(avatar.control_vertices.size() == 3);
    CHECK((avatar.skin_vertices - scene.bodies.bodies[4].skin_vertices).cwiseAbs().maxCoeff() < 1e-6);
    // Written again, it is the same, byte by byte.
    REQUIRE(run("--person tube_4 --thickness-field " + field + " --output " + folder.file("again.h5")).exit_code == 0);
    const Avatar again = read_avatar(folder.file("again.h5"));
    CHECK(again.rest == avatar.rest);
    CHECK(again.pose_directions == avatar.pose_directions);

    const auto check_refused = [&](const std::string& arguments, const std::string& word) {
        const auto refused = run(arguments + " --output " + folder.file("none.h5"));
        INFO(arguments << ": " << refused.output);
        CHECK(refused.exit_code == 2);
        CHECK(refused.output.find(word) != std::string::npos);
        CHECK(!std::filesystem::exists(folder.file("none.h5")));
    };
    check_refused("--person nobody", "nobody");
    check_refused("--person tube_1 --shape 1", "--shape");
    check_refused("--shape 1,x", "\"x\" is no number");
    check_refused("--shape 1,2,3,4", "4 shape parameters");
    check_refused("--extremities tail", "tail");
    check_refused("--thickness -1", "thickness");
    write_text(field, R"({"thickness": [0.01, 0.02]})");
    check_refused("--thickness-field " + field, "thickness");
    write_text(field, R"({"thickness": [0.01, 0.02, -0.03]})");
    check_refused("--thickness-field " + field, "control point 2");
}

TEST_CASE("The script of docs/statistical-body.md writes a body that is read back as it was")
{
    const test::TubeBody scene(13, 8);
    const test::TemporaryFolder folder;
    const std::string ours = folder.file("ours.h5"), mine = folder.file("mine.h5");
    write_statistical_body(ours, scene.body, test::example_provenance());
    const std::string page = read_text(NDG_TEST_SOURCE "/docs/statistical-body.md");
    const std::size_t begin = page.find("```python\n") + 10, end = page.find("```", begin);
    std::string script = page.substr(begin, end - begin);
    REQUIRE(script.find("\"mine.h5\"") != std::string::npos);
    script.replace(script.find("\"mine.h5\""), 9, "'" + mine + "'");
    test::run_python("import h5py, numpy as np\ng = h5py.File('" + ours + "')\n" +
                     R"(v, t = g['/skin/vertices'][...], g['/skin/triangles'][...]
w, j = g['/skin/weights'][...], g['/joints/regressor'][...]
parents, names = g['/skeleton/parents'][...], [n.decode() for n in g['/skeleton/joint_names'][...]]
s = np.moveaxis(g['/shape/directions'][...].reshape(-1, len(v), 3), 0, 2)
p = np.random.default_rng(1).normal(size=(len(v), 3, 9 * 59))
)" + script + "\nassert f.__class__ is h5py.File\nnp.save('" +
                     folder.file("p.npy") + "', p)\n");
    const StatisticalBody body = read_statistical_body(mine);
    CHECK(body.name == "mine");
    CHECK(body.vertices == scene.body.vertices);
    CHECK(body.shape_directions == scene.body.shape_directions);
    CHECK(body.pose_joints.size() == 59);
    CHECK(body.pose_directions.rows() == 9 * 59);
    CHECK(RowMatrix(body.weights) == RowMatrix(scene.body.weights));
    CHECK(body.soft_triangles.empty());
    test::run_python(
        "import h5py, numpy as np\np = np.load('" + folder.file("p.npy") + "')\nd = h5py.File('" + mine +
        "')['/pose/directions'][...]\nassert np.allclose(d[9 * 2 + 3 * 1 + 2, 3 * 7 + 1], p[7, 1, 9 * 2 + 5])");

    // Nothing says where its soft tissue ends: joints do.
    const std::string command =
        test::tool_path("make-avatar") + " --control-points 2 --body " + mine + " --output " + folder.file("avatar.h5");
    CHECK(test::run_command(command).output.find("soft_triangles") != std::string::npos);
    const auto done = test::run_command(command + " --extremities left_forearm_twist,left_forearm");
    INFO(done.output);
    CHECK(done.exit_code == 0);
    const Avatar avatar = read_avatar(folder.file("avatar.h5"));
    CHECK(avatar.licences.find("model: its licence and authors") != std::string::npos);
}
