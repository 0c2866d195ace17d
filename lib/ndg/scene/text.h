// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "ndg/scene/image.h"

#include <string>

namespace ndg {

/// Width in pixels of a line of text at an integer scale (5 x 7 pixel letters, 1 pixel apart).
int text_width(const std::string& text, int scale);
/// Height of a line in pixels, descenders included.
int text_height(int scale);
/// Draws printable ASCII with its top left corner at (x, y); other bytes are drawn as "?". Cut off at the image edges.
void draw_text(Image& image, const std::string& text, int x, int y, int scale, Pixel colour);

}  // namespace ndg
