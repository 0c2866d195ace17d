// SPDX-License-Identifier: Apache-2.0
// Internal to this module: the describers of the table in describe_file.cpp. Each throws InputError for a broken file.
#pragma once

#include "ndg/core/types.h"
#include "ndg/info/describe_file.h"

#include <nlohmann/json_fwd.hpp>

namespace ndg {

void describe_h5(const FileQuestion& file, FileReport& report);
void describe_mesh(const FileQuestion& file, FileReport& report);
void describe_makehuman_target(const FileQuestion& file, FileReport& report);
void describe_motion(const FileQuestion& file, FileReport& report);
/// An ASF, or the character of DeepMimic's clips: by a motion beside it.
void describe_skeleton(const FileQuestion& file, FileReport& report);
void describe_runtime_model(const FileQuestion& file, FileReport& report);
/// TorchScript, checkpoints of trainings, AMASS.
void describe_zip(const FileQuestion& file, FileReport& report);
void describe_json(const FileQuestion& file, FileReport& report);
void describe_picture(const FileQuestion& file, FileReport& report);
void describe_point_cache(const FileQuestion& file, FileReport& report);
void describe_page(const FileQuestion& file, FileReport& report);
void describe_markdown(const FileQuestion& file, FileReport& report);
void describe_safetensors(const FileQuestion& file, FileReport& report);
void describe_onnx(const FileQuestion& file, FileReport& report);

/// Tool, options, inputs and licences as our files name them (docs/formats.md); with FileQuestion::check inputs that
/// are found, at their path or beside the file, are compared with their hashes.
void add_provenance(const FileQuestion& file, const std::string& created_by, const std::string& config,
                    const std::string& inputs, const std::string& licences, FileReport& report);
/// Smallest and largest coordinates; nothing where there are no points.
void add_box(const Eigen::Ref<const Points>& points, const std::string& unit, FileReport& report);

}  // namespace ndg
