#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""simulate-dynamics as a process: killed at any moment it goes on to the same bits; shards; what it refuses. dynamics.py BUILD"""
import json
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

import h5py  # Debian's python3-h5py
import numpy

from dataset_files import Dataset, parts, run

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def same(one, other):
    """Datasets alike bit for bit, timings apart."""
    def datasets(path):
        found = {}
        with h5py.File(path, "r") as file:
            file.visititems(lambda name, item: found.update({name: item[...]}) if isinstance(item, h5py.Dataset) else None)
        found.pop("statistics/seconds")
        return found
    left, right = datasets(one), datasets(other)
    return set(left) == set(right) and all(numpy.array_equal(left[name], right[name]) for name in left)


folder = tempfile.mkdtemp(prefix="ndg-dynamics-")
try:
    data = Dataset(sys.argv[1], folder, 9, 8)
    with h5py.File(folder + "/poses.h5", "r+") as file:  # two motions
        count = len(file["poses/clip_idx"])
        file["poses/clip_idx"][...] = [0 if i < 13 else 1 for i in range(count)]
        file["poses/frame_idx"][...] = [i if i < 13 else i - 13 for i in range(count)]
        for name, values in (("names", ["one", "two"]), ("frame_rates", [30.0, 30.0])):
            kind = file["clips/" + name].dtype
            del file["clips/" + name]
            file.create_dataset("clips/" + name, data=values, dtype=kind)

    def command(output, *arguments, model="layered"):
        return [data.bin + "/simulate-dynamics", "--model", model, "--template", folder + "/template.h5", "--bodies",
                folder + "/bodies.h5", "--poses", folder + "/poses.h5", "--bone-wrap", "lbs", "--frames-per-block", "2",
                "--hold", "0.5", "--output", output, *arguments]

    whole, killed, shards = (f"{folder}/{name}.h5" for name in ("whole", "killed", "shards"))
    start = time.time()
    code, text = run(command(whole, "--threads", "1"))
    duration = time.time() - start
    print(text)
    check(code == 0 and os.path.exists(whole), f"an undisturbed run ends with exit code 0 in {duration:.1f} s")
    seed = int(time.time())
    moments = random.Random(seed)
    counts = []
    for _ in range(6):
        process = subprocess.Popen(command(killed, "--threads", "2"), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        time.sleep(moments.uniform(0.05, duration / 3))
        process.kill()
        process.wait()
        counts.append(10 ** 6 if os.path.exists(killed) else len(parts(killed)))
    check(counts == sorted(counts) and counts[-1] > 0, f"six times kill -9 (seed {seed}): parts after each {counts}")
    code, text = run(command(killed, "--threads", "2"))
    check(code == 0 and not parts(killed), "then it ends, and leaves no parts")
    check(same(whole, killed), "with the same frames, bit for bit")

    with h5py.File(whole, "r") as file:
        names = [name.decode() for name in file["sequences/names"][...]]
        begins = list(file["sequences/frame_begin"][...]) + [len(file["frames/times"])]
        vertices = file["frames/vertices"][...]
    check(names == ["one", "two"], f"motions {names}")
    for i in range(2):
        code, text = run(command(shards, "--shard", f"{i}/2"))
        check(code == 0, f"shard {i} of 2")
    with h5py.File(folder + "/shards.shards/0001-of-0002.h5", "r") as file:
        check(file["sequences/names"][0].decode() == "two"
              and numpy.array_equal(file["frames/vertices"][...], vertices[begins[1]:]), "a shard's motion is that of the whole")

    code, text = run(command(shards, "--join", "2"))
    check(code == 0 and same(whole, shards), "shards put together are the whole, bit for bit")
    os.rename(folder + "/shards.shards/0000-of-0002.h5", folder + "/lost.h5")
    code, text = run(command(shards, "--join", "2", "--force"))
    check(code == 2 and "0000-of-0002" in text, "a shard that is lost is named")

    scene = folder + "/scene.json"
    with open(scene, "w") as file:
        json.dump({"gravity": True}, file)
    heavy = folder + "/heavy.h5"
    code, text = run(command(heavy, "--scene", scene, "--clip", names[0], "--mesh", folder + "/heavy.glb"))
    check(code == 0 and os.path.getsize(folder + "/heavy.glb") > 1000, "with gravity, shown as glTF")
    with h5py.File(heavy, "r") as file:
        sunk = (file["frames/vertices"][begins[1] - 1] - vertices[begins[1] - 1]).mean(axis=0)
    check(sunk[1] < -1e-5, f"flesh sinks under gravity: {1e3 * sunk[1]:.3f} mm on average")
    code, text = run([data.bin + "/ndg-info", "--check", heavy])
    check(code == 0 and "layered" in text and "1, " in text and "complete and finite" in text, "ndg-info explains and checks it")
    # A box far away, in a file that the scene names: another box is another run.
    boxed, box_scene, box = folder + "/boxed.h5", folder + "/box.json", folder + "/box.obj"
    with open(box_scene, "w") as file:
        json.dump({"obstacles": [{"name": "box", "type": "mesh", "file": "box.obj", "position": [5, 0, 0]}]}, file)
    for size, expected in ((1, 0), (1, 0), (2, 2)):
        with open(box, "w") as file:
            file.write("".join(f"v {x * size} {y * size} {z * size}\n" for x, y, z in ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))))
            file.write("f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
        code, text = run(command(boxed, "--scene", box_scene, "--clip", names[0]))
        check(code == expected and (code == 0 or "other inputs" in text), f"with a box of {size} m in a file: exit code {code}")
    for arguments, words in ((("--frame-rate", "50"), "does not divide"), (("--clip", "no such"), "no motion"),
                             (("--body", "99"), "--body 99")):
        code, text = run(command(folder + "/none.h5", *arguments))
        check(code == 2 and words in text and not os.path.exists(folder + "/none.h5"), f"{' '.join(arguments)}: {words}")
    code, text = run(command(folder + "/none.h5", model="soft-tissue"))
    check(code == 2 and "--avatar" in text, "soft tissue needs an avatar")
    code, text = run(command(whole, "--density", "900"))
    check(code == 2 and "--force" in text, "other options are not mixed with what is there")
finally:
    shutil.rmtree(folder)
sys.exit(1 if failures else 0)
