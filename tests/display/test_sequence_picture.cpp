// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/sequence_picture.h"

#include "ndg/core/error.h"

#include <catch2/catch.hpp>

#include <algorithm>
#include <utility>

using namespace ndg;

namespace {

/// A red cube of a metre, and a blue one that comes from the side and stops a metre beside it.
MeshSequence two_cubes()
{
    const Points corners =
        (Points(8, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1).finished();
    const Triangles triangles = (Triangles(12, 3) << 0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2,
                                 7, 6, 1, 2, 6, 1, 6, 5, 0, 4, 7, 0, 7, 3)
                                    .finished();
    MeshSequence sequence;
    for (const auto& [name, colour] : {std::pair("body", Eigen::Vector3f(0.9f, 0.1f, 0.1f)),
                                       std::pair("other", Eigen::Vector3f(0.1f, 0.1f, 0.9f))}) {
        ExportedMesh mesh;
        mesh.name = name;
        mesh.triangles = triangles;
        mesh.colour = colour;
        sequence.meshes.push_back(mesh);
    }
    sequence.num_frames = 11;
    sequence.frame_rate = 10;
    sequence.frame = [corners](int frame) {
        std::vector<MeshFrame> meshes(2);
        meshes[0].vertices = corners;
        meshes[1].vertices = 0.1 * corners;
        meshes[1].vertices.col(0).array() += 9.95 - frame;  // ends before the body's side
        meshes[1].vertices.col(1).array() += 0.5;
        meshes[1].vertices.col(2).array() += 1.2;
        return meshes;
    };
    return sequence;
}

/// Pixels of a part of a picture that are more red, or more blue, than anything else.
int count_pixels(const Image& image, int channel, int begin, int end)
{
    int count = 0;
    for (int y = 0; y < image.height; ++y) {
        for (int x = begin; x < end; ++x) {
            const Pixel& pixel = image.at(x, y);
            const int other = std::max(pixel[(channel + 1) % 3], pixel[(channel + 2) % 3]);
            count += pixel[channel] > other + 60;
        }
    }
    return count;
}

}  // namespace

TEST_CASE("Frames of a sequence stand side by side: the body in all of them, what comes near where it is near")
{
    SequencePictureOptions options;
    options.frames = 3;
    options.height = 120;
    options.view = View::front;
    const Image image = sequence_picture(two_cubes(), options);
    const int third = image.width / 3;
    for (int k = 0; k < 3; ++k) CHECK(count_pixels(image, 0, k * third, (k + 1) * third) > 1500);
    // At 0 and 0.5 s the other is metres away, at 1 s before the body.
    CHECK(count_pixels(image, 2, 0, 2 * third) == 0);
    CHECK(count_pixels(image, 2, 2 * third, image.width) > 20);

    options.frames = 50;
    CHECK(sequence_picture(two_cubes(), options).width > 3 * image.width);
    MeshSequence empty = two_cubes();
    empty.num_frames = 0;
    CHECK_THROWS_AS(sequence_picture(empty, options), InputError);
}
