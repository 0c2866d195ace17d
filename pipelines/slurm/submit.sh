#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# submit.sh: simulates the samples of a dataset as a Slurm job array, joins and checks them after it, and starts what
# comes next after that. Given again it submits only what is not finished, so it is also the way to resubmit.
#
# Environment: OUT (folder with template.h5, bodies.h5, poses.h5, splits.h5; gets fem.h5), BIN (the executables), CONFIG
# (JSON preset), SHARDS (array tasks), SLOTS (of them at a time; empty: all), PARTITION (empty: the default one), TIME,
# CPUS and MEMORY (of a task), SBATCH_OPTIONS (more for every job), NEXT (a command that runs after the dataset is
# complete; empty: none), NEXT_PARTITION, NEXT_TIME, NEXT_CPUS, NEXT_MEMORY, NEXT_OPTIONS (of that job).
set -eu
: "${OUT:?the folder of the dataset}" "${BIN:?the folder of the executables}" "${CONFIG:?the preset}"
. "$(dirname "$0")/jobs.sh"
OUT=$(cd "$OUT" && pwd) BIN=$(cd "$BIN" && pwd) CONFIG=$(realpath "$CONFIG")
for file in template bodies poses splits; do
    [ -f "$OUT/$file.h5" ] || fail "$OUT/$file.h5 does not exist; make it first"
done
mkdir -p "$OUT/slurm"

name_jobs "$OUT" fem collect next

status=$("$BIN/collect-samples" --splits "$OUT/splits.h5" --output "$OUT/fem.h5" --status --shard-count "$SHARDS")
echo "$status"
unfinished=$(sed -n 's/^unfinished *//p' <<< "$status")

after=()
if [ "$unfinished" != none ]; then
    submit_array fem "$unfinished" "$BIN/simulate-fem" --config "$CONFIG" --template "$OUT/template.h5" \
        --bodies "$OUT/bodies.h5" --poses "$OUT/poses.h5" --splits "$OUT/splits.h5" --output "$OUT/fem.h5"
fi
collect=$(submit collect ${after[@]+"${after[@]}"} ${PARTITION:+--partition "$PARTITION"} --time "$TIME" --mem "$MEMORY" \
    --output "$OUT/slurm/collect.log" "$scripts/collect.sbatch" "$BIN" "$CONFIG" "$OUT")
echo "collect     job $collect${after[1]:+, after the array}"
submit_next "$collect"
