#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Datasets through interruptions: simulate-fem and collect-samples as processes.

datasets.py BUILD [FOLDER]: with template.h5, bodies.h5, poses.h5 and splits.h5 of FOLDER instead of a small dataset.
"""
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from dataset_files import Dataset, difference, parts, run

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def no_room():
    """No file larger than 6 kB: writing fails as on a full disk, whoever runs this."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (6000, 6000))


def errors(text):
    return [line for line in text.split("\n") if "error:" in line]


folder = tempfile.mkdtemp(prefix="ndg-datasets-")
try:
    data = Dataset(sys.argv[1], os.path.abspath(sys.argv[2]) if len(sys.argv) > 2 else folder)
    whole = folder + "/whole.h5"
    start = time.time()
    code, text = data.simulate(whole, "--threads", "1")
    duration = time.time() - start
    check(code == 0 and os.path.exists(whole), f"an undisturbed run ends with exit code 0 in {duration:.1f} s")

    # kill -9 at ten moments, then once more when the last sample is stored.
    killed = folder + "/killed.h5"
    seed = int(time.time())
    moments = random.Random(seed)
    counts = []
    for _ in range(10):
        process = subprocess.Popen(data.simulate_command(killed, "--threads", "2"), stderr=subprocess.DEVNULL)
        time.sleep(moments.uniform(0.02, duration / 5))
        process.kill()
        process.wait()
        counts.append(data.samples if os.path.exists(killed) else len(parts(killed)))
    check(counts == sorted(counts), f"ten times kill -9 (seed {seed}): samples stored after each {counts}")
    process = subprocess.Popen(data.simulate_command(killed, "--threads", "2"), stderr=subprocess.DEVNULL)
    while process.poll() is None and len(parts(killed)) < data.samples:
        time.sleep(0.002)
    process.kill()
    process.wait()
    code, text = data.simulate(killed, "--threads", "2")
    check(code == 0 and difference(whole, killed) == "", "resumed: the same samples bit for bit " +
          (difference(whole, killed) if os.path.exists(killed) else text))
    left = [name for name in os.listdir(folder) if name.endswith(".tmp") or name.endswith(".parts")]
    check(left == [], f"nothing of the killed runs is left {left}")
    code, text = data.simulate(killed, "--min-converged", "0.5")
    check(code == 0 and "holds all" in text, "the same command again finds nothing to do")

    # Polite signals.
    for polite in (signal.SIGTERM, signal.SIGINT):
        stopped = folder + f"/stopped{int(polite)}.h5"
        process = subprocess.Popen(data.simulate_command(stopped, "--threads", "2"), stderr=subprocess.PIPE, text=True)
        while len(parts(stopped)) < 5:
            time.sleep(0.005)
        before = len(parts(stopped))
        process.send_signal(polite)
        _, text = process.communicate()
        after = len(parts(stopped))
        check(process.returncode == 75 and after >= before and len(errors(text)) <= 1 and "same command" in text,
              f"{polite.name}: exit code 75, {before} samples stored at the signal, {after} at the end")
        half_done = [name for name in os.listdir(stopped + ".parts") if name.endswith(".tmp")]
        check(half_done == [], f"{polite.name}: no half sample is left")
        code, text = data.simulate(stopped)
        check(code == 0 and difference(whole, stopped) == "", f"{polite.name}: resumed to the same samples")

    # A part that was cut off, and two processes at the same work.
    cut = folder + "/cut.h5"
    process = subprocess.Popen(data.simulate_command(cut, "--threads", "1"), stderr=subprocess.DEVNULL)
    while len(parts(cut)) < 8:
        time.sleep(0.005)
    code, text = data.simulate(cut)
    check(code == 2 and f"process {process.pid}" in text and len(errors(text)) == 1,
          "a second process at the same output is refused, naming the first")
    code, text = data.collect(cut, "--status")
    check(code == 0 and "running     0/1" in text and "/s, " in text and "left" in text, "status of a running dataset:")
    print(text)
    process.kill()
    process.wait()
    for name in sorted(parts(cut))[:2]:
        path = f"{cut}.parts/{name}"
        os.truncate(path, os.path.getsize(path) // 2)
    code, text = data.simulate(cut)
    check(code == 0 and text.count("made again") == 2 and difference(whole, cut) == "",
          "truncated parts are simulated again")

    # Seven processes, a shard each, two at a time.
    sharded = folder + "/seven/fem.h5"
    os.mkdir(folder + "/seven")
    processes = []
    for i in range(7):
        if len(processes) >= 2:
            processes[-2].wait()
        processes.append(subprocess.Popen(data.simulate_command(sharded, "--shard", f"{i}/7", "--threads", "1"),
                                          stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
    check([p.wait() for p in processes] == [0] * 7, "seven shards by processes side by side")
    code, text = data.collect(sharded, "--status")
    check(code == 0 and f"{data.samples} of {data.samples} done" in text and "7 complete" in text and "unfinished  none" in text, "status")
    code, text = data.collect(sharded)
    check(code == 0 and difference(whole, sharded) == "", "1 shard and 7 shards give the same samples")
    shutil.move(folder + "/seven", folder + "/moved")
    sharded = folder + "/moved/fem.h5"
    code, text = data.collect(sharded, "--check")
    check(code == 0 and difference(whole, sharded) == "", "the dataset can be moved; --check finds no defect")
    with open(folder + "/moved/fem.shards/0003-of-0007.h5", "r+b") as file:
        file.seek(os.path.getsize(file.name) // 2)
        file.write(b"noise" * 200)
    code, text = data.collect(sharded, "--check")
    check(code == 2 and "0003-of-0007.h5 is not the file that was merged" in text, "--check names a damaged shard")
    os.remove(folder + "/moved/fem.shards/0003-of-0007.h5")
    code, text = data.collect(sharded, "--check")
    check(code == 2 and "0003-of-0007.h5, which does not exist" in text and len(errors(text)) == 1,
          "--check names a lost shard")
    code, text = run([data.bin + "/ndg-info", "--check", sharded])
    check(code == 2 and "not finite" in text, "ndg-info --check refuses a dataset that lost a shard")

    # Convergence below the gate.
    loose = folder + "/loose.h5"
    code, text = data.simulate(loose, "--max-iterations", "2", "--load-steps", "0")
    check(code == 3 and "did not converge" in text and len(errors(text)) == 1 and os.path.exists(loose),
          "too few converged samples: exit code 3, and the samples are kept")
    code, text = data.collect(loose, "--check")
    check(code == 3, "--check has the same gate")
    code, text = data.simulate(loose, "--replay", "4", "--max-iterations", "2", "--load-steps", "0")
    check(code == 0 and "bit for bit" in text and "limit of iterations" in text, "an unconverged sample is replayed:")
    print(text)

    # No room, no folder.
    full = folder + "/full.h5"
    code, text = data.simulate(full, preexec_fn=no_room, restore_signals=False)
    check(code == 1 and len(errors(text)) == 1 and full in text and not os.path.exists(full),
          "a full disk gives one error: " + "".join(errors(text)))
    code, text = data.simulate(full)
    check(code == 0 and difference(whole, full) == "", "and once there is room, the same command goes on")
    code, text = data.simulate(data.splits + "/fem.h5")
    check(code == 2 and len(errors(text)) == 1, "a folder that cannot be made gives one error: " + "".join(errors(text)))
    open(folder + "/blocked.h5.parts", "w").close()
    code, text = data.simulate(folder + "/blocked.h5")
    check(code == 2 and len(errors(text)) == 1, "nor can the folder of parts: " + "".join(errors(text)))
finally:
    shutil.rmtree(folder, ignore_errors=True)

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
