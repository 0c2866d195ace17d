// SPDX-License-Identifier: Apache-2.0
#include "ndg/dataset/anatomy_file.h"

namespace ndg {

namespace {

const SamplePayload payload = {"ndg-anatomy",
                               1,
                               "/anatomy",
                               "/anatomy/vertices",
                               "vertices",
                               3,
                               "anatomy vertices carried by the deformed volume"};
const std::string triangles_name = "/anatomy/triangles";

}  // namespace

AnatomyWriter::AnatomyWriter(const std::string& path, const SampleIndex& index, const Triangles& triangles,
                             int num_vertices, const Provenance& provenance)
    : SampleWriter(path, payload, index, num_vertices, provenance)
{
    file_.write(triangles_name, RowMatrixI(triangles), "triangles of the anatomy vertices");
}

AnatomyReader::AnatomyReader(const std::string& path, int num_vertices) : SampleReader(path, payload, num_vertices) {}

Triangles AnatomyReader::triangles() const
{
    return file().read_int_matrix(triangles_name, -1, 3, 0, num_rows() - 1);
}

}  // namespace ndg
