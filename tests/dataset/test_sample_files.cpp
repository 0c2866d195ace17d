// SPDX-License-Identifier: Apache-2.0
// Splits and samples: what is written is read back, by us and by h5py; wrong content is refused.
#include "ndg/core/error.h"
#include "ndg/core/random.h"
#include "ndg/dataset/anatomy_file.h"
#include "ndg/dataset/deformation_file.h"
#include "ndg/dataset/gradient_file.h"
#include "ndg/dataset/splits.h"
#include "support/h5_damage.h"
#include "support/support.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <numeric>

using namespace ndg;
using namespace ndg::test;
using Catch::Contains;

namespace {

Splits example_splits()
{
    Splits splits;
    splits.bodies = {{"train", {0, 3}}, {"validation", {1}}, {"test", {2}}};
    splits.poses = {{"train", {4, 0, 1}}, {"validation", {2}}, {"test", {3}}};
    splits.pairs = {{"train", {{0, 4}, {3, 1}, {0, 0}}}, {"validation", {{1, 2}}}, {"test", {}}};
    return splits;
}

DeformationSet example_deformations()
{
    DeformationSet set;
    set.method = "FEM";
    Random random(32, "deformations");
    for (int i = 0; i < 3; ++i) {
        Points points(4, 3);
        for (Eigen::Index k = 0; k < points.size(); ++k) points.data()[k] = random.normal();
        set.add({i, 2 - i}, split_names[i], points);
    }
    set.statistics = {{"seconds", {0.5, 0.25, 0.125}}, {"converged", {1, 1, 0}}};
    return set;
}

/// 0, 1, 2, ... from `first` on.
std::vector<float> counting(std::size_t count, float first)
{
    std::vector<float> values(count);
    std::iota(values.begin(), values.end(), first);
    return values;
}

}  // namespace

TEST_CASE("Splits come back, empty ones too")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("splits.h5");
    const Splits splits = example_splits();
    write_splits(path, splits, example_provenance());
    const Splits back = read_splits(path, 4, 5);
    CHECK(back.bodies == splits.bodies);
    CHECK(back.poses == splits.poses);
    for (const std::string& split : split_names) {
        REQUIRE(back.pairs.at(split).size() == splits.pairs.at(split).size());
        for (std::size_t i = 0; i < back.pairs.at(split).size(); ++i) {
            CHECK(back.pairs.at(split)[i].body_idx == splits.pairs.at(split)[i].body_idx);
            CHECK(back.pairs.at(split)[i].pose_idx == splits.pairs.at(split)[i].pose_idx);
        }
    }
    CHECK_THROWS_AS(read_splits(path, 3, 5), InputError);
    CHECK_THROWS_AS(read_splits(path, 4, 4), InputError);
    check_by_h5py(path, "ndg-splits",
                  "{'/splits/train/bodies': (2,), '/splits/train/poses': (3,), '/splits/train/pairs': (3, 2),"
                  " '/splits/validation/bodies': (1,), '/splits/validation/poses': (1,),"
                  " '/splits/validation/pairs': (1, 2), '/splits/test/bodies': (1,), '/splits/test/poses': (1,),"
                  " '/splits/test/pairs': (0, 2)}");

    Splits crossing = splits;
    crossing.bodies["test"] = {0};
    CHECK_THROWS_AS(write_splits(folder.file("crossing.h5"), crossing, example_provenance()), InputError);
}

TEST_CASE("Deformations come back with their figures")
{
    const TemporaryFolder folder;
    const std::string path = folder.file("deformations.h5");
    const DeformationSet set = example_deformations();
    write_deformations(path, set, example_provenance());
    const DeformationSet back = open_deformations(path, 4);
    REQUIRE(back.size() == 3);
    CHECK(back.method == "FEM");
    CHECK(back.pair_splits == set.pair_splits);
    CHECK(back.statistics == set.statistics);
    for (int i = 0; i < 3; ++i) {
        CHECK(back.pairs[i].body_idx == i);
        CHECK(back.pairs[i].pose_idx == 2 - i);
        CHECK(back.coordinates(i) == set.vertices[i]);
        CHECK(back.points(i) == set.points(i));
    }
    CHECK_THROWS_AS(back.points(3), Error);
    CHECK_THROWS_AS(open_deformations(path, 5), InputError);
    check_by_h5py(path, "ndg-deformations",
                  "{'/deformations/pairs': (3, 2), '/deformations/splits': (3,), '/deformations/vertices': (3, 4, 3),"
                  " '/statistics/seconds': (3,), '/statistics/converged': (3,)}");

    DeformationSet uneven = set;
    CHECK_THROWS_AS(uneven.add({0, 0}, "train", Points::Zero(5, 3)), Error);
    DeformationSet empty;
    empty.method = "LBS";
    empty.num_volume_vertices = 4;
    write_deformations(folder.file("empty.h5"), empty, example_provenance());
    CHECK(open_deformations(folder.file("empty.h5"), 4).size() == 0);
}

