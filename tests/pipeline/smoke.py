#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The whole pipeline at smoke size, with numeric limits.

smoke.py SOURCE BUILD: the procedural body and the built-in motions, which need no data.
smoke.py SOURCE BUILD DATA: MakeHuman with real anatomy and captured motions; exits 77 (skipped) for an empty DATA.
"""
import glob
import json
import math
import os
import shutil
import struct
import subprocess
import sys
import tempfile

source, build = sys.argv[1], sys.argv[2]
data = sys.argv[3] if len(sys.argv) > 3 else None
if data == "":
    print("skipped: no data folder was given (DATA=)")
    sys.exit(77)
import h5py  # noqa: E402  (Debian's python3-h5py)
import numpy  # noqa: E402
from avatar import check_avatar  # noqa: E402

failures = []


def check(condition, text):
    print(("ok    " if condition else "FAIL  ") + text)
    if not condition:
        failures.append(text)


out = tempfile.mkdtemp(prefix="ndg-smoke-")
try:
    config = out + "/smoke.json"
    shutil.copy(source + "/configs/smoke.json", config)
    make = ["make", "-C", source, "PRESET=smoke", "CONFIG=" + config, "BUILD=" + os.path.abspath(build), "OUT=" + out,
            "DATA=" + (os.path.abspath(data) if data else "")]
    command = make + [out + "/report/tables.json", out + "/poses.png"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("MAKE") and k != "MFLAGS"}

    def made(targets):
        run = subprocess.run(make + targets, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
        print(run.stdout[-6000:])
        return run.returncode == 0

    check(made([out + "/model.h5"]), "the pipeline up to a network ends with exit code 0")

    # Another rate of learning trains anew and repeats nothing before.
    times = {name: os.stat(f"{out}/{name}.h5").st_mtime_ns for name in ("template", "poses", "fem", "model")}
    with open(config) as file:
        changed = json.load(file)
    changed["train-ndg"]["learning_rate"] = 0.0012
    with open(config, "w") as file:
        json.dump(changed, file)
    check(made([out + "/model.h5"]), "with other options for its training it does so too")
    repeated = {name for name, time in times.items() if os.stat(f"{out}/{name}.h5").st_mtime_ns != time}
    check(repeated == {"model"}, f"a change of one stage's options repeats that stage alone (repeated: {repeated})")

    check(made(command[len(make):]), "the rest of the pipeline ends with exit code 0")
    def results():
        return {path: os.stat(path).st_mtime_ns for ending in ("*.h5", "*.png", "report/*") for path in glob.glob(f"{out}/{ending}")}

    before = results()
    check(made(command[len(make):]) and results() == before and len(before) > 20, "a second run makes nothing anew")

    # The methods of the table; the two steps of a network's prediction give what it gives in one.
    def tool(name, *arguments):
        return subprocess.run([os.path.join(build, "bin", name), *arguments], stdout=subprocess.PIPE, text=True,
                              check=True).stdout

    methods = [m for m in tool("animate", "--list-methods").split() if m not in ("fem", "gradients", "rigid-parts", "runtime")]
    files = [f"--{name}={out}/{name}.h5" for name in ("template", "bodies", "poses")]
    tool("infer-ndg", *files, f"--model={out}/model.h5", f"--splits={out}/splits.h5", f"--output={out}/gradients.h5")
    tool("reconstruct", *files, f"--gradients={out}/gradients.h5", f"--output={out}/two-steps.h5",
         f"--anatomy={out}/anatomy.h5")
    with h5py.File(f"{out}/ndg.h5") as one, h5py.File(f"{out}/two-steps.h5") as two:
        check((one["deformations/vertices"][:] == two["deformations/vertices"][:]).all(),
              "infer-ndg and reconstruct give the vertices that animate gives")

    # libndg, from C and from Python, and the runtime as a method.
    exact = ("--last-layer=float32", "--hidden-layers=float32")
    tool("export-runtime", f"--model={out}/model.h5", *exact, f"--output={out}/exact.ndg")
    tool("export-runtime", f"--model={out}/model.h5", f"--output={out}/model.ndg")
    tool("animate", *files, f"--splits={out}/splits.h5", "--method=runtime", f"--runtime-model={out}/model.ndg",
         f"--output={out}/runtime.h5")
    tool("ndg-example", f"{out}/template.h5", f"{out}/bodies.h5", f"{out}/exact.ndg", f"{out}/elbow.obj")
    check(os.path.getsize(f"{out}/elbow.obj") > 10000, "the program in C writes a skin")
    sys.path.insert(0, source + "/docs/examples")
    import ndg_example
    example = [sys.executable, ndg_example.__file__, f"{build}/lib/libndg.so", *(f[f.index("=") + 1:] for f in files[:2]),
               f"{out}/exact.ndg"]
    check("femur" in subprocess.run(example, stdout=subprocess.PIPE, text=True).stdout.lower(), "the one in Python finds femurs")

    def quaternions(rotations):  # eigenvectors (Bar-Itzhack 2000), x, y, z, w
        m, k = rotations.reshape(-1, 3, 3), numpy.zeros((len(rotations), 4, 4))
        k[:, :3, :3] = m + m.transpose(0, 2, 1) - numpy.trace(m, axis1=1, axis2=2)[:, None, None] * numpy.eye(3)
        k[:, :3, 3] = k[:, 3, :3] = numpy.stack([m[:, 2, 1] - m[:, 1, 2], m[:, 0, 2] - m[:, 2, 0], m[:, 1, 0] - m[:, 0, 1]], 1)
        k[:, 3, 3] = numpy.trace(m, axis1=1, axis2=2)
        return numpy.linalg.eigh(k)[1][:, :, 3]

    runtime = ndg_example.Runtime(f"{build}/lib/libndg.so", f"{out}/template.h5", f"{out}/bodies.h5", f"{out}/exact.ndg")
    largest, largest_rounded, moved = 0.0, 0.0, 0.0
    rounding = numpy.random.default_rng(1)
    with h5py.File(f"{out}/ndg.h5") as ndg, h5py.File(f"{out}/anatomy.h5") as anatomy, h5py.File(f"{out}/poses.h5") as poses, \
            h5py.File(f"{out}/template.h5") as shared, h5py.File(f"{out}/runtime.h5") as rounded:
        wrap_to_skin = shared["volume/wrap_to_skin"][:]

        def difference(turns, shift, volume, bones_and_muscles):
            runtime.set_pose(turns, shift)
            wraps = (runtime.vertices(ndg_example.BONE_WRAP), runtime.vertices(ndg_example.MUSCLE_WRAP),
                     runtime.vertices(ndg_example.SKIN)[wrap_to_skin])
            return max(abs(numpy.concatenate(wraps) - volume).max(),
                       abs(runtime.vertices(ndg_example.ANATOMY) - bones_and_muscles).max())

        for i, (body, pose) in enumerate(ndg["deformations/pairs"][:]):
            runtime.set_body(int(body))
            turns, shift = quaternions(poses["poses/rotations"][pose]), poses["poses/root_translations"][pose]
            volume = ndg["deformations/vertices"][i]
            off = difference(turns, shift, volume, anatomy["anatomy/vertices"][i])
            # The bone wrap is pushed out from a tolerance on (bones/clearance.cpp), a step of tenths of a millimetre in what
            # poses do. Files hold rotations in single precision, so that quaternions of them may lie on its other side.
            for _ in range(200):
                if off >= 1e-5:
                    off = min(off, difference(turns + 3e-8 * rounding.standard_normal(turns.shape), shift, volume,
                                              anatomy["anatomy/vertices"][i]))
            largest = max(largest, off)
            largest_rounded = max(largest_rounded, abs(rounded["deformations/vertices"][i] - volume).max())
            moved = max(moved, abs(volume - shared["volume/vertices"][:]).max())
    check(largest < 1e-5 and moved > 0.1, f"libndg gives what animate and reconstruct give, to {1e3 * largest:.4f} mm")
    check(0 < largest_rounded < 2e-3, f"its weights in 8 bits move no vertex by more than {1e3 * largest_rounded:.2f} mm")

    check(os.path.getsize(f"{out}/model.png") > 1000, "the picture of the losses is there")

    # The network in Python: the same gradients, but for the rotations R_p that only the posed body knows.
    tool("export-network", f"--model={out}/model.h5", f"--template={out}/template.h5", f"--output={out}/model.pt")
    try:
        import torch
    except ImportError:
        print("skipped: TorchScript in Python needs python3-torch")
    else:
        extra = {"metadata.json": ""}
        network = torch.jit.load(f"{out}/model.pt", _extra_files=extra)
        with h5py.File(f"{out}/gradients.h5") as gradients, h5py.File(f"{out}/poses.h5") as poses, \
                h5py.File(f"{out}/bodies.h5") as bodies:
            pairs = gradients["gradients/pairs"][:]
            rotations = numpy.stack([poses["poses/rotations"][pose].reshape(-1, 3, 3) for _, pose in pairs])
            rest = numpy.stack([bodies["bodies/volume_vertices"][body] for body, _ in pairs])
            written = gradients["gradients/F"][:].reshape(len(pairs), -1, 3, 3)
        with torch.no_grad():
            residuals = network(torch.tensor(rotations, dtype=torch.float32), torch.tensor(rest, dtype=torch.float32))
        stretches = [numpy.einsum("spki,spkj->spij", f, f) for f in (written, residuals.numpy())]
        difference = abs(stretches[0] - stretches[1]).max()
        check(difference < 1e-3 and abs(stretches[0] - numpy.eye(3)).max() > 0.05,
              f"the network in Python stretches prisms as infer-ndg says (difference {difference:.1e})")
        check(len(json.loads(extra["metadata.json"])["joint_names"]) == rotations.shape[1], "its metadata name the joints")

    # One body in one pose, without splits, is the sample that the dataset has.
    with h5py.File(f"{out}/fem.h5") as samples:
        body, pose = samples["deformations/pairs"][0]
        stored = samples["deformations/vertices"][0]
    tool("simulate-fem", f"--config={source}/configs/smoke.json", *files, f"--body={body}", f"--pose={pose}",
         f"--output={out}/single.h5")
    with h5py.File(f"{out}/single.h5") as single:
        check((single["deformations/vertices"][0] == stored).all(), "simulate-fem --body gives the dataset's sample")

    # One scan: a layered body, and that body in a motion by the network.
    if data is None:
        scan, own = f"{out}/scan.obj", f"{out}/own"
        tool("export-scene", *files, f"--body={body}", "--surface=skin", f"--mesh={scan}")
        scanned = command[:6] + ["-o", "build", f"SCAN={scan}", f"OWN={own}", "METHOD=ndg", "FRAME_RATE=4", "body", "animate"]
        run = subprocess.run(scanned, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
        print(run.stdout[-3000:])
        check(run.returncode == 0, "make body and make animate end with exit code 0")
        with open(f"{own}/report.txt") as file:
            report = file.read()
        check("1 of 1 scans fitted, 1 pass" in report and "thoracic kyphosis" in report, "the report tells fit and measures")
        with h5py.File(f"{own}/squat/ndg.h5") as animation, open(f"{source}/configs/motions/squat.json") as motion:
            frames = int(4 * json.load(motion)["duration"] + 1e-6) + 1
            check(len(animation["deformations/vertices"]) == frames > 20, "every frame of the motion is there")
        for name in ("fit.png", "body.png", "section.png", "squat/ndg.html", "squat/ndg.png", "squat/ndg.obj", "squat/ndg.pc2"):
            check(os.path.getsize(f"{own}/{name}") > 1000, f"{name} is there")

    # Every file kind, by a reader that is not ours.
    kinds = {"template": "ndg-template", "skins": "ndg-skins", "bodies": "ndg-bodies", "motion": "ndg-poses",
             "poses": "ndg-poses", "splits": "ndg-splits", "fem": "ndg-deformations", "shape_space": "ndg-shape-space",
             "correctives": "ndg-correctives",
             "model": "ndg-model", "gradients": "ndg-gradients", "anatomy": "ndg-anatomy",
             **dict.fromkeys(methods, "ndg-deformations")}
    for name, kind in kinds.items():
        with h5py.File(f"{out}/{name}.h5", "r") as file:
            a = file.attrs
            text = {k: (v.decode() if isinstance(v, bytes) else v) for k, v in a.items()}
            ok = (text.get("format") == kind and int(text.get("format_version", 0)) >= 1 and text.get("units") == "m"
                  and text.get("up_axis") == "y" and "version" in json.loads(text["created_by"])
                  and isinstance(json.loads(text["config"]), dict))
            inputs = json.loads(text["inputs"])
            ok = ok and len(inputs) > 0 and all(len(i["sha256"]) == 64 and i["path"] for i in inputs)
            check(ok, f"{name}.h5: format, version, units, axes, tool, config and input hashes")

    with h5py.File(f"{out}/splits.h5") as splits, h5py.File(f"{out}/fem.h5") as fem, h5py.File(f"{out}/bodies.h5") as bodies:
        pairs = fem["deformations/pairs"][:]
        check(len({tuple(p) for p in pairs}) == len(pairs), "no pair twice")
        check(numpy.isfinite(fem["deformations/vertices"][:]).all(), "all vertices finite")
        for kind in ("bodies", "poses"):
            sets = [set(splits[f"splits/{s}/{kind}"][:].tolist()) for s in ("train", "validation", "test")]
            check(not (sets[0] & sets[1] or sets[0] & sets[2] or sets[1] & sets[2]), f"{kind} of the splits are disjoint")
        check(fem["statistics/converged"][:].min() == 1, "FEM converged on every sample")
        # Bone wraps are posed rigidly or by blending: nothing moves further than a body is tall.
        rest = bodies["bodies/volume_vertices"][:]
        check(abs(fem["deformations/vertices"][:]).max() < 3.0, "deformed bodies stay in place")
        check(rest[..., 1].min() > -0.01 and rest[..., 1].max() < 2.3, "rest bodies stand on the floor")

    with open(f"{out}/report/tables.json") as file:
        tables = json.load(file)
    table = tables["table1"]
    names = [h5py.File(f"{out}/{method}.h5").attrs["method"] for method in methods]
    check(list(table) == ["FEM", *names], f"Table 1 has FEM and the methods in order: {', '.join(names)}")
    for method, row in table.items():
        check(set(row) == {"E_pos_mm", "E_grad_e3", "E_inv", "E_corner", "E_vol_e3"} and all(math.isfinite(v) for v in row.values()),
              f"{method}: five finite figures")
    table3 = tables["table3"]
    check(list(table3) == ["FEM", *names], "Table 3 has FEM and the methods")
    check(all(0 <= row["protruding_frames"] <= 100 and row["protrusion_mm"] >= 0 for row in table3.values()), "shares are per cent")
    check(table3["NDG"]["protrusion_mm"] <= table3["LBS"]["protrusion_mm"], "NDG's anatomy sticks out no more than LBS's")
    with open(f"{out}/report/index.html") as file:
        page = file.read()
    check("<svg" in page and "://" not in page and page.count("<img") == page.count('src="data:image/png;base64,') >= 4,
          "the page holds its pictures itself")
    check(tables["seconds"]["simulate-fem"] > 0, "seconds of the stages are there")

    # The run has the figures that are expected of it; with a network that has learnt nothing it has not.
    expectations = f"{source}/configs/expectations/smoke{'-anatomy' if data else ''}.json"

    def broken_expectations(tables_path):
        run = subprocess.run([os.path.join(build, "bin", "check-results"), "--tables", tables_path, "--expectations", expectations],
                             stdout=subprocess.PIPE, text=True)
        print(run.stdout)
        return run.returncode, [line for line in run.stdout.splitlines() if line.startswith("FAIL")]

    check(broken_expectations(f"{out}/report/tables.json") == (0, []), "the run has the figures that are expected of it")
    run = subprocess.run(make + ["-o", "build", "check-results", "EXPECTATIONS=" + expectations], stdout=subprocess.DEVNULL, env=environment)
    check(run.returncode == 0, "make check-results ends with exit code 0")

    check_avatar(make, environment, out, build, check)

    def zero_network(name, path):
        shutil.copy(f"{out}/{name}", path)
        with h5py.File(path, "r+") as file:
            for layer, values in file["network"].items():
                for weights in values.values() if layer.startswith("layer_") else []:
                    weights[...] = 0

    def train_one_step(name, path):
        kind = [] if name == "model.h5" else ["--output-space=vertex-offsets", "--output-basis=680"]
        tool("train-ndg", f"--config={source}/configs/smoke.json", *files, f"--samples={out}/fem.h5",
             f"--shape-space={out}/shape_space.h5", "--epochs=1", *kind, f"--output={path}")

    for untrained in (zero_network, train_one_step):
        label, predictions = untrained.__name__, []
        for method, name in (("ndg", "model.h5"), ("vertexnet", "vertexnet-model.h5")):
            untrained(name, f"{out}/{label}-{name}")
            predictions.append(f"--prediction={out}/{label}-{method}.h5")
            tool("animate", *files, f"--method={method}", f"--model={out}/{label}-{name}", f"--splits={out}/splits.h5",
                 f"--output={out}/{label}-{method}.h5")
        predictions += [f"--prediction={out}/{method}.h5" for method in methods if method not in ("ndg", "vertexnet")]
        tool("evaluate-metrics", *files, f"--splits={out}/splits.h5", f"--reference={out}/fem.h5", *predictions,
             f"--output={out}/{label}/tables.json")
        code, broken = broken_expectations(f"{out}/{label}/tables.json")
        check(code == 3, f"{label}: check-results ends with exit code 3")
        for method in ("NDG", "VertexNet"):
            check(any(f"{method} has" in line for line in broken), f"{label}: what is expected of {method} does not hold")

    for name in ("report/layers", "report/cut", "report/bodies", "report/frames", "report/errors", "poses"):
        with open(f"{out}/{name}.png", "rb") as file:
            head = file.read(24)
        width, height = struct.unpack(">II", head[16:24])
        check(head[:8] == b"\x89PNG\r\n\x1a\n" and width > 200 and height > 200, f"{name}.png is a picture")
    with open(f"{out}/report/posed.glb", "rb") as file:
        magic, version, _, length, kind = struct.unpack("<4sIII4s", file.read(20))
        nodes = {n.get("name") for n in json.loads(file.read(length))["nodes"]}
    check(os.path.getsize(f"{out}/report/page.html") > 500000, "the page is there")
    if not data:  # tests/viewer looks at it in a browser
        shutil.copy(f"{out}/report/page.html", f"{build}/page.html")
        shutil.copy(f"{out}/report/motion.glb", f"{build}/motion.glb")
        shutil.rmtree(f"{build}/smoke", ignore_errors=True)  # what animate.py and body_batches.py take
        os.mkdir(f"{build}/smoke")
        for name in ("template.h5", "bodies.h5", "model.h5", "vertexnet-model.h5", "correctives.h5", "model.ndg"):
            shutil.copy(f"{out}/{name}", f"{build}/smoke/{name}")
    check(magic == b"glTF" and version == 2 and {"skin", "muscle_wrap", "bone_wrap"} <= nodes, f"posed.glb has nodes {sorted(nodes)}")
finally:
    shutil.rmtree(out, ignore_errors=True)

print(f"{len(failures)} checks failed" if failures else "all checks hold")
sys.exit(1 if failures else 0)
