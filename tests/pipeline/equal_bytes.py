#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Equal inputs, config and seed give equal files, byte for byte, but for those that say how long the work took. Every tool
that a small dataset can be given runs twice, the second time with another number of threads. equal_bytes.py BUILD"""
import os
import sys
import tempfile

import h5py  # Debian's python3-h5py
import numpy

from dataset_files import Dataset, run

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def content(path):
    with open(path, "rb") as file:
        return file.read()


def differing_items(one, other):
    """Names of datasets and attributes that differ."""
    found = []
    with h5py.File(one) as a, h5py.File(other) as b:
        def compare(name, item):
            if name not in b:
                found.append(name)
            elif isinstance(item, h5py.Dataset) and not numpy.array_equal(item[...], b[name][...]):
                found.append(name)
        a.visititems(compare)
        found += ["@" + name for name in a.attrs if str(a.attrs[name]) != str(b.attrs.get(name))]
    return found


with tempfile.TemporaryDirectory(prefix="ndg-bytes-") as folder:
    data = Dataset(sys.argv[1], folder, 9, 8)
    source = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
    files = [part for name in ("template", "bodies", "poses") for part in (f"--{name}", f"{folder}/{name}.h5")]
    samples, space, model, lbs = (f"{folder}/{name}.h5" for name in ("samples", "space", "model", "lbs"))
    torch = os.path.exists(data.bin + "/train-ndg")

    def tool(name, *arguments):
        return [f"{data.bin}/{name}", *arguments]

    # Command and output; whether threads may be as many as one likes; whether it tells its time.
    scene = tool("export-scene", *files, "--deformations", samples, "--sample", "0")
    writers = [(data.simulate_command(samples)[:-2], samples, True, True),
               (tool("import-motion", "--template", f"{folder}/template.h5", "--motion", f"{source}/configs/motions/squat.json"),
                f"{folder}/motion.h5", True, False),
               (tool("sample-poses", "--template", f"{folder}/template.h5", "--poses", f"{folder}/poses.h5", "--count", "9"),
                f"{folder}/few.h5", True, False),
               (tool("fit-shape-space", *files[:4], "--splits", data.splits), space, True, False),
               (tool("fit-statistical-body", *files[:4], "--shape-space", space), f"{folder}/statistical.h5", True, False),
               (tool("fit-correctives", *files, "--samples", samples), f"{folder}/correctives.h5", False, False)]
    if torch:
        writers += [(tool("train-ndg", *files, "--samples", samples, "--shape-space", space, "--widths", "8", "--epochs", "2"), model, False, False),
                    (tool("animate", *files, "--splits", data.splits, "--split", "test", "--method", "lbs"), lbs, True, False),
                    (tool("export-network", "--model", model, "--template", f"{folder}/template.h5"), f"{folder}/model.pt", True, False),
                    (tool("export-runtime", "--model", model), f"{folder}/model.ndg", True, False)]
    for flag, name in [("--mesh", f"scene.{extension}") for extension in ("glb", "obj", "ply", "stl", "off", "pc2", "usda")] + [
            ("--page", "page.html"), ("--picture", "picture.png")]:
        writers.append(([*scene, "--height", "64", flag], f"{folder}/{name}", True, False))
    os.mkdir(folder + "/again")
    for command, output, any_threads, tells_time in writers:
        if command[-1] not in ("--mesh", "--page", "--picture"):
            command = [*command, "--output"]
        extension = os.path.splitext(output)[1]
        again = f"{folder}/again/{os.path.basename(output)}"
        for target, threads in ((output, "1"), (again, "2" if any_threads else "1")):
            code, text = run([command[0], "--threads", threads, *command[1:], target])
            if code not in (0, 3):
                check(False, f"{os.path.basename(command[0])}: code {code}, {text[-300:]}")
        if not (os.path.exists(output) and os.path.exists(again)):
            continue
        label = f"{os.path.basename(command[0])}: {os.path.basename(output)}"
        same = content(output) == content(again)
        items = [] if same or extension != ".h5" else differing_items(output, again)
        if tells_time:
            check(same or items and all("seconds" in item for item in items), f"{label} differs at most in its seconds {items}")
        else:
            check(same, f"{label} is the same{'' if same else f', but differs in {items}'}")

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
