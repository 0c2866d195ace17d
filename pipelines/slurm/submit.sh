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
SHARDS=${SHARDS:-16} SLOTS=${SLOTS:-} PARTITION=${PARTITION:-} TIME=${TIME:-04:00:00} CPUS=${CPUS:-1} MEMORY=${MEMORY:-2G}
NEXT=${NEXT:-} NEXT_PARTITION=${NEXT_PARTITION:-$PARTITION} NEXT_TIME=${NEXT_TIME:-12:00:00} NEXT_CPUS=${NEXT_CPUS:-4}
NEXT_MEMORY=${NEXT_MEMORY:-8G}
read -ra options <<< "${SBATCH_OPTIONS:-}"
read -ra next_options <<< "${NEXT_OPTIONS:-}"

fail() { echo "submit.sh: error: $*" >&2; exit 2; }
command -v sbatch > /dev/null || fail "there is no sbatch here; run this where jobs are submitted"
scripts=$(cd "$(dirname "$0")" && pwd)
OUT=$(cd "$OUT" && pwd) BIN=$(cd "$BIN" && pwd) CONFIG=$(realpath "$CONFIG")
for file in template bodies poses splits; do
    [ -f "$OUT/$file.h5" ] || fail "$OUT/$file.h5 does not exist; make it first"
done
mkdir -p "$OUT/slurm"

# The name tells the jobs of this dataset from those of others.
name=ndg-$(printf %s "$OUT" | md5sum | cut -c 1-8)
busy=$(squeue --noheader --name "$name-fem" --format %i | sort -u | paste -sd ' ')
[ -z "$busy" ] || fail "jobs of this dataset are queued or running ($busy); wait for them or scancel them first"
# What waited for an array that did not end well.
scancel --quiet --name "$name-collect" --name "$name-next" 2> /dev/null || true
for waiting in "$name-collect" "$name-next"; do
    ids=$(squeue --noheader --name "$waiting" --format %i)
    [ -z "$ids" ] || scancel $ids
done

status=$("$BIN/collect-samples" --splits "$OUT/splits.h5" --output "$OUT/fem.h5" --status --shard-count "$SHARDS")
echo "$status"
unfinished=$(sed -n 's/^unfinished *//p' <<< "$status")

# submit NAME OPTIONS... SCRIPT ARGUMENTS...: the number of the job.
submit() {
    local job=$1
    shift
    sbatch --parsable --job-name "$name-$job" --chdir "$PWD" --kill-on-invalid-dep=yes ${options[@]+"${options[@]}"} "$@" |
        cut -d ';' -f 1
}

after=()
if [ "$unfinished" != none ]; then
    array=$(submit fem --array "$unfinished${SLOTS:+%$SLOTS}" ${PARTITION:+--partition "$PARTITION"} --time "$TIME" \
        --cpus-per-task "$CPUS" --mem "$MEMORY" --requeue --signal B:USR1@120 --open-mode append \
        --output "$OUT/slurm/fem-%a.log" "$scripts/simulate.sbatch" "$BIN" "$CONFIG" "$OUT" "$SHARDS")
    echo "array       job $array, shards $unfinished of $SHARDS"
    after=(--dependency "afterok:$array")
fi
collect=$(submit collect ${after[@]+"${after[@]}"} ${PARTITION:+--partition "$PARTITION"} --time "$TIME" --mem "$MEMORY" \
    --output "$OUT/slurm/collect.log" "$scripts/collect.sbatch" "$BIN" "$CONFIG" "$OUT")
echo "collect     job $collect${after[1]:+, after the array}"
if [ -n "$NEXT" ]; then
    next=$(submit next --dependency "afterok:$collect" ${NEXT_PARTITION:+--partition "$NEXT_PARTITION"} \
        --time "$NEXT_TIME" --cpus-per-task "$NEXT_CPUS" --mem "$NEXT_MEMORY" ${next_options[@]+"${next_options[@]}"} \
        --output "$OUT/slurm/next.log" "$scripts/next.sbatch" "$NEXT")
    echo "next        job $next, after collect: $NEXT"
fi
