// SPDX-License-Identifier: Apache-2.0
#include "ndg/makehuman/files.h"

#include "ndg/core/error.h"

#include <zlib.h>

#include <array>
#include <cmath>
#include <sstream>

namespace ndg {

namespace {

std::string read_gzip(const std::string& path)
{
    gzFile file = gzopen(path.c_str(), "rb");
    require_input(file != nullptr, "{}: cannot be opened", path);
    std::string content;
    std::array<char, 1 << 16> buffer;
    int count = 0;
    while ((count = gzread(file, buffer.data(), buffer.size())) > 0) content.append(buffer.data(), count);
    const int status = gzclose_r(file);
    require_input(count == 0 && status == Z_OK, "{}: truncated or damaged gzip data", path);
    return content;
}

}  // namespace

MakeHumanTarget read_makehuman_target(const std::string& path, int num_vertices)
{
    std::istringstream lines(read_gzip(path));
    MakeHumanTarget target;
    std::vector<Eigen::RowVector3d> offsets;
    std::string line;
    for (int line_number = 1; std::getline(lines, line); ++line_number) {
        if (line.empty() || line[0] == '#' || line[0] == '\r') continue;
        std::istringstream fields(line);
        int vertex = -1;
        Eigen::RowVector3d offset;
        fields >> vertex >> offset.x() >> offset.y() >> offset.z();
        require_input(!fields.fail() && offset.allFinite(), "{}: line {}: '{}' is not 'vertex dx dy dz'", path,
                      line_number, line);
        require_input(vertex >= 0 && vertex < num_vertices, "{}: line {}: vertex {} is outside 0..{}", path,
                      line_number, vertex, num_vertices - 1);
        target.vertices.push_back(vertex);
        offsets.push_back(offset);
    }
    target.offsets.resize(static_cast<Eigen::Index>(offsets.size()), 3);
    for (std::size_t i = 0; i < offsets.size(); ++i) target.offsets.row(i) = offsets[i];
    return target;
}

}  // namespace ndg
