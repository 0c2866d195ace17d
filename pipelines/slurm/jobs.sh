# SPDX-License-Identifier: Apache-2.0
# jobs.sh: what the scripts that submit arrays share; sourced by them. Takes SHARDS, SLOTS, PARTITION, TIME, CPUS, MEMORY,
# SBATCH_OPTIONS and NEXT... from the environment, and OUT, the folder of what is made.
SHARDS=${SHARDS:-16} SLOTS=${SLOTS:-} PARTITION=${PARTITION:-} TIME=${TIME:-04:00:00} CPUS=${CPUS:-1} MEMORY=${MEMORY:-2G}
NEXT=${NEXT:-} NEXT_PARTITION=${NEXT_PARTITION:-$PARTITION} NEXT_TIME=${NEXT_TIME:-12:00:00} NEXT_CPUS=${NEXT_CPUS:-4}
NEXT_MEMORY=${NEXT_MEMORY:-8G}
read -ra options <<< "${SBATCH_OPTIONS:-}"
read -ra next_options <<< "${NEXT_OPTIONS:-}"
scripts=$(cd "$(dirname "$0")" && pwd)

fail() { echo "$(basename "$0"): error: $*" >&2; exit 2; }
command -v sbatch > /dev/null || fail "there is no sbatch here; run this where jobs are submitted"

# name_jobs PATH ARRAY FOLLOWING...: the name, made of a path, that tells these jobs from those of others. Ends where an
# array of that name is under way; cancels what waited for one that did not end well.
name_jobs() {
    name=ndg-$(printf %s "$1" | md5sum | cut -c 1-8)
    local busy waiting ids
    busy=$(squeue --noheader --name "$name-$2" --format %i | sort -u | paste -sd ' ')
    [ -z "$busy" ] || fail "jobs of this dataset are queued or running ($busy); wait for them or scancel them first"
    for waiting in "${@:3}"; do
        scancel --quiet --name "$name-$waiting" 2> /dev/null || true
        ids=$(squeue --noheader --name "$name-$waiting" --format %i)
        [ -z "$ids" ] || scancel $ids
    done
}

# submit NAME OPTIONS... SCRIPT ARGUMENTS...: the number of the job.
submit() {
    local job=$1
    shift
    sbatch --parsable --job-name "$name-$job" --chdir "$PWD" --kill-on-invalid-dep=yes ${options[@]+"${options[@]}"} "$@" |
        cut -d ';' -f 1
}

# submit_array NAME UNFINISHED COMMAND...: an array of the shards that are not finished; sets `after` to what waits for it.
submit_array() {
    local job=$1 unfinished=$2 array
    shift 2
    array=$(submit "$job" --array "$unfinished${SLOTS:+%$SLOTS}" ${PARTITION:+--partition "$PARTITION"} --time "$TIME" \
        --cpus-per-task "$CPUS" --mem "$MEMORY" --requeue --signal B:USR1@120 --open-mode append \
        --output "$OUT/slurm/$job-%a.log" "$scripts/shard.sbatch" "$SHARDS" "$@")
    echo "array       job $array, shards $unfinished of $SHARDS"
    after=(--dependency "afterok:$array")
}

# submit_next JOB: what follows that job, if anything.
submit_next() {
    [ -n "$NEXT" ] || return 0
    local next
    next=$(submit next --dependency "afterok:$1" ${NEXT_PARTITION:+--partition "$NEXT_PARTITION"} \
        --time "$NEXT_TIME" --cpus-per-task "$NEXT_CPUS" --mem "$NEXT_MEMORY" ${next_options[@]+"${next_options[@]}"} \
        --output "$OUT/slurm/next.log" "$scripts/next.sbatch" "$NEXT")
    echo "next        job $next, after collect: $NEXT"
}
