#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""pipelines/slurm on a real Slurm of one node: an array with tasks killed in three ways, to a complete dataset.

slurm.py SOURCE BUILD; exits 77 (skipped) where Slurm cannot be started.
"""
import glob
import os
import shutil
import signal
import subprocess
import sys
import tempfile

from dataset_files import Dataset, difference, parts
from slurm_cluster import Cluster, shards_of, why_not

reason = why_not()
if reason:
    print("skipped: " + reason)
    sys.exit(77)

source, build = sys.argv[1], sys.argv[2]
failures = []
shards = 5


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def shard_file(index):
    return f"{out}/fem.shards/{index:04d}-of-{shards:04d}.h5"


def is_told_to_end(process):
    """Whether SIGTERM waits for a process that is held."""
    with open(f"/proc/{process}/status") as file:
        pending = next(line.split()[1] for line in file if line.startswith("ShdPnd"))
    return bool(int(pending, 16) >> (signal.SIGTERM - 1) & 1)


def log():
    text = ""
    for path in sorted(glob.glob(out + "/slurm/*.log")):
        with open(path) as file:
            text += f"--- {os.path.basename(path)}\n{file.read()[-2000:]}"
    return text


folder = tempfile.mkdtemp(prefix="ndg-slurm-")
os.chmod(folder, 0o755)
out = folder + "/set"
os.mkdir(out)
data = Dataset(build, out, 32, 28)
marker = out + "/after.txt"
with open(out + "/config.json", "w") as file:
    file.write('{"simulate-fem": {}}')
whole = folder + "/whole.h5"
cluster = Cluster(folder + "/slurm", cpus=4)
try:
    with cluster:
        cluster.environment.update({
            "OUT": out, "BIN": data.bin, "CONFIG": out + "/config.json", "SHARDS": str(shards), "MEMORY": "200M",
            "TIME": "00:10:00", "PARTITION": "test", "NEXT_MEMORY": "200M", "NEXT_CPUS": "1",
            "NEXT": f"{data.bin}/ndg-info {out}/fem.h5 > {marker}"})
        submit = source + "/pipelines/slurm/submit.sh"
        text = cluster.run(submit)
        print(text)
        array = next(line.split()[2].rstrip(",") for line in text.split("\n") if line.startswith("array"))
        check("shards 0,1,2,3,4 of 5" in text and "after the array" in text, "submit.sh: an array of 5, collect and next")
        again = subprocess.run([submit], env=cluster.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               text=True)
        check(again.returncode == 2 and "queued or running" in again.stdout, "a second submission at once is refused")

        # One task dies with its process, one is cancelled, one is told that its time is over: each is held still while it
        # is at work, so that none of them can end before.
        held = {}

        def all_held():
            for index, process in shards_of("simulate-fem", out + "/fem.h5").items():
                if index in (1, 2, 3) and index not in held and len(parts(shard_file(index))) >= 2:
                    os.kill(process, signal.SIGSTOP)
                    held[index] = process
            return len(held) == 3

        cluster.wait_for(all_held, "shards 1, 2 and 3 at work", poll=0.01)
        os.kill(held[1], signal.SIGKILL)
        cluster.run("scancel", f"{array}_2")
        cluster.run("scancel", "--batch", "--signal=USR1", f"{array}_3")
        cluster.wait_for(lambda: is_told_to_end(held[3]), "the signal to shard 3", poll=0.01)
        os.kill(held[3], signal.SIGCONT)
        at_work = sum(len(parts(shard_file(i))) + os.path.exists(shard_file(i)) for i in range(shards))
        check(at_work >= 6, "three tasks were stopped while they were at work")
        cluster.wait_for(lambda: not cluster.jobs(), "the first round", 300)
        done = [i for i in range(shards) if os.path.exists(shard_file(i))]
        check(done == [0, 3, 4], f"shards done after the first round: {done}; 3 went back into the queue and on")
        check("interrupted" in log() and "stand already" in log(), "shard 3 kept its samples")
        check(len(parts(shard_file(1))) >= 2 and len(parts(shard_file(2))) >= 2, "killed shards kept their samples")
        check(not os.path.exists(out + "/fem.h5") and not os.path.exists(marker),
              "nothing is joined and nothing follows while a shard is missing")

        before = {i: os.stat(shard_file(i)).st_mtime_ns for i in done}
        text = cluster.run(submit)
        print(text)
        check("shards 1,2 of 5" in text, "submitted again: only what is not finished")
        cluster.wait_for(lambda: not cluster.jobs(), "the second round", 300)
        check(before == {i: os.stat(shard_file(i)).st_mtime_ns for i in done}, "finished shards are left alone")
        check(os.path.exists(out + "/fem.h5") and os.path.exists(marker), "the dataset is joined, and what follows ran")
        with open(out + "/slurm/collect.log") as file:
            check("43 samples, 0 failed, 100.00 % converged" in file.read(), "collected and checked")
        text = cluster.run(submit)
        joined = os.stat(out + "/fem.h5").st_mtime_ns
        check("array" not in text and "unfinished  none" in text, "submitted a third time: no array")
        cluster.wait_for(lambda: not cluster.jobs(), "the third round", 300)
        check(os.stat(out + "/fem.h5").st_mtime_ns == joined, "and the dataset is not joined again")
    code, text = data.simulate(whole)
    check(code == 0 and os.path.exists(out + "/fem.h5") and difference(whole, out + "/fem.h5") == "",
          "the same samples, bit for bit, as an undisturbed run without Slurm")
    with open(marker) as file:
        check("ndg-deformations" in file.read(), "what followed saw the dataset")
except Exception as error:  # the logs tell more than the trace
    check(False, f"{type(error).__name__}: {error}")
finally:
    if failures:
        print(log() + cluster.logs())
    shutil.rmtree(folder, ignore_errors=True)

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
