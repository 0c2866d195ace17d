// SPDX-License-Identifier: Apache-2.0
#include "ndg/io/schema.h"

namespace ndg {
namespace {

constexpr bool optional = true;

const SchemaItem body_names = {"/bodies/names", "B", "text"};

std::vector<SchemaItem> skin_items()
{
    return {{"@template_sha256", "", "text"},
            body_names,
            {"/bodies/parameter_names", "K", "text"},
            {"/bodies/parameters", "B x K", "float64"},
            {"/bodies/skin_vertices", "B x N_s x 3", "float32"},
            {"/bodies/joint_positions", "B x J x 3", "float32"}};
}

std::vector<SchemaItem> joined(std::vector<SchemaItem> items, const std::vector<SchemaItem>& more)
{
    items.insert(items.end(), more.begin(), more.end());
    return items;
}

/// Of a finished item of a resumable batch; what it holds besides is missing where the item failed.
std::vector<SchemaItem> part_items(const std::vector<SchemaItem>& more)
{
    return joined({{"@key", "", "text"}, {"@item", "", "text"}, {"@failure", "", "text"}}, more);
}

}  // namespace

const std::vector<SchemaItem>& common_attributes()
{
    static const std::vector<SchemaItem> items = {{"@format", "", "text"},     {"@format_version", "", "int32"},
                                                  {"@units", "", "text"},      {"@up_axis", "", "text"},
                                                  {"@created_by", "", "text"}, {"@config", "", "text"},
                                                  {"@inputs", "", "text"},     {"@licences", "", "text"}};
    return items;
}

// The sizes are explained in docs/formats.md. N_v = 3 N_w and N_p = 2 T_w, which shapes alone do not say.
const std::vector<Schema>& schemas()
{
    static const std::vector<Schema> all = {
        {"ndg-template",
         2,
         {{"@body_name", "", "text"},
          {"@source_name", "", "text"},
          {"/skeleton/joint_names", "J", "text"},
          {"/skeleton/parents", "J", "int32"},
          {"/skeleton/joint_positions", "J x 3", "float64"},
          {"/skin/vertices", "N_s x 3", "float64"},
          {"/skin/triangles", "T_s x 3", "int32"},
          {"/skin/weight_joints", "N_s x 8", "int32"},
          {"/skin/weights", "N_s x 8", "float64"},
          {"/skin/region_names", "R", "text"},
          {"/skin/regions", "T_s or 0", "int32"},
          {"/landmarks/names", "L", "text"},
          {"/landmarks/skin_triangles", "L", "int32"},
          {"/landmarks/barycentric", "L x 3", "float64"},
          {"/volume/wrap_to_skin", "N_w", "int32"},
          {"/volume/wrap_triangles", "T_w x 3", "int32"},
          {"/volume/prisms", "N_p x 6", "int32"},
          {"/volume/vertices", "N_v x 3", "float64"},
          {"/bone_interior/vertices", "N_i x 3", "float64"},
          {"/bone_interior/tetrahedra", "N_t x 4", "int32"},
          {"/bone_interior/weight_joints", "N_i x 8", "int32"},
          {"/bone_interior/weights", "N_i x 8", "float64"},
          {"/anatomy/vertices", "N_a x 3", "float64"},
          {"/anatomy/triangles", "T_a x 3", "int32"},
          {"/anatomy/part_names", "A", "text"},
          {"/anatomy/part_layers", "A", "text"},
          {"/anatomy/part_sides", "A", "text"},
          {"/anatomy/part_fma_ids", "A", "int32"},
          {"/anatomy/part_ranges", "A x 4", "int32"},
          {"/anatomy/weight_joints", "N_a x 8", "int32"},
          {"/anatomy/weights", "N_a x 8", "float64"},
          {"/anatomy/embedding_elements", "N_a", "int32"},
          {"/anatomy/embedding_vertices", "N_a x 6", "int32"},
          {"/anatomy/embedding_weights", "N_a x 6", "float64"},
          {"/anatomy/embedding_distances", "N_a", "float64"},
          {"/source/vertices", "N_s x 3 or 0 x 3", "int32"},
          {"/source/barycentric", "N_s x 3 or 0 x 3", "float64"},
          {"/source/joint_offsets", "J x 3 or 0 x 3", "float64"},
          {"/examples/skin_vertices", "X x N_s x 3", "float32", true},
          {"/examples/joint_positions", "X x J x 3", "float32", true}}},

        {"ndg-skins", 1, skin_items()},

        {"ndg-bodies", 1,
         joined(skin_items(), {{"/bodies/volume_vertices", "B x N_v x 3", "float32"},
                               {"/bodies/interior_vertices", "B x N_i x 3", "float32"}})},

        {"ndg-scan-truth",
         1,
         {body_names,
          {"/bodies/posed_skin", "B x N_s x 3", "float32"},
          {"/bodies/rest_skin", "B x N_s x 3", "float32"},
          {"/bodies/posed_joints", "B x J x 3", "float32"},
          {"/bodies/rest_joints", "B x J x 3", "float32"}}},

        {"ndg-poses",
         1,
         {{"/skeleton/joint_names", "J", "text"},
          {"/poses/rotations", "P x J x 9", "float32"},
          {"/poses/root_translations", "P x 3", "float64"},
          {"/poses/clip_idx", "P", "int32"},
          {"/poses/frame_idx", "P", "int32"},
          {"/poses/covering_radius", "P or 0", "float64"},
          {"/poses/spliced_from", "P x 6", "int32", optional},
          {"/clips/names", "C", "text"},
          {"/clips/frame_rates", "C", "float64"}}},

        {"ndg-splits",
         1,
         {{"/splits/<split>/bodies", "B_<split>", "int32"},
          {"/splits/<split>/poses", "P_<split>", "int32"},
          {"/splits/<split>/pairs", "n_<split> x 2", "int32"},
          {"/splits/<split>/frames", "n_<split>", "int32", optional}}},

        {"ndg-deformations",
         1,
         {{"@method", "", "text"},
          {"@bone_wrap", "", "text", optional},
          {"@simulation_key", "", "text", optional},
          {"@convergence_criterion", "", "text", optional},
          {"/deformations/pairs", "n x 2", "int32"},
          {"/deformations/frames", "n", "int32", optional},
          {"/deformations/splits", "n", "text"},
          {"/deformations/vertices", "n_slices x N_v x 3", "float32"},
          {"/deformations/stop_reasons", "n", "text", optional},
          {"/statistics/<name>", "n", "float64", optional},
          {"/failures/pairs", "n_failed x 2", "int32", optional},
          {"/failures/frames", "n_failed", "int32", optional},
          {"/failures/splits", "n_failed", "text", optional},
          {"/failures/reasons", "n_failed", "text", optional}}},

        {"ndg-gradients",
         1,
         {{"@method", "", "text"},
          {"@bone_wrap", "", "text", optional},
          {"/gradients/pairs", "n x 2", "int32"},
          {"/gradients/frames", "n", "int32", optional},
          {"/gradients/splits", "n", "text"},
          {"/gradients/F", "n_slices x N_p x 9", "float32"}}},

        {"ndg-anatomy",
         1,
         {{"@method", "", "text"},
          {"@bone_wrap", "", "text", optional},
          {"/anatomy/triangles", "T_a x 3", "int32"},
          {"/anatomy/pairs", "n x 2", "int32"},
          {"/anatomy/frames", "n", "int32", optional},
          {"/anatomy/splits", "n", "text"},
          {"/anatomy/vertices", "n_slices x N_a x 3", "float32"}}},

        {"ndg-shape-space",
         1,
         {{"@explained_variance", "", "float64"},
          {"/shape_space/mean", "3 N_v", "float64"},
          {"/shape_space/components", "3 N_v x d", "float32"},
          {"/shape_space/standard_deviations", "d", "float64"},
          {"/shape_space/codes", "B x d", "float64"},
          {"/shape_space/reconstruction_errors", "B", "float64"}}},

        {"ndg-model",
         2,
         {{"@widths", "", "text"},
          {"@bone_wrap", "", "text", optional},
          {"@output_space", "", "text", optional},
          {"@parametrisation", "", "text"},
          {"@rotation", "", "text"},
          {"@shape", "", "text"},
          {"@region_reach", "", "text", optional},
          {"@output_basis", "", "float64"},
          {"@template_sha256", "", "text"},
          {"@explained_variance", "", "float64"},
          {"@precision", "", "text", optional},
          {"@best_epoch", "", "float64"},
          {"@initial_train_loss", "", "float64"},
          {"@initial_validation_loss", "", "float64"},
          {"/network/layer_<i>/weight", "out_<i> x in_<i>", "float32"},
          {"/network/layer_<i>/bias", "out_<i>", "float32"},
          {"/network/layer_<i>/norm_weight", "out_<i>", "float32", optional},
          {"/network/layer_<i>/norm_bias", "out_<i>", "float32", optional},
          {"/network/output_basis", "k x outputs", "float32", optional},
          {"/network/region_<r>/inputs", "inputs_<r>", "int32", optional},
          {"/network/region_<r>/outputs", "outputs_<r>", "int32", optional},
          {"/network/region_<r>/output_basis", "k_<r> x outputs_<r>", "float32", optional},
          {"/input/joint_names", "J", "text"},
          {"/input/visible_joints", "J", "int32"},
          {"/shape_space/mean", "3 N_v", "float64"},
          {"/shape_space/components", "3 N_v x d", "float64"},
          {"/shape_space/standard_deviations", "d", "float64"},
          {"/training/epoch", "E", "int32", optional},
          {"/training/train_loss", "E", "float64", optional},
          {"/training/validation_loss", "E", "float64", optional}}},

        {"ndg-correctives",
         1,
         {{"@template_sha256", "", "text"},
          {"@bone_wrap", "", "text"},
          {"@ridge", "", "float64"},
          {"/correctives/joint_names", "K", "text"},
          {"/correctives/blend_shapes", "9 K x 6 N_w", "float32"}}},

        {"ndg-statistical-body",
         1,
         {{"@name", "", "text"},
          {"/skeleton/joint_names", "J", "text"},
          {"/skeleton/parents", "J", "int32"},
          {"/skin/vertices", "N_s x 3", "float64"},
          {"/skin/triangles", "T_s x 3", "int32"},
          {"/skin/weights", "N_s x J", "float64"},
          {"/skin/soft_triangles", "T_s", "int32", optional},
          {"/joints/regressor", "J x N_s", "float64"},
          {"/shape/directions", "S x 3 N_s", "float32", optional},
          {"/pose/joint_names", "J_p", "text", optional},
          {"/pose/directions", "9 J_p x 3 N_s", "float32", optional},
          {"/people/names", "B", "text", optional},
          {"/people/shapes", "B x S", "float64", optional}}},

        {"ndg-avatar",
         1,
         {{"@name", "", "text"},
          {"/skeleton/joint_names", "J", "text"},
          {"/skeleton/parents", "J", "int32"},
          {"/skeleton/joint_positions", "J x 3", "float64"},
          {"/volume/vertices", "M x 3", "float64"},
          {"/volume/num_held", "1", "int32"},
          {"/volume/tetrahedra", "D x 4", "int32"},
          {"/volume/normals", "M x 3", "float64"},
          {"/volume/weights", "M x J", "float64"},
          {"/skin/vertices", "N_s x 3", "float64"},
          {"/skin/triangles", "T_s x 3", "int32"},
          {"/skin/weights", "N_s x J", "float64"},
          {"/pose/joint_names", "J_p", "text", optional},
          {"/pose/volume_directions", "9 J_p x 3 M", "float32", optional},
          {"/pose/skin_directions", "9 J_p x 3 N_s", "float32", optional},
          {"/layer/skin_vertices", "N_w", "int32"},
          {"/layer/outer_vertices", "N_w", "int32"},
          {"/layer/triangles", "T_w x 3", "int32"},
          {"/layer/inward", "N_w x 3", "float64"},
          {"/layer/thickness", "N_w", "float64"},
          {"/layer/min_thickness", "N_w", "float64"},
          {"/layer/max_thickness", "N_w", "float64"},
          {"/control/vertices", "C_p", "int32"},
          {"/control/mirror_vertices", "C_p", "int32"},
          {"/control/weights", "M x C_p", "float64"}}},

        {"ndg-fields",
         1,
         {{"/flesh/vertices", "F x N_v x 3", "float32", optional},
          {"/flesh/points/<field>", "F x N_v", "float32", optional},
          {"/flesh/cells/<field>", "F x N_p", "float32", optional},
          {"/flesh/constant/<field>", "N_p", "float32", optional},
          {"/bone_interior/vertices", "F x N_b x 3", "float32", optional},
          {"/bone_interior/points/<field>", "F x N_b", "float32", optional},
          {"/bone_interior/cells/<field>", "F x N_t", "float32", optional},
          {"/bone_interior/constant/<field>", "N_t", "float32", optional}}},

        {"ndg-dynamics",
         1,
         {{"@model", "", "text"},
          {"@simulation_key", "", "text"},
          {"@convergence_criterion", "", "text"},
          {"@time_step", "", "float64"},
          {"@frame_rate", "", "float64"},
          {"/mesh/rest_vertices", "N_d x 3", "float64"},
          {"/mesh/held_count", "1", "int32"},
          {"/mesh/skin_triangles", "T_d x 3", "int32"},
          {"/sequences/names", "Q", "text"},
          {"/sequences/frame_begin", "Q", "int32"},
          {"/frames/times", "F", "float64"},
          {"/frames/vertices", "F x N_d x 3", "float32"},
          {"/statistics/<name>", "F", "float64"},
          {"/failures/sequences", "Q_failed", "text", optional},
          {"/failures/reasons", "Q_failed", "text", optional}}},

        {"ndg-dynamics-part", 1,
         part_items({{"/block/vertices", "F x N_d x 3", "float32", optional},
                     {"/block/times", "F", "float64", optional},
                     {"/statistics/<name>", "F", "float64", optional},
                     {"/state/positions", "N_d x 3", "float64", optional},
                     {"/state/velocities", "N_d x 3", "float64", optional}})},

        {"ndg-fem-part", 3,
         part_items({{"@stop_reason", "", "text", optional},
                     {"@<statistic>", "", "float64", optional},
                     {"/sample/vertices", "1 x N_v x 3", "float32", optional}})},

        {"ndg-body-part", 1,
         part_items({{"@name", "", "text", optional},
                     {"@seconds", "", "float64", optional},
                     {"/body/skin_vertices", "N_s x 3", "float64", optional},
                     {"/body/volume_vertices", "N_v x 3", "float64", optional},
                     {"/body/interior_vertices", "N_i x 3", "float64", optional},
                     {"/body/joint_positions", "J x 3", "float64", optional},
                     {"/body/parameters", "1 x K", "float64", optional}})},

        {"ndg-fit-part", 3,
         part_items({{"/report", "1", "text", optional},
                     {"/skin_vertices", "N_s x 3", "float64", optional},
                     {"/joint_positions", "J x 3", "float64", optional},
                     {"/posed_skin", "N_s x 3", "float64", optional},
                     {"/posed_joints", "J x 3", "float64", optional},
                     {"/rotations", "J x 9", "float64", optional},
                     {"/root_translation", "3", "float64", optional}})}};
    return all;
}

}  // namespace ndg
