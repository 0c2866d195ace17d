#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writers on a disk that fills up, and where nothing may be written: one line, exit code 1, where nothing may be written
2, nothing left behind.

    full_disks.py BUILD SOURCE SMOKE [--writers NAME...]

A full disk is a limit of the size of files, a third and nine tenths of what the tool writes. SOURCE: the source folder.
SMOKE: the results of a run of make (out/smoke)."""
import argparse
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "pipeline"))
from dataset_files import Dataset, run


READ_BY_OTHERS = ("simulate-fem", "fit-shape-space", "sample-bodies", "simulate-scans", "train-ndg", "animate")


def limited(most_bytes):
    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, most_bytes))
    return limit


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build")
    parser.add_argument("source")
    parser.add_argument("smoke")
    parser.add_argument("--writers", nargs="*", help="only these, and what they read")
    options = parser.parse_args()
    build, source, smoke = options.build, os.path.abspath(options.source), options.smoke
    failed = False
    with tempfile.TemporaryDirectory(prefix="ndg-disks-") as folder:
        data = Dataset(build, folder)
        tool = lambda name: f"{data.bin}/{name}"
        files = [part for name in ("template", "bodies", "poses") for part in (f"--{name}", f"{folder}/{name}.h5")]
        samples, space, model, runtime, skins = (f"{folder}/{name}" for name in
                                                 ("samples.h5", "space.h5", "model.h5", "model.ndg", "few-skins.h5"))
        motion = f"{source}/configs/motions/squat.json"
        train = [tool("train-ndg"), *files, "--samples", samples, "--shape-space", space, "--widths", "32", "--epochs", "2"]
        # Name, command, flag of the output, its extension. Earlier ones make what later ones read.
        writers = [
            ("simulate-fem", data.simulate_command(samples)[:-2], "--output", samples),
            ("fit-shape-space", [tool("fit-shape-space"), *files[:4], "--splits", data.splits], "--output", space),
            ("sample-poses", [tool("sample-poses"), "--poses", f"{smoke}/motion.h5", "--template", f"{smoke}/template.h5",
                              "--count", "30"], "--output", f"{folder}/some-poses.h5"),
            ("make-splits", [tool("make-splits"), "--template", f"{smoke}/template.h5", "--bodies", f"{smoke}/bodies.h5", "--poses",
                             f"{smoke}/poses.h5", "--train-pairs", "8", "--validation-pairs", "2", "--test-pairs", "2"],
             "--output", f"{folder}/more-splits.h5"),
            ("sample-bodies", [tool("sample-bodies"), "--template", f"{smoke}/template.h5", "--count", "4"], "--output", skins),
            ("build-layers", [tool("build-layers"), "--template", f"{smoke}/template.h5", "--skins", skins, "--keep-outside"],
             "--output", f"{folder}/layers.h5"),
            ("simulate-scans", [tool("simulate-scans"), "--template", f"{smoke}/template.h5", "--skins", skins, "--count", "1",
                                "--scans", f"{folder}/scans"], "--output", f"{folder}/truth.h5"),
            ("fit-body", [tool("fit-body"), "--template", f"{smoke}/template.h5", "--scan", f"{folder}/scans", "--rounds", "1",
                          "--iterations", "1", "--max-points", "2000", "--keep-failed", "--min-passed", "0"],
             "--output", f"{folder}/fitted.h5"),
            ("make-template", [tool("make-template"), "--prisms", "4000", "--examples", "0"], "--output", f"{folder}/tiny.h5"),
            ("simulate-dynamics", [tool("simulate-dynamics"), "--model", "layered", *files, "--bone-wrap", "lbs",
                                   "--frames-per-block", "2"], "--output", f"{folder}/dynamics.h5"),
            ("fit-correctives", [tool("fit-correctives"), *files, "--samples", samples], "--output", f"{folder}/correctives.h5"),
            ("train-ndg", train, "--output", model),
            ("train-ndg's checkpoint", [*train, "--checkpoint-seconds", "0"], "--output", f"{folder}/third.h5"),
            ("export-runtime", [tool("export-runtime"), "--model", model], "--output", runtime),
            ("export-network", [tool("export-network"), "--template", f"{folder}/template.h5", "--model", model], "--output", f"{folder}/model.pt"),
            ("export-release .safetensors", [tool("export-release"), "--model", model], "--safetensors", f"{folder}/model.safetensors"),
            ("export-release .onnx", [tool("export-release"), "--model", model], "--onnx", f"{folder}/model.onnx"),
            ("infer-ndg", [tool("infer-ndg"), *files, "--model", model, "--splits", data.splits], "--output", f"{folder}/gradients.h5"),
            ("animate", [tool("animate"), *files, "--splits", data.splits, "--split", "test", "--method", "lbs"], "--output", f"{folder}/lbs.h5"),
            ("fit-statistical-body", [tool("fit-statistical-body"), *files[:4], "--shape-space", space], "--output", f"{folder}/statistical.h5"),
            ("evaluate-metrics", [tool("evaluate-metrics"), *files, "--splits", data.splits, "--reference", samples, "--prediction", f"{folder}/lbs.h5"], "--output", f"{folder}/tables.json"),
        ]
        for extension in ("glb", "obj", "ply", "pc2", "usda", "xdmf"):
            writers.append((f"export-scene .{extension}", [tool("export-scene"), *files, "--deformations", samples, "--sample", "0"],
                            "--mesh", f"{folder}/scene.{extension}"))
        for flag, name in (("--picture", "scene.png"), ("--page", "scene.html")):
            writers.append((f"export-scene {flag}", [tool("export-scene"), *files, "--deformations", samples, "--sample", "0"], flag, f"{folder}/{name}"))
        writers.append(("import-motion", [tool("import-motion"), "--template", f"{folder}/template.h5", "--motion", motion], "--output", f"{folder}/motion.h5"))
        print("| writer | bytes | third | nine tenths | forbidden folder |\n|---|---|---|---|---|")
        for name, command, flag, output in writers:
            chosen = not options.writers or name in options.writers
            if not chosen and name not in READ_BY_OTHERS:
                continue
            code, text = run([*command, flag, output])
            if not chosen:
                continue
            if code not in (0, 3) or not os.path.exists(output):
                print(f"| {name} | WRONG: {text.strip()[-160:]!r} | | | |", flush=True)
                failed = True
                continue
            size = os.path.getsize(output)
            outcomes = []
            for share in (1 / 3, 0.9):
                inside = pathlib.Path(folder) / "limited"
                inside.mkdir()
                target = inside / os.path.basename(output)
                done = subprocess.run([*command, flag, str(target)], capture_output=True, text=True, check=False,
                                      preexec_fn=limited(max(int(size * share), 64)))
                errors = [line for line in done.stderr.splitlines() if "error:" in line]
                left = sorted(path.name for path in inside.rglob("*") if path.is_file())
                # Finished samples of a resumable run stay for the next try.
                left = [item for item in left if not any(p.name.endswith(".parts") for p in inside.iterdir())]
                fine = done.returncode == 1 and len(errors) == 1 and not left
                outcomes.append(f"code {done.returncode}, one line" if fine else f"WRONG: {done.returncode}, {errors}, left {left}")
                subprocess.run(["rm", "-r", str(inside)], check=True)
            done = subprocess.run([*command, flag, "/proc/" + os.path.basename(output)], capture_output=True, text=True, check=False)
            errors = [line for line in done.stderr.splitlines() if "error:" in line]
            fine = done.returncode == 2 and len(errors) == 1
            outcomes.append("code 2, one line" if fine else f"WRONG: {done.returncode}, {errors}")
            failed |= any("WRONG" in outcome for outcome in outcomes)
            print(f"| {name} | {size} | " + " | ".join(outcomes) + " |", flush=True)
    sys.exit(1 if failed else 0)


if __name__ == "__main__":
    main()
