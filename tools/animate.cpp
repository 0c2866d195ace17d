// SPDX-License-Identifier: Apache-2.0
#include "ndg/deform/animate.h"
#include "ndg/body/stored_pose.h"
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/deform/deformer.h"
#include "ndg/display/body_meshes.h"
#include "ndg/display/motion_display.h"
#include "ndg/retarget/import_motions.h"

#include <unistd.h>

#include <optional>

#ifdef NDG_WITH_TORCH
#define NDG_NETWORK_METHODS(ROW) ROW(register_network_deformer)
#else
#define NDG_NETWORK_METHODS(ROW)
#endif

// The table of methods, in the order of result tables and pictures: each row is a function that its own file defines.
#define NDG_METHODS(ROW)               \
    ROW(register_fem)                  \
    NDG_NETWORK_METHODS(ROW)           \
    ROW(register_gradient_skinning)    \
    ROW(register_lbs)                  \
    ROW(register_projective_skinning)  \
    ROW(register_corotated_elasticity) \
    ROW(register_linear_correctives)   \
    ROW(register_rigid_parts)          \
    ROW(register_runtime)              \
    ROW(register_stored_gradients)

namespace ndg {
#define NDG_DECLARE(name) void name(MethodTable& table);
NDG_METHODS(NDG_DECLARE)
}  // namespace ndg

namespace {

/// A file beside another for what is not kept; gone with the object.
struct ScratchFile {
    std::string path;

    explicit ScratchFile(const std::string& beside) : path(ndg::temporary_name(beside) + ".h5") {}
    ~ScratchFile() { ::unlink(path.c_str()); }
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
};

}  // namespace

int main(int argc, char** argv)
{
    using namespace ndg;
    MethodTable methods;
#define NDG_ADD(name) name(methods);
    NDG_METHODS(NDG_ADD)

    Tool tool("animate",
              "Poses bodies with their flesh, by one of several methods: vertices, meshes, a page, a picture.",
              "animate --template template.h5 --bodies body.h5 --motion jump.bvh --page jump.html --mesh jump.glb");
    SampleInputs inputs;
    MotionFiles motions;
    MotionImportOptions import_options;
    import_options.retarget.frame_rate = 0.0;
    import_options.interpolate = true;
    AnimationOutputs outputs;
    MotionDisplay display;
    std::string flag = "gradient-skinning", name, licences;
    std::vector<std::string> failures;
    inputs.add_files(tool, [&](const Template& body_template) {
        require_input(!motions.motions.empty(), "give --motion or --poses");
        motions.complete();
        ImportedMotions imported = import_motions(motions, import_options, body_template.rest.joint_positions,
                                                  [](const std::string& line) { fmt::print("{}\n", line); });
        licences = imported.licences;
        failures = imported.failures;
        for (Pose& pose : imported.poses.poses) pose = as_stored(pose);
        return std::move(imported.poses);
    });
    motions.add(tool, false);
    tool.options(import_options);
    inputs.add_samples(tool);
    inputs.add_posing(tool);
    tool.output("output", outputs.deformations, "deformed samples", false);
    tool.output("anatomy", outputs.anatomy, "embedded anatomy of every sample", false);
    display.add(tool);
    tool.listing("list-methods", fmt::format("{}", fmt::join(methods.flags(), "\n")), "the methods, one a line");
    tool.parameter("method", flag, methods.help(), methods.flags());
    tool.parameter("name", name, "of the method in tables, instead of its own");
    methods.add_options(tool);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        require_input(!outputs.deformations.empty() || !outputs.anatomy.empty() || display.wanted(),
                      "give --output, --anatomy, --page, --mesh, --picture or several of them");
        require_input(!inputs.has_pose_file() || motions.motions.empty(), "give one of --motion and --poses, not both");
        inputs.read();
        display.check(inputs.samples, tool.force());
        // Frames are read back one by one for what shows them, so that no motion is too long.
        std::optional<ScratchFile> scratch;
        if (outputs.deformations.empty()) {
            for (const std::string& path : {display.picture, display.mesh, display.page, outputs.anatomy})
                if (!path.empty()) outputs.deformations = path;
            scratch.emplace(outputs.deformations);
            outputs.deformations = scratch->path;
        }
        const DeformationMethod& method = methods.find(flag);
        const std::unique_ptr<Deformer> deformer = method.make(BodyPoser(inputs.body_template, inputs.samples.posing));
        if (name.empty()) name = deformer->name();
        if (name.empty()) name = method.table_name;
        const Provenance provenance = tool.provenance(licences);
        animate_samples(inputs, *deformer, name, outputs, provenance);
        fmt::print("{} samples of split {} deformed by {}\n", inputs.samples.size(), inputs.split, name);
        if (display.wanted())
            display.write(inputs, open_deformations(outputs.deformations), *deformer, credits_of(provenance));
        if (!failures.empty())
            throw QualityError(
                fmt::format("{} motions could not be read: {}", failures.size(), fmt::join(failures, "; ")));
    });
}
