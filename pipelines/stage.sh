#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# stage.sh OUT STAGE COMMAND...: runs one stage of a pipeline, shows its command and time, and stores the seconds in
# OUT/seconds/STAGE for the report. With NDG_PLAN (plan.sh) it also tells how far the run is.
set -eu
out=$1 stage=$2
shift 2
mkdir -p "$out/seconds"
plan=${NDG_PLAN:-}
# progress WHICH: "start" or "end" of this stage. The time to go is what the plan says, times what the stages so far took
# beside what it said of them.
progress() {
    awk -v which="$1" -v stage="$stage" -v now="$(date +%s)" -v folder="$out/seconds" '
        function clock(s) { return sprintf("%d:%02d", int(s / 60), int(s % 60)) }
        FILENAME == ARGV[1] { started[$1] = 1; ++count; next }
        FNR == 1 { begin = $1; next }
        { ++stages; total += $2; if ($1 == stage) about = $2
          if (($1 in started) && ($1 != stage || which == "end")) {
              file = folder "/" $1; took = 0; getline took < file; close(file); done += $2; spent += took } }
        END {
            pace = done > 10 ? spent / done : 1
            expected = about >= 1 ? " (about " clock(about * pace + 0.5) ")" : ""
            if (which == "start") printf "%d of %d, %s%s", count, stages, stage, expected
            else if (total) printf "; %s since the start, about %s to go", clock(now - begin), clock((total - done) * pace + 0.5)
        }' "$plan.started" "$plan"
}
label=$stage
if [ -e "$plan" ]; then
    echo "$stage" >> "$plan.started"
    label=$(progress start)
fi
echo "== $label: $(basename "$1") ${*:2}"
start=$(date +%s.%N)
"$@"
end=$(date +%s.%N)
awk -v a="$start" -v b="$end" 'BEGIN { printf "%.2f\n", b - a }' > "$out/seconds/$stage.tmp"
mv "$out/seconds/$stage.tmp" "$out/seconds/$stage"
echo "   $stage took $(cat "$out/seconds/$stage") s$([ -e "$plan" ] && progress end)"
