// SPDX-License-Identifier: Apache-2.0
#include "ndg/scene/image.h"

#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/scene/text.h"

#include <png.h>

#include <algorithm>
#include <cmath>

namespace ndg {
namespace {

/// libpng's own error path is a longjmp past our destructors; an exception from this callback unwinds properly.
[[noreturn]] void throw_png_error(png_structp, png_const_charp message)
{
    throw Error(fmt::format("PNG could not be encoded: {}", message));
}

void append_bytes(png_structp png, png_bytep bytes, png_size_t size)
{
    static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), size);
}

void no_flush(png_structp) {}

struct PngWriter {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, throw_png_error, nullptr);
    png_infop info = png ? png_create_info_struct(png) : nullptr;
    PngWriter() = default;
    PngWriter(const PngWriter&) = delete;
    PngWriter& operator=(const PngWriter&) = delete;
    ~PngWriter() { png_destroy_write_struct(&png, &info); }
};

}  // namespace

Image::Image(int image_width, int image_height, Pixel fill) : width(image_width), height(image_height)
{
    require(width >= 1 && width <= 30000 && height >= 1 && height <= 30000,
            "An image of {} x {} pixels is not possible", width, height);
    pixels.assign(std::size_t(width) * std::size_t(height), fill);
}

Pixel pixel_from_linear(const Eigen::Vector3f& colour)
{
    Pixel pixel{};
    for (int k = 0; k < 3; ++k) pixel[std::size_t(k)] = std::uint8_t(std::lround(255.0f * srgb_from_linear(colour[k])));
    return pixel;
}

void write_png(const std::string& path, const Image& image)
{
    static_assert(sizeof(Pixel) == 3);
    require(image.width > 0 && image.height > 0, "{} would be an empty image", path);
    std::string bytes;
    PngWriter writer;
    require(writer.info != nullptr, "libpng could not be initialised");
    png_set_write_fn(writer.png, &bytes, append_bytes, no_flush);
    png_set_IHDR(writer.png, writer.info, png_uint_32(image.width), png_uint_32(image.height), 8, PNG_COLOR_TYPE_RGB,
                 PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_sRGB(writer.png, writer.info, PNG_sRGB_INTENT_PERCEPTUAL);
    png_write_info(writer.png, writer.info);
    for (int y = 0; y < image.height; ++y) png_write_row(writer.png, image.at(0, y).data());
    png_write_end(writer.png, writer.info);
    write_file(path, bytes);
}

void paste(Image& target, const Image& source, int x, int y)
{
    for (int row = std::max(0, -y); row < std::min(source.height, target.height - y); ++row)
        for (int column = std::max(0, -x); column < std::min(source.width, target.width - x); ++column)
            target.at(x + column, y + row) = source.at(column, row);
}

Image tile_images(const std::vector<Image>& images, int columns, const SheetLabels& labels, Pixel background)
{
    require(!images.empty() && columns >= 1, "A sheet needs at least one image and one column");
    const int num_rows = (int(images.size()) + columns - 1) / columns;
    require(labels.columns.empty() || int(labels.columns.size()) == columns, "{} labels for {} columns",
            labels.columns.size(), columns);
    require(labels.rows.empty() || int(labels.rows.size()) == num_rows, "{} labels for {} rows", labels.rows.size(),
            num_rows);
    const Pixel ink = {45, 52, 60}, soft_ink = {110, 118, 126};
    constexpr int scale = 2, title_scale = 3, gap = 12;
    int cell_width = 0, cell_height = 0, left = gap, top = gap;
    for (const Image& image : images) {
        cell_width = std::max(cell_width, image.width);
        cell_height = std::max(cell_height, image.height);
    }
    for (const std::string& label : labels.columns) cell_width = std::max(cell_width, text_width(label, scale));
    for (const std::string& label : labels.rows) left = std::max(left, text_width(label, scale) + 2 * gap);
    if (!labels.title.empty()) top += text_height(title_scale) + gap;
    if (!labels.columns.empty()) top += text_height(scale) + gap;
    int width = left + columns * (cell_width + gap);
    width =
        std::max({width, text_width(labels.title, title_scale) + 2 * gap, text_width(labels.footer, scale) + 2 * gap});
    const int bottom = labels.footer.empty() ? 0 : text_height(scale) + gap;
    Image sheet(width, top + num_rows * (cell_height + gap) + bottom, background);
    draw_text(sheet, labels.title, gap, gap, title_scale, ink);
    for (std::size_t k = 0; k < labels.columns.size(); ++k) {
        const int x = left + int(k) * (cell_width + gap) + (cell_width - text_width(labels.columns[k], scale)) / 2;
        draw_text(sheet, labels.columns[k], x, top - gap / 2 - text_height(scale), scale, ink);
    }
    for (std::size_t k = 0; k < labels.rows.size(); ++k)
        draw_text(sheet, labels.rows[k], gap, top + int(k) * (cell_height + gap) + cell_height / 2, scale, ink);
    for (std::size_t i = 0; i < images.size(); ++i) {
        const int x = left + int(i) % columns * (cell_width + gap) + (cell_width - images[i].width) / 2;
        const int y = top + int(i) / columns * (cell_height + gap) + (cell_height - images[i].height) / 2;
        paste(sheet, images[i], x, y);
    }
    draw_text(sheet, labels.footer, gap, sheet.height - gap - text_height(scale), scale, soft_ink);
    return sheet;
}

}  // namespace ndg