TEST_CASE("Damaged splits are refused")
{
    const TemporaryFolder folder;
    write_splits(folder.file("splits.h5"), example_splits(), example_provenance());
    const std::vector<Damage> damages = {
        {"f['/splits/test/bodies'][0] = 3", {"/splits/test/bodies", "3", "train"}},
        {"f['/splits/validation/poses'][0] = 4", {"/splits/validation/poses", "4", "train"}},
        {"f['/splits/train/poses'][0] = 1", {"/splits/train/poses", "1"}},
        {"f['/splits/train/poses'][0] = 5", {"/splits/train/poses", "5"}},
        {"f['/splits/validation/pairs'][0, 0] = 0", {"/splits/validation/pairs", "body 0 in pose 2"}},
        {"f['/splits/train/pairs'][0, 1] = 0", {"/splits/train/pairs", "twice"}},
        {"f['/splits/train/pairs'][0, 1] = -1", {"/splits/train/pairs", "-1"}},
        {"put('/splits/train/pairs', f['/splits/train/pairs'][:, :1])", {"/splits/train/pairs"}},
        {"del f['/splits/test']", {"/splits/test"}},
    };
    check_damages(folder.file("splits.h5"), damages, [](const std::string& copy) { read_splits(copy, 4, 5); });
}

TEST_CASE("Damaged deformations are refused")
{
    const TemporaryFolder folder;
    write_deformations(folder.file("deformations.h5"), example_deformations(), example_provenance());
    const std::vector<Damage> damages = {
        {"f['/deformations/vertices'][1, 2, 0] = np.inf", {"/deformations/vertices", "inf"}},
        {"put('/deformations/vertices', f['/deformations/vertices'][:2])", {"/deformations/vertices", "2 x 4 x 3"}},
        {"put('/deformations/vertices', f['/deformations/vertices'][:, :3])", {"/deformations/vertices", "3 vertices"}},
        {"put('/deformations/splits', ['train', 'test', 'tset'])", {"/deformations/splits[2]", "tset"}},
        {"f['/deformations/pairs'][0, 0] = -1", {"/deformations/pairs", "-1"}},
        {"f['/statistics/seconds'][0] = np.nan", {"/statistics/seconds", "nan"}},
        {"put('/statistics/seconds', [1.0, 2.0])", {"/statistics/seconds"}},
        {"del f.attrs['method']", {"method"}},
    };
    check_damages(folder.file("deformations.h5"), damages, [](const std::string& copy) {
        const DeformationSet set = open_deformations(copy, 4);
        for (int i = 0; i < set.size(); ++i) set.coordinates(i);
    });
}

