#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# stage.sh OUT STAGE COMMAND...: runs one stage of a pipeline, shows its command and time, and stores the seconds in
# OUT/seconds/STAGE for the report.
set -eu
out=$1 stage=$2
shift 2
mkdir -p "$out/seconds"
echo "== $stage: $(basename "$1") ${*:2}"
start=$(date +%s.%N)
"$@"
end=$(date +%s.%N)
awk -v a="$start" -v b="$end" 'BEGIN { printf "%.2f\n", b - a }' > "$out/seconds/$stage.tmp"
mv "$out/seconds/$stage.tmp" "$out/seconds/$stage"
echo "   $stage took $(cat "$out/seconds/$stage") s"
