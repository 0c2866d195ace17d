// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/log.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/sample_inputs.h"
#include "ndg/evaluate/report.h"

#include <algorithm>
#include <iostream>

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("evaluate-metrics", "Compares predictions with FEM on one split and writes Table 1 and the report",
              "evaluate-metrics --template template.h5 --bodies bodies.h5 --poses poses.h5 --splits splits.h5 "
              "--reference fem.h5 --prediction ndg.h5 --prediction lbs.h5 --output report/tables.json");
    SampleInputs inputs;
    std::string reference_path, seconds_path, output_path, expect_order;
    std::vector<std::string> prediction_paths;
    inputs.add_files(tool);
    inputs.add_samples(tool);
    tool.input("reference", reference_path, "FEM samples");
    tool.input("prediction", prediction_paths,
               "Deformations of one method; may be given several times, in the order of the table's rows");
    tool.input("seconds", seconds_path, "JSON object: stage -> seconds, copied into the tables", false);
    tool.output("output", output_path, "tables.json; results.md and index.html are written beside it");
    tool.parameter("expect-order", expect_order,
                   "Exit with 3 unless E_pos, E_grad and E_vol grow along this chain, e.g. \"NDG<LBS\"");

    return tool.run(argc, argv, [&] {
        inputs.read();
        const Template& body_template = inputs.body_template;
        const std::vector<SamplePair>& pairs = inputs.samples.pairs;
        const auto load = [&](const std::string& path) {
            log_info("Reading {}", path);
            return NamedDeformations{path, open_deformations(path, body_template.num_volume_vertices())};
        };
        const NamedDeformations reference = load(reference_path);
        std::vector<NamedDeformations> predictions;
        for (const std::string& path : prediction_paths) predictions.push_back(load(path));

        Report report;
        report.split = inputs.split;
        report.rows = evaluate_methods(body_template, inputs.bodies, pairs, inputs.split, reference, predictions);
        report.counts = count_data(body_template, inputs.bodies, inputs.poses.size(), pairs, reference,
                                   convergence_criterion(reference_path));
        if (!seconds_path.empty()) report.seconds_json = read_seconds(seconds_path);
        for (const Provenance::Input& file : tool.provenance().inputs)
            if (!file.licences.empty() &&
                std::find(report.licences.begin(), report.licences.end(), file.licences) == report.licences.end())
                report.licences.push_back(file.licences);
        // Checked before writing, so that a misspelt order leaves no report behind.
        const std::string violation = expect_order.empty() ? "" : order_violation(report.rows, expect_order);
        write_report(output_path, report);

        for (const MethodMetrics& row : report.rows)
            std::cout << fmt::format(
                "{:<18} E_pos {:8.3f} mm  E_grad {:9.4f}e-3  E_inv {:8.2f}  E_corner {:8.2f}  E_vol {:9.4f}e-3\n",
                row.method, row.mean.position_error_mm, 1e3 * row.mean.gradient_error, row.mean.inverted_prisms,
                row.mean.corner_inverted_prisms, 1e3 * row.mean.volume_error);
        if (!violation.empty())
            throw QualityError(fmt::format("The expected order {} does not hold: {}", expect_order, violation));
    });
}
