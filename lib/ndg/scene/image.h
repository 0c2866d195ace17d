// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/core/colour.h"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ndg {

using Pixel = std::array<std::uint8_t, 3>;

/// 8-bit sRGB, row-major from the top left corner.
struct Image {
    int width = 0, height = 0;
    std::vector<Pixel> pixels;

    Image() = default;
    /// Filled with one colour. Throws Error for sizes outside 1..30000.
    Image(int image_width, int image_height, Pixel fill = {255, 255, 255});

    Pixel& at(int x, int y) { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
    const Pixel& at(int x, int y) const { return pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)]; }
};

/// Rounded to 8 bits after encoding.
Pixel pixel_from_linear(const Eigen::Vector3f& colour);

/// Writes a PNG through a temporary name and a rename. Throws Error when it cannot be written.
void write_png(const std::string& path, const Image& image);

/// Copies `source` into `target` with its top left corner at (x, y); what falls outside is cut off.
void paste(Image& target, const Image& source, int x, int y);

/// Images side by side, row by row, `columns` a row, each cell as large as the largest image, with a line of text above
/// each column and left of each row. Label lists may be empty, otherwise hold one entry a column or row. Throws Error
/// for no image or other label counts.
struct SheetLabels {
    std::string title;
    std::vector<std::string> columns;
    std::vector<std::string> rows;
    std::string footer;
};
Image tile_images(const std::vector<Image>& images, int columns, const SheetLabels& labels,
                  Pixel background = {255, 255, 255});

}  // namespace ndg
