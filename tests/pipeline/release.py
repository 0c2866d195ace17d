#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What export-release writes of networks, read by numpy alone, against the model files and infer-ndg.

release.py SOURCE BUILD: networks of all kinds, trained for two epochs on a small dataset.
release.py SOURCE BUILD MODEL TEMPLATE BODIES POSES SPLITS: a network that is there.
"""
import json
import os
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy

from network_files import Onnx, exponential, raw_outputs, read_safetensors

build = os.path.abspath(sys.argv[2])
given = [os.path.abspath(path) for path in sys.argv[3:]]
failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text, flush=True)
    if not condition:
        failures.append(text)


def tool(name, *arguments):
    run = subprocess.run([f"{build}/bin/{name}", *arguments], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if run.returncode != 0:
        print(run.stdout[-2000:])
    return run.returncode, run.stdout


def look_at(label, model, template, bodies, poses, splits, folder, *options):
    """Everything written of one model, and its prediction of some poses."""
    out = f"{folder}/{label}"
    os.makedirs(out)
    code, _ = tool("export-release", f"--model={model}", f"--data={template}", f"--data={bodies}", f"--safetensors={out}/m.safetensors",
                   f"--config-json={out}/config.json", f"--onnx={out}/m.onnx", f"--model-card={out}/README.md",
                   f"--dataset-card={out}/dataset.md", *options)
    check(code == 0, f"{label}: export-release ends with exit code 0")
    tensors, metadata = read_safetensors(f"{out}/m.safetensors")
    with open(f"{out}/config.json") as file:
        config = json.load(file)
    with h5py.File(model) as file:
        stored = {}
        file.visititems(lambda name, item: stored.update({name: item[()]}) if isinstance(item, h5py.Dataset) and item.dtype.kind in "fi"
                        else None)
        same = set(tensors) == {name.replace("/", ".") for name in stored} and all(
            tensors[name.replace("/", ".")].tobytes() == values.tobytes() and tensors[name.replace("/", ".")].shape == values.shape
            for name, values in stored.items())
        check(same, f"{label}: {len(tensors)} tensors of safetensors are those of the model file, bit for bit")
        licences = file.attrs["licences"]
        check(metadata["licences"] == licences and config["licences"] == licences, f"{label}: the licences travel with them")

    # Of the first poses: what numpy makes of the tensors, what the graph of ONNX gives, and what infer-ndg says.
    with h5py.File(splits) as file:
        pairs = file["splits/test/pairs"][:12]
    with h5py.File(bodies) as file, h5py.File(poses) as pose_file:
        rest = numpy.stack([file["bodies/volume_vertices"][body].astype(float) for body, _ in pairs])
        rotations = numpy.stack([pose_file["poses/rotations"][pose].astype(float).reshape(-1, 3, 3) for _, pose in pairs])
    codes = (rest.reshape(len(rest), -1) - tensors["shape_space.mean"]) @ tensors["shape_space.components"]
    expected = raw_outputs(tensors, config, rotations, codes)
    onnx = Onnx(f"{out}/m.onnx")
    inputs = {"parent_from_joint": rotations}
    if config["sees_shape"]:
        inputs["shape_code"] = codes
    given = onnx.run(**inputs)
    size, error = abs(expected).max(), abs(given["outputs"] - expected).max()
    check(size > 1e-4 and error < 2e-5 * max(1, size), f"{label}: ONNX gives the outputs that the tensors give ({error:.1e} of {size:.2f})")
    try:
        import onnx as reference
        reference.checker.check_model(f"{out}/m.onnx", full_check=True)
        print(f"ok    {label}: the checker of ONNX {reference.__version__} accepts the file")
    except ImportError:
        print("skipped: ONNX's own checker needs python3-onnx")
    if config["output_space"] == "vertex-offsets":
        check(abs(given["offsets"].reshape(len(pairs), -1) - 0.001 * expected).max() < 1e-7, f"{label}: offsets are metres")
        return onnx
    if config["parametrisation"] not in ("exponential", "direct"):
        check(onnx.outputs == ["outputs"], f"{label}: the graph says no more than it knows")
        return onnx
    matrices = expected.reshape(len(pairs), -1, 3, 3)
    residuals = exponential(matrices) if config["parametrisation"] == "exponential" else numpy.eye(3) + matrices
    error = abs(given["residuals"] - residuals).max()
    check(error < 2e-6, f"{label}: residuals of ONNX are those of double precision (difference {error:.1e})")
    code, _ = tool("infer-ndg", f"--model={model}", f"--template={template}", f"--bodies={bodies}", f"--poses={poses}",
                   f"--splits={splits}", f"--bone-wrap={config['bone_wrap']}", f"--output={out}/gradients.h5")
    with h5py.File(f"{out}/gradients.h5") as file:
        stored_pairs = [tuple(pair) for pair in file["gradients/pairs"][:]]
        written = numpy.stack([file["gradients/F"][stored_pairs.index(tuple(pair))] for pair in pairs]).reshape(matrices.shape)
    # infer-ndg has turned them by R_p, which only the posed body knows: a rotation, one for each prism and pose.
    turns = written @ numpy.linalg.inv(given["residuals"].astype(float))
    error = abs(turns @ turns.transpose(0, 1, 3, 2) - numpy.eye(3)).max()
    check(error < 1e-4 and (numpy.linalg.det(turns) > 0).all(), f"{label}: infer-ndg's gradients are rotations times them ({error:.1e})")
    if config["rotation"]:
        by_pose = {}
        for i, (_, pose) in enumerate(pairs):
            by_pose.setdefault(pose, []).append(turns[i])
        check(all(abs(t - ts[0]).max() < 1e-3 for ts in by_pose.values() for t in ts), f"{label}: the same ones for all bodies in a pose")
    check(abs(given["residuals"] - numpy.eye(3)).max() > 1e-3, f"{label}: the network predicts something")
    return onnx


folder = tempfile.mkdtemp(prefix="ndg-release-")
try:
    if given:
        look_at("given", *given, folder)
    else:
        subprocess.run([f"{build}/bin/small-dataset", folder, "9", "8"], check=True)
        names = [f"{folder}/{name}.h5" for name in ("template", "bodies", "poses", "splits")]
        files = [f"--{name}={folder}/{name}.h5" for name in ("template", "bodies", "poses")]
        tool("fit-shape-space", *files[:2], f"--splits={folder}/splits.h5", f"--output={folder}/shape_space.h5")
        tool("simulate-fem", *files, f"--splits={folder}/splits.h5", "--bone-wrap=lbs", f"--output={folder}/fem.h5")
        credit = "Anatomy: a licence that asks for credit"
        kinds = {"plain": [], "basis": ["--parametrisation=direct", "--output-basis=8"], "no-shape": ["--no-shape"], "lu": ["--parametrisation=lu"],
                 "regional": ["--region-reach=1"], "regional-basis": ["--region-reach=1", "--parametrisation=direct", "--output-basis=6"],
                 "vertices": ["--output-space=vertex-offsets", "--output-basis=8"]}
        for label, options in kinds.items():
            code, _ = tool("train-ndg", *files, f"--samples={folder}/fem.h5", f"--shape-space={folder}/shape_space.h5", "--widths=32,24",
                           "--epochs=4", "--no-mirror", "--splice=0", *options, f"--output={folder}/{label}.h5")
            check(code == 0, f"{label}: trained")
            with h5py.File(f"{folder}/{label}.h5", "r+") as file:
                file.attrs["licences"] = credit
            # 1 kB a constant: every matrix in pieces.
            pieces = ["--max-constant-mb=0.001"] if label in ("plain", "basis", "regional-basis") else []
            onnx = look_at(label, f"{folder}/{label}.h5", *names, folder, *pieces)
            if pieces:
                check(all(c.nbytes <= 1000 or len(c) == 1 for c in onnx.constants.values() if c.ndim == 2)
                      and any(n[0] == "Concat" for n in onnx.nodes), f"{label}: no matrix is larger than was asked for, or than a row")

        # The licence goes into the networks of other forms, too.
        tool("export-runtime", f"--model={folder}/plain.h5", f"--output={folder}/plain.ndg")
        tool("export-network", f"--model={folder}/plain.h5", f"--template={folder}/template.h5", f"--output={folder}/plain.pt")
        for name in ("plain.ndg", "plain.pt", "plain/m.safetensors"):
            code, text = tool("ndg-info", f"{folder}/{name}", "--check") if name != "plain/m.safetensors" else tool("ndg-info", f"{folder}/{name}")
            check(code == 0 and credit in text, f"ndg-info explains {name}, whose licence is the model's")
        check(credit.encode() in open(f"{folder}/plain/m.onnx", "rb").read(), "so is that of m.onnx")
        check(all(credit in open(f"{folder}/plain/{name}").read() for name in ("README.md", "config.json")), "and that of the cards")

        # The cards tell what a person must know; a damaged model gives one line.
        with open(f"{folder}/plain/README.md") as file:
            card = file.read()
        check(all(part in card for part in ("Not evaluated", "residuals", "Licences", "Limits", "train-ndg 0.")), "the model's card is whole")
        with open(f"{folder}/plain/dataset.md") as file:
            card = file.read()
        check("a template" in card and "layered bodies" in card, "the card of the data tells of every file")
        with open(f"{folder}/plain.h5", "r+b") as file:
            file.truncate(os.path.getsize(f"{folder}/plain.h5") // 2)
        code, text = tool("export-release", f"--model={folder}/plain.h5", f"--onnx={folder}/x.onnx")
        check(code == 2 and text.count("\n") == 1 and not os.path.exists(f"{folder}/x.onnx"), f"a damaged model is refused: {text.strip()}")
        code, text = tool("export-release", f"--model={folder}/plain.h5")
        check(code == 2 and "--onnx" in text, "a release of nothing is refused")
finally:
    shutil.rmtree(folder)
print(f"{len(failures)} failures")
sys.exit(1 if failures else 0)
