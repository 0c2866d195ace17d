#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# run-benches.sh BIN NAME OUT: runs bench_NAME (or every benchmark for "all"); each writes OUT/NAME.json.
set -eu
bin=$1 name=$2 out=$3
mkdir -p "$out"
if [ "$name" = all ]; then
    names=$(cd "$bin" && ls | sed -n 's/^bench_//p')
else
    names=$name
fi
for bench in $names; do
    if [ ! -x "$bin/bench_$bench" ]; then
        echo "there is no benchmark '$bench'; known: $(cd "$bin" && ls | sed -n 's/^bench_//p' | tr '\n' ' ')" >&2
        exit 2
    fi
    "$bin/bench_$bench" --output "$out/$bench.json" --force
done
