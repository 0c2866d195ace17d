#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The licences and credits of a body's data stand in everything that is written of it. credits.py BUILD"""
import os
import re
import struct
import subprocess
import sys
import tempfile
import zlib

import h5py  # Debian's python3-h5py

from dataset_files import Dataset, run

CREDITS = ["Anatomy: BodyParts3D, (c) The Database Center for Life Science, CC BY-SA 2.1 Japan", "Skin: a body of somebody, CC0 1.0"]
failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def texts_of_png(content):
    """Keyword and text of a PNG's text chunks."""
    at, found = 8, {}
    while at < len(content):
        length, kind = struct.unpack(">I4s", content[at:at + 8])
        data = content[at + 8:at + 8 + length]
        if kind == b"iTXt":
            keyword, rest = data.split(b"\0", 1)
            packed, rest = rest[0], rest[2:].split(b"\0", 2)[2]
            found[keyword.decode()] = (zlib.decompress(rest) if packed else rest).decode()
        elif kind == b"tEXt":
            keyword, text = data.split(b"\0", 1)
            found[keyword.decode()] = text.decode("latin-1")
        at += 12 + length
    return found


def readable(path):
    """All text of a file, whatever it is written with."""
    with open(path, "rb") as file:
        content = file.read()
    if content[:8] == b"\x89PNG\r\n\x1a\n":
        return "\n".join(texts_of_png(content).values())
    text = content.decode("latin-1")
    # As JSON, USD, XML and HTML write quotes, ends of lines and brackets.
    return re.sub(r"\\n|&#10;", "\n", text.replace("\\/", "/").replace("&amp;", "&"))


with tempfile.TemporaryDirectory(prefix="ndg-credits-") as folder:
    data = Dataset(sys.argv[1], folder, 9, 8)
    # Not in the template: bodies are bound to its hash, and carry its licences.
    for name, credits in (("bodies", CREDITS), ("poses", ["Motion: of somebody, CC BY 4.0"])):
        with h5py.File(f"{folder}/{name}.h5", "r+") as file:
            file.attrs["licences"] = "\n".join(credits)
    with h5py.File(f"{folder}/poses.h5") as file:
        motion = file.attrs["licences"]
    files = [part for name in ("template", "bodies", "poses") for part in (f"--{name}", f"{folder}/{name}.h5")]
    samples, space, model = (f"{folder}/{name}.h5" for name in ("samples", "space", "model"))
    torch = os.path.exists(data.bin + "/train-ndg")

    def tool(name, *arguments):
        return [f"{data.bin}/{name}", *arguments]

    # What is written, and by what. Earlier ones make what later ones read.
    scene = tool("export-scene", *files, "--deformations", samples, "--sample", "0")
    writers = [("samples.h5", [*data.simulate_command(samples)]),
               ("space.h5", tool("fit-shape-space", *files[:4], "--splits", data.splits, "--output", space)),
               ("statistical.h5", tool("fit-statistical-body", *files[:4], "--shape-space", space, "--output", f"{folder}/statistical.h5")),
               ("correctives.h5", tool("fit-correctives", *files, "--samples", samples, "--output", f"{folder}/correctives.h5"))]
    for name in ("scene.glb", "scene.obj", "scene.off", "scene.ply", "scene.stl", "scene.usda", "scene.xdmf", "scene.pc2"):
        writers.append((name, [*scene, "--mesh", f"{folder}/{name}"]))
    writers += [("rig.glb", tool("export-scene", *files, "--pose", "0", "--frames", "3", "--rig", "skinning", "--mesh", f"{folder}/rig.glb")),
                ("rig.usda", tool("export-scene", *files, "--pose", "0", "--frames", "3", "--rig", "skinning", "--mesh", f"{folder}/rig.usda")),
                ("page.html", [*scene, "--frames", "2", "--page", f"{folder}/page.html"]),
                ("picture.png", [*scene, "--height", "64", "--picture", f"{folder}/picture.png"]),
                ("video_00.png", tool("export-scene", *files, "--pose", "0", "--frames", "2", "--video-width", "64", "--video-height", "64",
                                      "--video", folder + "/video_{:02}.png")),
                ("video.webp", tool("export-scene", *files, "--pose", "0", "--frames", "2", "--video-width", "64", "--video-height", "64",
                                    "--video", f"{folder}/video.webp"))]
    if torch:
        writers += [("model.h5", tool("train-ndg", *files, "--samples", samples, "--shape-space", space, "--widths", "8", "--epochs", "1",
                                      "--output", model)),
                    ("model.pt", tool("export-network", "--model", model, "--template", f"{folder}/template.h5", "--output", f"{folder}/model.pt")),
                    ("model.ndg", tool("export-runtime", "--model", model, "--output", f"{folder}/model.ndg")),
                    ("model.safetensors", tool("export-release", "--model", model, "--safetensors", f"{folder}/model.safetensors")),
                    ("model.onnx", tool("export-release", "--model", model, "--onnx", f"{folder}/model.onnx")),
                    ("model.md", tool("export-release", "--model", model, "--model-card", f"{folder}/model.md"))]
    for name, command in writers:
        code, output = run(command)
        path = f"{folder}/{name}"
        if code != 0 or not os.path.exists(path):
            check(False, f"{name}: code {code}, {output[-300:]}")
            continue
        # Point caches, STL and videos have no room for text: it stands beside, without the number of a frame.
        beside = re.sub(r"_\d+\.", "_.", path) + ".licences.txt"
        found = readable(beside if os.path.exists(beside) else path)
        if name.endswith(".h5"):
            with h5py.File(path) as file:
                found = file.attrs["licences"]
        missing = [credit for credit in CREDITS if credit not in found]
        check(not missing, name + (f" lacks {missing}" if missing else ""))
        if name in ("scene.glb", "scene.usda", "scene.xdmf", "page.html"):
            check(motion in found, f"{name}: the motion's licence, too")
    for name in ("scene.glb", "scene.ply", "scene.obj"):
        told = subprocess.run(tool("ndg-info", f"{folder}/{name}"), stdout=subprocess.PIPE, text=True, check=False).stdout
        check(all(credit in told for credit in CREDITS), f"ndg-info tells the credits of {name}")

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
