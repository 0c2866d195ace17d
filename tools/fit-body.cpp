// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/file.h"
#include "ndg/core/hash.h"
#include "ndg/core/interrupt.h"
#include "ndg/core/tool.h"
#include "ndg/measures/measure_report.h"
#include "ndg/registration/batch_report.h"
#include "ndg/registration/fit_part.h"
#include "ndg/scan/people.h"

#include <fmt/format.h>

#include <ctime>

namespace {

double core_seconds()
{
    return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

}  // namespace

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("fit-body",
              "Fits the template's skin to scans of people, meshes or point clouds, and brings it to the template's "
              "pose.",
              "fit-body --template template.h5 --scan scan.obj --output skins.h5");
    std::string template_path, output, poses, report_path, people, examples, truth_path;
    std::vector<std::string> scans;
    BatchOptions batch;
    FitOptions options;
    Person person;
    bool keep_failed = false, keep_outside = false;
    double min_passed = 1.0;
    tool.input("template", template_path, "template file");
    tool.input("scan", scans, "OBJ, PLY, OFF, STL or GLB files, or folders of them");
    tool.input("landmarks", batch.landmarks,
               "JSON file {name: [x, y, z]} in the scan's axes, or folder of NAME.json; without it none are needed",
               false);
    tool.input("people", people, "JSON file {name: {\"sex\": 0 to 1, \"age_years\": ...}}", false);
    tool.input("examples", examples,
               "skins of the template with known joints (sample-bodies), instead of the template's own examples",
               false);
    tool.input("truth", truth_path, "truth of simulated scans, to print errors", false);
    tool.output("output", output, "skins file to write: the bodies that pass the gate");
    tool.output("poses", poses, "file for the poses that bring the skins back onto the scans", false);
    tool.output("report", report_path, "JSON file for the reports", false);
    tool.parameter("surfaces", batch.surfaces, "folder for the fitted skins in the scans' places, NAME.ply");
    tool.options(options);
    tool.parameter("sex", person.sex, "of people without an entry: 0 female, 1 male", 0.0, 1.0);
    tool.parameter("age-years", person.age_years, "of people without an entry", 18.0, 110.0);
    tool.parameter("keep-failed", keep_failed, "write bodies that miss the gate too");
    tool.parameter("keep-outside", keep_outside,
                   "joints outside of published ranges are named, but fail no body (ndg-info SKINS --template TEMPLATE "
                   "lists them)");
    tool.parameter("min-passed", min_passed, "exit code 3 when a smaller share of the scans passes", 0.0, 1.0);
    return tool.run(argc, argv, [&] {
        catch_interrupts();
        const Template body_template = read_template(template_path);
        const Provenance provenance = tool.provenance();
        const People known = people.empty() ? People{} : read_people(people);
        const ScanTruth truth = truth_path.empty() ? ScanTruth{} : read_scan_truth(truth_path, body_template);
        std::vector<JointExample> joint_examples;
        std::vector<std::string> hashes = {body_template.file_sha256};
        for (const Skin& example : body_template.examples) {
            joint_examples.push_back({example.skin_vertices, example.joint_positions});
        }
        if (!examples.empty()) {
            joint_examples.clear();
            SkinSet set = read_skins(examples, body_template);
            for (Skin& body : set.bodies) {
                joint_examples.push_back({std::move(body.skin_vertices), std::move(body.joint_positions)});
            }
            hashes.push_back(sha256_path(examples));
        }
        const BodyFitter fitter(body_template, options, joint_examples);
        const std::vector<std::string> files = scan_files(scans);
        const PartStore store(output, scan_parts, fit_key(options, hashes), tool.force());
        std::vector<BatchEntry> entries =
            fit_batch(fitter, files, options, body_template.skin_triangles, batch, store, interrupt_requested);
        const auto person_of = [&](const std::string& name) {
            const auto found = known.find(name);
            return found == known.end() ? person : found->second;
        };
        for (BatchEntry& entry : entries) {
            if (!entry.failure.empty()) continue;
            const MeasuredBody measured = measure_skin(body_template, entry.fitted.body, person_of(entry.name()));
            std::vector<std::string>& defects = entry.fitted.report.defects;
            const std::vector<std::string> outside = measured.failures();
            if (keep_outside)
                fmt::print("{}", failure_report({measured}));
            else
                defects.insert(defects.end(), outside.begin(), outside.end());
        }

        const BatchReport report(entries, truth, body_template.skin_triangles);
        fmt::print("{}", report.text(entries));
        // Scans that an earlier run finished cost this one nothing.
        fmt::print("core-seconds of this run: {:.1f}, {:.2f} a scan\n", core_seconds(),
                   core_seconds() / static_cast<double>(entries.size()));
        if (!report_path.empty()) write_file(report_path, report.json(entries));
        const std::size_t kept = keep_failed ? report.fitted : report.passed;
        if (kept == 0) {
            store.remove();
            // A single scan that cannot be read is wrong input, not a gate that failed.
            require_input(entries.size() > 1 || report.fitted > 0, "{}", entries.front().failure);
            throw QualityError(fmt::format("none of the {} scans passes, {} is not written", entries.size(), output));
        }
        SkinSet skins = batch_skins(entries, keep_failed, [&](const std::string& name) {
            const Person p = person_of(name);
            return std::make_pair(p.sex, p.age_years);
        });
        skins.template_sha256 = body_template.file_sha256;
        write_skins(output, skins, provenance);
        if (!poses.empty()) write_poses(poses, batch_poses(entries, keep_failed), provenance);
        store.remove();
        if (report.passed_share() < min_passed) {
            throw QualityError(
                fmt::format("{} of {} scans did not pass", entries.size() - report.passed, entries.size()));
        }
    });
}