TEST_CASE("Gradients and anatomy go sample by sample, in any order")
{
    const TemporaryFolder folder;
    const SampleIndex index = {"NDG", {}, {{0, 1}, {4, 0}}, {"test", "train"}};
    {
        GradientWriter writer(folder.file("gradients.h5"), index, 2, example_provenance());
        writer.write(1, counting(18, 50));
        CHECK_THROWS_AS(writer.commit(), Error);
        CHECK_THROWS_AS(writer.write(0, counting(9, 0)), Error);
        CHECK_THROWS_AS(writer.write(2, counting(18, 0)), Error);
        writer.write(0, counting(18, 0));
        writer.commit();
    }
    const GradientReader gradients(folder.file("gradients.h5"), 2);
    CHECK(gradients.num_prisms() == 2);
    CHECK(gradients.index().method == "NDG");
    CHECK(gradients.index().pairs == index.pairs);
    CHECK(gradients.index().pair_splits == index.pair_splits);
    CHECK(gradients.read(1) == counting(18, 50));
    CHECK(gradients.read(0) == counting(18, 0));
    CHECK_THROWS_WITH(GradientReader(folder.file("gradients.h5"), 3), Contains("2 prisms a sample"));
    check_by_h5py(folder.file("gradients.h5"), "ndg-gradients",
                  "{'/gradients/pairs': (2, 2), '/gradients/splits': (2,), '/gradients/F': (2, 2, 9)}");

    Triangles triangles(1, 3);
    triangles << 0, 2, 1;
    {
        AnatomyWriter writer(folder.file("anatomy.h5"), index, triangles, 3, example_provenance());
        writer.write(0, Points::Constant(3, 3, 0.25));
        writer.write(1, Points::Identity(3, 3));
        writer.commit();
    }
    const AnatomyReader anatomy(folder.file("anatomy.h5"), 3);
    CHECK(anatomy.triangles() == triangles);
    CHECK(anatomy.read(1) == std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1});
    check_by_h5py(folder.file("anatomy.h5"), "ndg-anatomy",
                  "{'/anatomy/pairs': (2, 2), '/anatomy/splits': (2,), '/anatomy/triangles': (1, 3),"
                  " '/anatomy/vertices': (2, 3, 3)}");
    {
        const GradientWriter unfinished(folder.file("unfinished.h5"), index, 2, example_provenance());
    }
    CHECK_FALSE(std::filesystem::exists(folder.file("unfinished.h5")));
    CHECK_THROWS_AS(GradientWriter(folder.file("odd.h5"), {"NDG", {}, {{0, 1}}, {"tset"}}, 2, {}), InputError);
}

TEST_CASE("A sample may be a sequence of poses")
{
    const TemporaryFolder folder;
    const SampleIndex index = {"dynamic", {}, {{0, 4}, {1, 2, 3}, {0, 9}}, {"train", "train", "test"}};
    {
        GradientWriter writer(folder.file("sequences.h5"), index, 1, example_provenance());
        for (int i : {2, 0}) writer.write(i, counting(9, 100.0F * i));
        CHECK_THROWS_AS(writer.write(1, counting(9, 0)), Error);
        writer.write(1, counting(27, 300));
        writer.commit();
    }
    const GradientReader reader(folder.file("sequences.h5"));
    CHECK(reader.index().pairs == index.pairs);
    CHECK(reader.index().num_slices() == 5);
    CHECK(reader.read(0) == counting(9, 0));
    CHECK(reader.read(1) == counting(27, 300));
    CHECK(reader.read(2) == counting(9, 200));
    check_by_h5py(folder.file("sequences.h5"), "ndg-gradients",
                  "{'/gradients/pairs': (3, 2), '/gradients/frames': (3,), '/gradients/splits': (3,),"
                  " '/gradients/F': (5, 1, 9)}");
    check_damages(folder.file("sequences.h5"),
                  {{"f['/gradients/frames'][1] = 0", {"/gradients/frames", "0"}},
                   {"f['/gradients/frames'][1] = 2", {"/gradients/F", "5 x 1 x 9", "4 samples"}}},
                  [](const std::string& copy) { GradientReader{copy}; });

    CHECK(describe(index.pairs[1]) == "body 1 in poses 2 to 4");
    CHECK_NOTHROW(require_pair(index.pairs[0], 1, 5));
    CHECK_THROWS_WITH(require_pair(index.pairs[1], 9, 9), Contains("sequence"));
    CHECK_THROWS_AS(require_pair(index.pairs[0], 1, 4), InputError);
    CHECK_THROWS_AS(require_pair(index.pairs[0], 0, 5), InputError);

    // A sequence belongs to a split with all of its poses.
    Splits splits = example_splits();
    splits.pairs["train"] = {{0, 0, 2}, {0, 0}};
    write_splits(folder.file("splits.h5"), splits, example_provenance());
    CHECK(read_splits(folder.file("splits.h5")).pairs == splits.pairs);
    splits.pairs["train"] = {{0, 0, 3}};
    CHECK_THROWS_AS(write_splits(folder.file("splits.h5"), splits, example_provenance()), InputError);
}
