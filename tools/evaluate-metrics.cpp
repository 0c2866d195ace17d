// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/evaluate/report.h"
#include "ndg/io/licences.h"

#include <algorithm>
#include <iostream>
#include <sstream>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("evaluate-metrics", "Compares predictions with FEM on one split and writes Table 1 and the report",
              "evaluate-metrics --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
              "--reference fem.h5 --prediction ndg.h5 --prediction lbs.h5 --output report/tables.json");
    SampleInputs inputs;
    Report report;
    std::string reference_path, seconds_path, output_path;
    std::vector<std::string> prediction_paths, variant_paths, beyond_paths;
    inputs.add_files(tool);
    inputs.add_samples(tool);
    tool.input("reference", reference_path, "FEM samples");
    tool.input("prediction", prediction_paths,
               "Deformations of one method; may be given several times, in the order of the table's rows");
    tool.input("variant", variant_paths, "the same of a variant of NDG, for Table 4", false);
    tool.input("beyond-paper", beyond_paths, "the same of a method that the paper has not", false);
    tool.input("unseen", report.unseen_path, "tables.json of a body outside the training distribution, for Table 2",
               false);
    tool.input("protrusion", report.protrusion_path, "what measure-protrusion wrote, for Table 3", false);
    tool.input("seconds", seconds_path, "JSON object: stage -> seconds, copied into the tables", false);
    tool.output("output", output_path, "tables.json; results.md and index.html are written beside it");

    return tool.run(argc, argv, [&] {
        inputs.read();
        const Template& body_template = inputs.body_template;
        const auto load = [&](const std::string& path) {
            log_info("Reading {}", path);
            return NamedDeformations{path, open_deformations(path, body_template.num_volume_vertices())};
        };
        const NamedDeformations reference = load(reference_path);
        std::vector<NamedDeformations> predictions;
        for (const auto* paths : {&prediction_paths, &variant_paths, &beyond_paths})
            for (const std::string& path : *paths) predictions.push_back(load(path));

        report.split = inputs.split;
        const ComparedPairs compared = compared_pairs(inputs.samples.pairs, inputs.split, reference);
        const std::vector<MethodMetrics> rows =
            evaluate_methods(body_template, inputs.bodies, compared.pairs, inputs.split, reference, predictions);
        const auto variants = rows.begin() + 1 + prediction_paths.size(), beyond = variants + variant_paths.size();
        report.rows.assign(rows.begin(), variants);
        report.variants.assign(variants, beyond);
        report.beyond_paper.assign(beyond, rows.end());
        report.counts = count_data(body_template, inputs.bodies, inputs.poses.size(), compared, reference,
                                   convergence_criterion(reference_path));
        if (!seconds_path.empty()) report.seconds_json = read_seconds(seconds_path);
        report.command = fmt::format("{}", fmt::join(argv, argv + argc, " "));
        report.inputs = tool.provenance().inputs;
        std::istringstream licences(merged_licences(tool.provenance()));
        for (std::string line; std::getline(licences, line);) report.licences.push_back(line);
        write_report(output_path, report);

        for (const MethodMetrics& row : rows)
            std::cout << fmt::format(
                "{:<18} E_pos {:8.3f} mm  E_grad {:9.4f}e-3  E_inv {:8.2f}  E_corner {:8.2f}  E_vol {:9.4f}e-3\n",
                row.method, row.mean.position_error_mm, 1e3 * row.mean.gradient_error, row.mean.inverted_prisms,
                row.mean.corner_inverted_prisms, 1e3 * row.mean.volume_error);
    });
}
