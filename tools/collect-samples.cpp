// SPDX-License-Identifier: Apache-2.0
#include "ndg/core/error.h"
#include "ndg/core/tool.h"
#include "ndg/dataset/check_dataset.h"
#include "ndg/dataset/shards.h"
#include "ndg/simulation/sample_part.h"
#include "ndg/simulation/simulate.h"

int main(int argc, char** argv)
{
    using namespace ndg;
    Tool tool("collect-samples",
              "Joins the shards of a dataset without copying them; tells how far they are; checks what was joined.",
              "collect-samples --splits splits.h5 --output samples.h5");
    std::string splits_path, output;
    bool status = false, check = false;
    int shard_count = 0;
    double min_converged = 0.99;
    tool.input("splits", splits_path, "splits and pairs");
    tool.output("output", output, "the dataset, as given to simulate-fem", true, true);
    tool.parameter("status", status, "tell how far the shards are, and stop");
    tool.parameter("check", check, "read all of the dataset and name every defect, and stop");
    tool.parameter("shard-count", shard_count, "for --status: number of shards; 0: as found", 0, 1000000);
    tool.parameter("min-converged", min_converged, "smallest share of converged samples for exit code 0", 0, 1);
    return tool.run(argc, argv, [&] {
        require_input(!status || !check, "--status and --check cannot be given together");
        const Splits splits = read_splits(splits_path);
        if (status) {
            fmt::print("{}", status_report(dataset_status(output, splits, shard_count)));
            return;
        }
        if (check) {
            const std::vector<std::string> defects = check_dataset(output, splits, simulation_statistics());
            if (defects.size() > 1) fmt::print("{}\n", fmt::join(defects, "\n"));
            if (defects.size() == 1) throw InputError(defects.front());
            require_input(defects.empty(), "{}: has {} defects", output, defects.size());
        }
        const DeformationSet set =
            check ? open_deformations(output) : merge_shards(output, splits, tool.provenance(), tool.force());
        const SimulationSummary summary = summarize_simulation(set);
        fmt::print("{}", simulation_report(summary, set));
        if (check) fmt::print("complete, finite, no pair and no deformation twice\n");
        for (const FailedSample& failure : set.failures) {
            fmt::print("failed: {}: {}\n", describe(SampleKey{failure.split, failure.pair}), failure.reason);
        }
        require_converged(summary, min_converged);
    });
}
