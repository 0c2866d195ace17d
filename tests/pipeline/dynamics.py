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

from dataset_files import Dataset, as_motions, parts, run, same_dynamics

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


folder = tempfile.mkdtemp(prefix="ndg-dynamics-")
try:
    data = Dataset(sys.argv[1], folder, 9, 8)
    as_motions(folder + "/poses.h5", [13, 15])

    def command(output, *arguments, model="layered"):
        return [data.bin + "/simulate-dynamics", "--model", model, "--template", folder + "/template.h5", "--bodies",
                folder + "/bodies.h5", "--poses", folder + "/poses.h5", "--bone-wrap", "lbs", "--frames-per-block", "2",
                "--hold", "0.5", "--output", output, *arguments]

    contact_scene = folder + "/contact.json"
    seed = int(time.time())
    moments = random.Random(seed)
    whole, shards = folder + "/whole.h5", folder + "/shards.h5"
    for label, told in (("without contact", []), ("with contact", ["--scene", contact_scene, "--clip", "motion 0"])):
        undisturbed = whole if not told else folder + "/whole-contact.h5"
        if told:  # a ball that is thrown at the tube from the side: obstacles, friction and a body that gives way
            with h5py.File(whole, "r") as file:
                first = file["frames/vertices"][0]
            middle = [float(v) for v in first.mean(axis=0)]
            with open(contact_scene, "w") as file:
                json.dump({"obstacles": [{"name": "ball", "type": "sphere", "radius": 0.05, "edge": 0.05, "velocity": [-2, 0, 0],
                                          "position": [float(first[:, 0].max()) + 0.06, *middle[1:]],
                                          "free": True, "mass_kg": 0.3}]}, file)
        killed = undisturbed.replace("whole", "killed")
        start = time.time()
        code, text = run(command(undisturbed, "--threads", "1", *told))
        duration = time.time() - start
        print(text)
        check(code == 0 and os.path.exists(undisturbed), f"{label}: an undisturbed run ends with exit code 0 in {duration:.1f} s")
        counts = []
        for _ in range(10):
            process = subprocess.Popen(command(killed, "--threads", "2", *told), stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
            time.sleep(moments.uniform(0.05, duration / 4))
            process.kill()
            process.wait()
            counts.append(10 ** 6 if os.path.exists(killed) else len(parts(killed)))
        check(counts == sorted(counts) and counts[-1] > 0, f"{label}: ten times kill -9 (seed {seed}): parts after each {counts}")
        code, text = run(command(killed, "--threads", "2", *told))
        check(code == 0 and not parts(killed), f"{label}: then it ends, and leaves no parts")
        check(same_dynamics(undisturbed, killed), f"{label}: with the same frames, bit for bit")
        if told:
            check("ball inside skin, where skin gives way: no vertex in any frame" in text,
                  f"{label}: it is told that the ball never was inside")

    with h5py.File(whole, "r") as file:
        names = [name.decode() for name in file["sequences/names"][...]]
        begins = list(file["sequences/frame_begin"][...]) + [len(file["frames/times"])]
        vertices = file["frames/vertices"][...]
    check(names == ["motion 0", "motion 1"], f"motions {names}")
    for i in range(2):
        code, text = run(command(shards, "--shard", f"{i}/2"))
        check(code == 0, f"shard {i} of 2")
    with h5py.File(folder + "/shards.shards/0001-of-0002.h5", "r") as file:
        check(file["sequences/names"][0].decode() == "motion 1"
              and numpy.array_equal(file["frames/vertices"][...], vertices[begins[1]:]), "a shard's motion is that of the whole")

    code, text = run(command(shards, "--join", "2"))
    check(code == 0 and same_dynamics(whole, shards), "shards put together are the whole, bit for bit")
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
    inside = folder + "/inside.json"
    with open(inside, "w") as file:
        json.dump({"obstacles": [{"name": "stone", "type": "sphere", "radius": 0.05, "position": middle}]}, file)
    code, text = run(command(folder + "/none.h5", "--scene", inside))
    check(code == 2 and "stone" in text and "start" in text and text.count("error:") == 1 and not os.path.exists(folder + "/none.h5"),
          "a stone that starts inside the body: one error that names it")
    # Damaged inputs: what is wrong is named, and there is no output.
    for name, dataset, damage in (("poses.h5", "poses/rotations", lambda v: v.__setitem__((3, 2, 1), numpy.nan)),
                                  ("poses.h5", "poses/root_translations", lambda v: v.__setitem__((3, 2), numpy.nan)),
                                  ("bodies.h5", "bodies/volume_vertices", lambda v: v.__setitem__((0, 3, 1), numpy.nan)),
                                  ("poses.h5", "poses/clip_idx", None)):
        shutil.copy(f"{folder}/{name}", folder + "/kept.h5")
        with h5py.File(f"{folder}/{name}", "r+") as file:
            values = file[dataset][...]
            if damage is not None:
                damage(values)
                file[dataset][...] = values
            else:
                kind = file[dataset].dtype
                del file[dataset]
                file.create_dataset(dataset, data=values[:-1], dtype=kind)
        code, text = run(command(folder + "/none.h5", *(["--body", "0"] if name == "bodies.h5" else [])))
        what = "too few values" if damage is None else "not a number"
        check(code == 2 and dataset in text and text.count("error:") == 1 and not os.path.exists(folder + "/none.h5"),
              f"{name}, {dataset}: {what}: {text.strip().splitlines()[-1][:150]}")
        shutil.move(folder + "/kept.h5", f"{folder}/{name}")
    page = folder + "/page.html"
    code, text = run(command(whole, "--page", page))
    with open(page) as file:
        check(code == 0 and "NdgViewer.open" in file.read(), "a page of a finished run")
    code, text = run(command(folder + "/none.h5", model="soft-tissue"))
    check(code == 2 and "--avatar" in text, "soft tissue needs an avatar")
    code, text = run(command(whole, "--density", "900"))
    check(code == 2 and "--force" in text, "other options are not mixed with what is there")
finally:
    shutil.rmtree(folder)
sys.exit(1 if failures else 0)
