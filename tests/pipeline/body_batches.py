#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Batches of bodies through interruptions: build-layers and fit-body as processes. body_batches.py BUILD"""
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import h5py  # Debian's python3-h5py
import numpy

from dataset_files import differing_dataset, parts, run

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def holder(output):
    """Number of the process that is, or was last, at the parts of an output."""
    try:
        with open(f"{output}.parts/process") as file:
            return int((file.read().split() or [0])[0])
    except FileNotFoundError:
        return 0


def check_batch(name, command, other_option):
    """`command(output)` makes one file of several items."""
    whole, killed = f"{folder}/{name}-whole.h5", f"{folder}/{name}-killed.h5"
    start = time.time()
    code, text = run(command(whole, "--threads", "1"))
    duration = time.time() - start
    check(code == 0 and not os.path.exists(whole + ".parts"), f"{name}: an undisturbed run in {duration:.1f} s" +
          (text if code else ""))

    def start_one():
        return subprocess.Popen(command(killed, "--threads", "1"), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    seed = int(time.time())
    moments = random.Random(seed)
    counts = []
    for _ in range(3):
        process = start_one()
        time.sleep(moments.uniform(0.1, 0.4) * duration)
        process.kill()
        process.wait()
        counts.append(len(parts(killed)) if not os.path.exists(killed) else 1000)
    check(counts == sorted(counts), f"{name}: three times kill -9 (seed {seed}): parts after each {counts}")
    # Held still as soon as it is at work and an item is finished, so that it is not over before the next command.
    process = start_one()
    while process.poll() is None and not (holder(killed) == process.pid and parts(killed)):
        time.sleep(0.002)
    process.send_signal(signal.SIGSTOP)
    code, text = run(command(killed))
    check(code == 2 and f"process {process.pid}" in text and text.count("error:") == 1,
          f"{name}: a second process at the same output is refused, naming the first")
    process.kill()
    process.wait()
    kept = sorted(parts(killed))
    code, text = run(command(killed, *other_option))
    check(code == 2 and "other options" in text and sorted(parts(killed)) == kept,
          f"{name}: parts of other options are neither used nor thrown away")
    path = f"{killed}.parts/{kept[0]}"
    os.truncate(path, os.path.getsize(path) // 2)
    code, text = run(command(killed, "--threads", "2"))
    check(code == 0 and text.count("made again") == 1 and differing_dataset(whole, killed) == "",
          f"{name}: resumed to the same file, the truncated part made again " + (text if code else ""))
    left = [n for n in os.listdir(folder) if n.endswith(".tmp") or n.endswith(".parts")]
    check(left == [], f"{name}: nothing of the killed runs is left {left}")


folder = tempfile.mkdtemp(prefix="ndg-bodies-")
try:
    tool = os.path.join(os.path.abspath(sys.argv[1]), "bin") + "/"
    template, skins, scans = folder + "/template.h5", folder + "/skins.h5", folder + "/scans"
    scanned = folder + "/scanned.h5"
    made, maker = os.path.abspath(sys.argv[1]) + "/smoke/template.h5", tool + "make-template"
    if os.path.exists(made) and os.path.getmtime(made) > os.path.getmtime(maker):
        shutil.copy(made, template)  # the smoke run's
    else:
        code, text = run([maker, "--prisms", "4000", "--output", template])
        check(code == 0, "make-template" + (text if code else ""))
    for command in (["sample-bodies", "--template", template, "--count", "16", "--output", skins],
                    ["sample-bodies", "--template", template, "--count", "4", "--output", scanned],
                    ["simulate-scans", "--template", template, "--skins", scanned, "--scans", scans,
                     "--people", folder + "/people.json", "--output", folder + "/truth.h5"]):
        code, text = run([tool + command[0], *command[1:]])
        check(code == 0, command[0] + (text if code else ""))

    check_batch("build-layers", lambda output, *arguments: [
        tool + "build-layers", "--template", template, "--skins", skins, "--keep-outside", "--output", output, *arguments],
        ["--smoothness", "0.5"])
    # A body whose shoulder joints are too near to each other is named and left out, or kept when asked.
    spoilt, output = folder + "/spoilt.h5", folder + "/inside.h5"
    shutil.copy(skins, spoilt)
    with h5py.File(template) as file:
        joints = [name.decode() for name in file["skeleton/joint_names"]]
    with h5py.File(spoilt, "r+") as file:
        positions = file["bodies/joint_positions"]
        apart = positions[0, joints.index("left_upper_arm"), 0] * 2 / numpy.ptp(file["bodies/skin_vertices"][0, :, 1])
        for side in ("left", "right"):
            positions[0, joints.index(side + "_upper_arm"), 0] *= 0.175 / apart
    command = [tool + "build-layers", "--template", template, "--skins", spoilt, "--output", output, "--force"]
    code, text = run(command + ["--keep-outside"])
    with h5py.File(output) as file:
        check(code == 0 and len(file["bodies/names"]) == 16 and "shoulder joints apart: 0.175, allowed 0.180 to" in text,
              "build-layers --keep-outside: all are written, the spoilt one is named" + (text if code else ""))
    outside = [line.split()[1] for line in text.splitlines() if " is outside: " in line]
    code, text = run(command)
    names = [name.decode() for name in h5py.File(output)["bodies/names"]] if len(outside) < 16 and os.path.exists(output) else []
    check(code == 3 and not set(names) & set(outside) and len(names) + len(outside) == 16,
          f"build-layers: {len(outside)} bodies outside of published ranges are left out, exit code {code}")
    check_batch("fit-body", lambda output, *arguments: [
        tool + "fit-body", "--template", template, "--scan", scans, "--rounds", "1", "--iterations", "4",
        "--max-points", "2000", "--keep-failed", "--min-passed", "0", "--output", output, *arguments],
        ["--armpit-radius", "0.07"])
finally:
    shutil.rmtree(folder, ignore_errors=True)

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
