#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# plan.sh OUT EXPECTED [STAGE...]: shows the stages that a pipeline is going to run, with the seconds that EXPECTED (lines
# "stage seconds", of two quiet cores; may be missing) says of each, and writes OUT/plan, by which stage.sh tells how far
# a run is. Without stages: those of EXPECTED that OUT has not run. A plan that was shown before is not shown again.
set -eu
out=$1 expected=$2
shift 2
mkdir -p "$out"
if [ $# -eq 0 ] && [ -e "$expected" ]; then
    for stage in $(cut -d' ' -f1 "$expected"); do
        [ -e "$out/seconds/$stage" ] || set -- "$@" "$stage"
    done
fi
shown=$(sed 1d "$out/plan" 2> /dev/null || true)
{
    date +%s
    printf '%s\n' "$@" | awk -v expected="$expected" '
        BEGIN { while ((getline line < expected) > 0) { split(line, field, " "); seconds[field[1]] = field[2] } }
        NF { print $1, seconds[$1] + 0 }'
} > "$out/plan.tmp"
mv "$out/plan.tmp" "$out/plan"
: > "$out/plan.started"
[ $# -gt 0 ] && [ "$shown" != "$(sed 1d "$out/plan")" ] || exit 0
sed 1d "$out/plan" | awk '
    function clock(s) { return sprintf("%d:%02d", int(s / 60), int(s % 60)) }
    { name[NR] = $1; seconds[NR] = $2; total += $2 }
    END {
        printf "%d stages%s\n", NR, total ? ", about " clock(total) " min on two quiet cores:" : ":"
        for (i = 1; i <= NR; ++i) {
            expected = seconds[i] >= 1 ? sprintf("%7s", clock(seconds[i] + 0.5)) : total ? "      -" : ""
            printf "  %2d  %-20s%s\n", i, name[i], expected
        }
    }'
