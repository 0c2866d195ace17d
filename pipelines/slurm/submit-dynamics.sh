#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# submit-dynamics.sh: simulates motions with inertia as a Slurm job array, so many motions a task, and joins them after it.
# Given again it submits only the shards that are not finished, so it is also the way to resubmit.
#
# Environment: OUT (folder that gets dynamics.h5), BIN (the executables), CONFIG (JSON preset), POSES (the motions, each clip
# one), BODY (what moves: --avatar FILE, or --model layered --template FILE ...), SCENE (JSON; empty: none), RATE (frames a
# second), SHARDS (array tasks; at most as many as motions), and SLOTS, PARTITION, TIME, CPUS, MEMORY, SBATCH_OPTIONS and
# NEXT... as submit.sh has them.
set -eu
: "${OUT:?the folder of the results}" "${BIN:?the folder of the executables}" "${CONFIG:?the preset}" "${POSES:?the motions}"
: "${BODY:?what moves}"
. "$(dirname "$0")/jobs.sh"
mkdir -p "$OUT/slurm"
OUT=$(cd "$OUT" && pwd) BIN=$(cd "$BIN" && pwd) CONFIG=$(realpath "$CONFIG") POSES=$(realpath "$POSES")
read -ra body <<< "$BODY"
name_jobs "$OUT/dynamics" dynamics collect next

command=("$BIN/simulate-dynamics" --config "$CONFIG" "${body[@]}" --poses "$POSES" ${SCENE:+--scene "$(realpath "$SCENE")"}
    --frame-rate "${RATE:-30}" --output "$OUT/dynamics.h5")
unfinished=
for ((i = 0; i < SHARDS; ++i)); do
    [ -f "$OUT/dynamics.shards/$(printf '%04d-of-%04d' "$i" "$SHARDS").h5" ] || unfinished+=${unfinished:+,}$i
done
after=()
if [ -n "$unfinished" ]; then
    submit_array dynamics "$unfinished" "${command[@]}"
fi
collect=$(submit collect ${after[@]+"${after[@]}"} ${PARTITION:+--partition "$PARTITION"} --time "$TIME" --mem "$MEMORY" \
    --output "$OUT/slurm/collect.log" "$scripts/next.sbatch" "$(printf '%q ' "${command[@]}" --join "$SHARDS" --force)")
echo "collect     job $collect${after[1]:+, after the array}"
submit_next "$collect"
