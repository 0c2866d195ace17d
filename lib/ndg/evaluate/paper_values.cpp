// SPDX-License-Identifier: Apache-2.0
#include "ndg/evaluate/paper_values.h"

#include <map>

namespace ndg {

namespace {

const double none = std::nan("");

}  // namespace

const std::vector<PaperRow>& paper_rows(const std::string& table)
{
    static const std::map<std::string, std::vector<PaperRow>> tables = {
        {"table1",
         {{"FEM", 0.00, 0.00, 3.10, 2.05},
          {"NDG", 3.19, 1.11, 9.22, 3.75},
          {"VertexNet", 3.41, 3.01, 25.63, 13.96},
          {"Gradient Skinning", 6.69, 9.89, 93.99, 33.32},
          {"LBS", 7.56, 15.04, 167.63, 40.67},
          {"Projective Skinning", none, none, 11.31, 28.05},
          {"CoRot LinFEM", none, none, 108.18, 21.99}}},
        {"table2", {{"NDG", 1.06, 1.94, 12.89, 4.43}, {"VertexNet", 1.54, 14.77, 149.15, 44.35}}},
        {"table4",
         {{"NDG", 3.19, 1.11, 9.22, 3.75},
          {"NDG no matrix exp", 3.19, 1.10, 12.45, 4.04},
          {"NDG no rotation", 3.39, 1.38, 11.23, 4.42},
          {"NDG no body shape", 3.69, 1.93, 14.02, 5.23}}}};
    static const std::vector<PaperRow> nothing;
    const auto found = tables.find(table);
    return found == tables.end() ? nothing : found->second;
}

const std::vector<PaperProtrusion>& paper_protrusion()
{
    static const std::vector<PaperProtrusion> rows = {
        {"NDG", 17.2, 0.0, 0.0}, {"HIT", 100.0, 100.0, 3.4}, {"SKEL", 100.0, 100.0, 4.1}};
    return rows;
}

std::string method_in_words(const std::string& method)
{
    static const std::map<std::string, std::string> words = {
        {"FEM", "quasi-static minimum of the flesh's and the skin's energy, the reference"},
        {"NDG", "a network gives each prism's residual deformation gradient, a Poisson solve the vertices"},
        {"VertexNet", "a network gives offsets at rest in principal components, linear blend skinning poses them"},
        {"Gradient Skinning", "the Poisson solve for the blended bone rotations alone: NDG without its network"},
        {"LBS", "linear blend skinning of the volume: VertexNet without its network"},
        {"NDG no matrix exp", "NDG whose network gives matrices, without the matrix exponential"},
        {"NDG no rotation", "NDG whose network gives gradients that hold the blended bone rotation"},
        {"NDG no body shape", "NDG whose network does not see the body's shape"},
        {"NDG not augmented", "NDG trained without mirrored and spliced samples"}};
    const auto found = words.find(method);
    return found == words.end() ? "" : found->second;
}

}  // namespace ndg
