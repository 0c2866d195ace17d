#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Samples whose bytes are damaged, and samples packed by a filter that is missing here, for every tool that reads them: one
line that names the file, exit code 2, nothing written. Many of them read in parallel. damaged_samples.py BUILD"""
import os
import shutil
import subprocess
import sys
import tempfile

import h5py  # Debian's python3-h5py

from dataset_files import Dataset, run

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def damage_bytes(path, dataset):
    """Turns bytes in the midst of every chunk."""
    with h5py.File(path) as file:
        item = file[dataset].id
        chunks = [item.get_chunk_info(i) for i in range(item.get_num_chunks())]
    with open(path, "r+b") as file:
        for chunk in chunks:
            file.seek(chunk.byte_offset + chunk.size // 2)
            byte = file.read(1)
            file.seek(-1, os.SEEK_CUR)
            file.write(bytes([byte[0] ^ 0xFF]))


def set_not_finite(path, dataset):
    with h5py.File(path, "r+") as file:
        file[dataset][:, 3] = float("nan")


def rename_filter(path, _):
    """Deflate is called 32015, which is Zstandard's number, wherever a dataset says that it is packed."""
    with open(path, "rb") as file:
        content = file.read()
    deflate, other = b"\x01\x00\x08\x00", b"\x0f\x7d\x08\x00"  # number, length of the name
    assert content.count(deflate + b"\x01\x00\x01\x00deflate\0"), "no dataset is packed"
    with open(path, "wb") as file:
        file.write(content.replace(deflate + b"\x01\x00\x01\x00deflate\0", other + b"\x01\x00\x01\x00deflate\0"))


with tempfile.TemporaryDirectory(prefix="ndg-damaged-") as folder:
    data = Dataset(sys.argv[1], folder, 9, 8)
    files = [part for name in ("template", "bodies", "poses") for part in (f"--{name}", f"{folder}/{name}.h5")]
    samples, space, model, gradients, damaged = (f"{folder}/{name}.h5" for name in ("samples", "space", "model", "gradients", "damaged"))
    torch = os.path.exists(data.bin + "/train-ndg")

    def tool(name, *arguments):
        return [f"{data.bin}/{name}", *arguments]

    train = tool("train-ndg", *files, "--shape-space", space, "--widths", "8", "--epochs", "1")
    commands = [data.simulate_command(samples),
                tool("fit-shape-space", *files[:4], "--splits", data.splits, "--output", space)]
    if torch:
        commands += [[*train, "--samples", samples, "--output", model],
                     tool("infer-ndg", *files, "--model", model, "--splits", data.splits, "--output", gradients)]
    for command in commands:
        code, text = run(command)
        check(code == 0, os.path.basename(command[0]) + (text if code else ""))

    output = folder + "/output"
    readers = [("ndg-info", tool("ndg-info", "--check", damaged)),
               ("collect-samples", tool("collect-samples", "--splits", data.splits, "--check", "--output", damaged)),
               ("fit-correctives", tool("fit-correctives", *files, "--samples", damaged, "--output", output)),
               ("evaluate-metrics", tool("evaluate-metrics", *files, "--splits", data.splits, "--reference", damaged, "--prediction",
                                         damaged, "--output", output)),
               ("measure-protrusion", tool("measure-protrusion", *files, "--splits", data.splits, "--deformations", damaged,
                                           "--output", output)),
               ("export-scene", tool("export-scene", *files, "--deformations", damaged, "--sample", "0", "--mesh", output + ".glb"))]
    if torch:
        readers.append(("train-ndg", [*train, "--samples", damaged, "--output", output]))
    kinds = [("damaged bytes", damage_bytes), ("numbers that are none", set_not_finite), ("a filter that is missing", rename_filter)]
    for kind, spoil in kinds:
        for name, command in readers:
            shutil.copy(samples, damaged)
            spoil(damaged, "deformations/vertices")
            done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
            errors = [line for line in done.stderr.splitlines() if "error:" in line or "terminate" in line]
            left = [n for n in os.listdir(folder) if n.startswith("output") and not n.endswith(".parts")]
            named = len(errors) == 1 and damaged in errors[0] and ("filter 32015" in errors[0] or kind != kinds[2][0])
            # --check tells every defect, which is its result.
            said = named or name == "collect-samples" and damaged in done.stderr + done.stdout
            check(done.returncode == 2 and said and not left,
                  f"{name}: {kind}" + ("" if done.returncode == 2 and said and not left else
                                       f": code {done.returncode}, {done.stderr[-400:]!r}, left {left}"))
    if torch:
        for kind, spoil in kinds[:1] + kinds[2:]:
            shutil.copy(gradients, damaged)
            with h5py.File(damaged) as file:
                names = []
                file.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) and item.chunks else None)
            spoil(damaged, max(names, key=lambda name: h5py.File(gradients)[name].size))
            done = subprocess.run(tool("reconstruct", *files, "--gradients", damaged, "--output", output), stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True)
            errors = [line for line in done.stderr.splitlines() if "error:" in line or "terminate" in line]
            check(done.returncode == 2 and len(errors) == 1 and damaged in errors[0] and not os.path.exists(output),
                  f"reconstruct: {kind} {done.stderr[-300:] if done.returncode != 2 else ''}")

print(f"{len(failures)} failures" if failures else "all checks hold")
sys.exit(1 if failures else 0)
