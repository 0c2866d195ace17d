#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""pipelines/slurm/submit-dynamics.sh on a real Slurm of one node: motions as an array, one task killed, to the frames of an
undisturbed run.

slurm_dynamics.py SOURCE BUILD; exits 77 (skipped) where Slurm cannot be started.
"""
import glob
import os
import shutil
import signal
import sys
import tempfile

from dataset_files import Dataset, as_motions, parts, run, same_dynamics
from slurm_cluster import Cluster, shards_of, why_not

reason = why_not()
if reason:
    print("skipped: " + reason)
    sys.exit(77)

source, build = sys.argv[1], sys.argv[2]
failures = []
shards = 3


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def shard_file(index):
    return f"{out}/dynamics.shards/{index:04d}-of-{shards:04d}.h5"


folder = tempfile.mkdtemp(prefix="ndg-slurm-dynamics-")
os.chmod(folder, 0o755)
out = folder + "/set"
os.mkdir(out)
data = Dataset(build, folder, 20, 16)
as_motions(folder + "/poses.h5", [9, 9, 9])
marker = folder + "/after.txt"
with open(folder + "/config.json", "w") as file:
    file.write('{"simulate-dynamics": {"frames_per_block": 2, "hold": 0.3}}')
body = f"--model layered --template {folder}/template.h5 --bodies {folder}/bodies.h5 --bone-wrap lbs"
cluster = Cluster(folder + "/slurm", cpus=2)
try:
    with cluster:
        cluster.environment.update({
            "OUT": out, "BIN": data.bin, "CONFIG": folder + "/config.json", "POSES": folder + "/poses.h5", "BODY": body,
            "SHARDS": str(shards), "MEMORY": "200M", "TIME": "00:10:00", "PARTITION": "test", "NEXT_MEMORY": "200M",
            "NEXT_CPUS": "1", "NEXT": f"{data.bin}/ndg-info {out}/dynamics.h5 > {marker}"})
        submit = source + "/pipelines/slurm/submit-dynamics.sh"
        text = cluster.run(submit)
        print(text)
        check("shards 0,1,2 of 3" in text and "after the array" in text, "submit-dynamics.sh: an array of 3, and what follows")
        held = {}

        def is_held():
            for index, process in shards_of("simulate-dynamics", out + "/dynamics.h5").items():
                if index == 1 and index not in held and len(parts(shard_file(1))) >= 1:
                    os.kill(process, signal.SIGSTOP)
                    held[index] = process
            return 1 in held

        cluster.wait_for(is_held, "shard 1 at work", 120, poll=0.01)
        os.kill(held[1], signal.SIGKILL)
        cluster.wait_for(lambda: not cluster.jobs(), "the first round", 300)
        check([os.path.exists(shard_file(i)) for i in range(shards)] == [True, False, True], "the killed shard is missing")
        check(not os.path.exists(out + "/dynamics.h5") and not os.path.exists(marker), "nothing is joined and nothing follows")
        kept = len(parts(shard_file(1)))
        text = cluster.run(submit)
        print(text)
        check("shards 1 of 3" in text and kept >= 1, f"submitted again: only what is not finished; {kept} parts of it stand")
        cluster.wait_for(lambda: not cluster.jobs(), "the second round", 300)
        check(os.path.exists(out + "/dynamics.h5") and os.path.exists(marker), "the motions are joined, and what follows ran")
    whole = folder + "/whole.h5"
    code, text = run([data.bin + "/simulate-dynamics", "--config", folder + "/config.json", *body.split(), "--poses",
                      folder + "/poses.h5", "--frame-rate", "30", "--output", whole])
    check(code == 0 and same_dynamics(whole, out + "/dynamics.h5"), "the same frames, bit for bit, as without Slurm")
except Exception as error:  # the logs tell more than the trace
    check(False, f"{type(error).__name__}: {error}")
finally:
    if failures:
        for path in sorted(glob.glob(out + "/slurm/*.log")):
            with open(path) as file:
                print(f"--- {os.path.basename(path)}\n{file.read()[-2000:]}")
        print(cluster.logs())
    shutil.rmtree(folder, ignore_errors=True)

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
