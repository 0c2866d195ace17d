// SPDX-License-Identifier: Apache-2.0
// What tools that work on samples read: template, bodies, poses, and which bodies in which poses.
#pragma once

#include "ndg/body/pose_set.h"
#include "ndg/body/template.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/splits.h"

#include <functional>
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
    /// The same without the need of --poses: `other_poses` makes them for the template where it is not given. Samples
    /// are then of --body or, without it, of all bodies, in all poses.
    void add_files(Tool& tool, std::function<PoseSet(const Template&)> other_poses);
    /// Samples of all splits: --splits, or --body and --pose.
    void add_splits(Tool& tool);
    /// Samples of one split: the same and --split.
    void add_samples(Tool& tool);
    /// How bodies are posed, into samples.posing.
    void add_posing(Tool& tool);
    /// Inside Tool::run. Throws InputError naming the file or option that does not fit, or that gives no sample.
    void read();

    Template body_template;
    BodySet bodies;
    PoseSet poses;
    Splits splits;               ///< with --body, its samples in `split`; none without add_splits or add_samples
    std::string split = "test";  ///< of `samples`
    SampleIndex samples;         ///< without a method; none where add_samples was not called
    bool by_body() const { return body_idx_ >= 0; }

private:
    void read_splits_or_body();
    bool other_poses() const { return poses_path_.empty(); }

    std::string template_path_, bodies_path_, poses_path_, splits_path_;
    std::function<PoseSet(const Template&)> make_poses_;
    int body_idx_ = -1, pose_idx_ = -1;
    bool with_splits_ = false, with_samples_ = false;
};

}  // namespace ndg
