// SPDX-License-Identifier: Apache-2.0
#include "ndg/display/field_picture.h"

#include "ndg/core/error.h"
#include "ndg/scene/pictures.h"

#include <algorithm>

namespace ndg {

Image skin_field_picture(const Points& vertices, const Triangles& triangles,
                         const std::vector<int>& vertices_with_values, const std::vector<SkinField>& fields,
                         double range, const std::string& footer, int height)
{
    require(!fields.empty() && range > 0, "a picture of {} fields with a range of {}", fields.size(), range);
    const Eigen::RowVector3f none(0.97f, 0.97f, 0.97f), full(0.75f, 0.05f, 0.10f), beyond(0.72f, 0.74f, 0.77f);
    PictureSettings settings;
    settings.height = height;
    SheetLabels labels;
    labels.footer = footer;
    std::vector<Image> images(2 * fields.size());
    for (std::size_t f = 0; f < fields.size(); ++f) {
        require(fields[f].values.size() == static_cast<Eigen::Index>(vertices_with_values.size()),
                "field {} has {} values for {} vertices", fields[f].label, fields[f].values.size(),
                vertices_with_values.size());
        SceneSurface surface;
        surface.name = fields[f].label;
        surface.vertices = vertices;
        surface.triangles = triangles;
        surface.gloss = 0.05f;
        surface.vertex_colours = beyond.replicate(vertices.rows(), 1);
        for (std::size_t v = 0; v < vertices_with_values.size(); ++v) {
            const auto share = float(std::clamp(fields[f].values[static_cast<Eigen::Index>(v)] / range, 0.0, 1.0));
            surface.vertex_colours.row(vertices_with_values[v]) = (1 - share) * none + share * full;
        }
        labels.columns.push_back(fields[f].label);
        images[f] = surface_picture(surface, View::front, settings);
        images[fields.size() + f] = surface_picture(surface, View::back, settings);
    }
    return tile_images(images, static_cast<int>(fields.size()), labels);
}

}  // namespace ndg
