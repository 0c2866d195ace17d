// SPDX-License-Identifier: Apache-2.0
// What tools that work on samples read: template, bodies, poses, and which bodies in which poses.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/sample_index.h"

#include <string>

namespace ndg {

/// Options of the command line, and what they name once read() was called.
class SampleInputs {
public:
    SampleInputs() = default;
    SampleInputs(const SampleInputs&) = delete;
    SampleInputs& operator=(const SampleInputs&) = delete;

    /// --template, --bodies and --poses; the tool keeps references.
    void add_files(Tool& tool);
    /// Which samples: --splits and --split, or --body and --pose.
    void add_samples(Tool& tool);
    /// How bodies are posed, into samples.posing.
    void add_posing(Tool& tool);
    /// Inside Tool::run. Throws InputError naming the file or option that does not fit, or that gives no sample.
    void read();

    Template body_template;
    BodySet bodies;
    PoseSet poses;
    std::string split = "test";  ///< of all samples
    SampleIndex samples;         ///< without a method; none where add_samples was not called

private:
    void read_samples();

    std::string template_path_, bodies_path_, poses_path_, splits_path_;
    int body_idx_ = -1, pose_idx_ = -1;
    bool with_samples_ = false;
};

}  // namespace ndg
