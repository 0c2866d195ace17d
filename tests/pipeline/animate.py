#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""animate from motion files, against the same in steps. animate.py SOURCE BUILD FOLDER: with template.h5, bodies.h5 and whatever
models stand in the folder, as smoke.py leaves one; exits 77 (skipped) where there is none."""
import json
import math
import os
import subprocess
import sys
import tempfile

import h5py
import numpy

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from dataset_files import differing_dataset  # noqa: E402

# Joint, parent, offset in centimetres: a T pose in the names of configs/joint-maps/cmu-bvh.json.
RIG = [("Hips", None, (0, 0, 0)), ("LowerBack", "Hips", (0, 8, 0)), ("Spine", "LowerBack", (0, 12, 0)), ("Spine1", "Spine", (0, 14, 0)),
       ("Neck", "Spine1", (0, 14, 0)), ("Neck1", "Neck", (0, 5, 1)), ("Head", "Neck1", (0, 5, 1))]
for side, x in (("Left", 1), ("Right", -1)):
    RIG += [(side + name, parent if parent in ("Spine1", "Hips") else side + parent, (x * a, b, c)) for name, parent, (a, b, c) in (
        ("Shoulder", "Spine1", (3, 12, 1)), ("Arm", "Shoulder", (14, 0, -2)), ("ForeArm", "Arm", (29, 0, 0)), ("Hand", "ForeArm", (26, 0, 0)),
        ("UpLeg", "Hips", (9, -6, 0)), ("Leg", "UpLeg", (0, -41, 0)), ("Foot", "Leg", (0, -42, -2)), ("ToeBase", "Foot", (0, -7, 14)))]
TIPS = {"Head": (0, 15, 0), "LeftHand": (18, 0, 0), "RightHand": (-18, 0, 0), "LeftToeBase": (0, 0, 7), "RightToeBase": (0, 0, 7)}


def turns(joint, seconds):
    """Degrees about z, y, x: arms swing, knees bend, the trunk turns."""
    swing = math.sin(2 * math.pi * seconds / 1.7)
    side = 1 if joint.startswith("Left") else -1
    return {"Arm": (-50 * side + 20 * swing, 15 * swing, 0), "ForeArm": (0, -side * (35 + 30 * swing), 0), "UpLeg": (0, 0, -25 * side * swing),
            "Leg": (0, 0, 30 * (1 + side * swing)), "Spine": (4 * swing, 12 * swing, 3)}.get(joint.replace("Left", "").replace("Right", ""), (0, 0, 0))


def write_bvh(path, frames, rate, rows=None):
    """A motion of the rig. `rows`: so many rows of numbers instead of as many as are announced."""
    def block(name, indent):
        offset = next(offset for joint, _, offset in RIG if joint == name)
        root = name == "Hips"
        channels = "6 Xposition Yposition Zposition Zrotation Yrotation Xrotation" if root else "3 Zrotation Yrotation Xrotation"
        lines = [("ROOT " if root else "JOINT ") + name, "{", "\tOFFSET {} {} {}".format(*offset), "\tCHANNELS " + channels]
        order.append(name)
        for child, parent, _ in RIG:
            if parent == name:
                lines += block(child, indent + 1)
        if name in TIPS:
            lines += ["\tEnd Site", "\t{", "\t\tOFFSET {} {} {}".format(*TIPS[name]), "\t}"]
        return ["\t" * min(indent, 1) + line for line in [*lines, "}"]]

    order = []
    text = ["HIERARCHY", *block("Hips", 0), "MOTION", f"Frames: {frames}", f"Frame Time: {1 / rate:.9f}"]
    for frame in range(frames if rows is None else rows):
        values = [0, 95, 20 * frame / rate]
        for joint in order:
            values += turns(joint, frame / rate)
        text.append(" ".join(f"{value:.5f}" for value in values))
    with open(path, "w") as file:
        file.write("\n".join(text) + "\n")


def check_animate(source, build, folder, check):
    scratch = tempfile.TemporaryDirectory(prefix="ndg-animate-")
    out = scratch.name
    body = [f"--template={folder}/template.h5", f"--bodies={folder}/bodies.h5"]

    def run(tool, *arguments):
        """Exit code, both streams, and the largest resident set in MiB."""
        with tempfile.TemporaryFile("w+") as log:
            process = subprocess.Popen([os.path.join(build, "bin", tool), *arguments], stdout=log, stderr=subprocess.STDOUT,
                                       env={**os.environ, "GOMP_SPINCOUNT": "10000"})  # as make has it
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
            log.seek(0)
            return process.returncode, log.read(), usage.ru_maxrss / 1024

    def done(tool, *arguments):
        code, text, memory = run(tool, *arguments)
        if code != 0:
            check(False, f"{tool} {' '.join(arguments)}: {text}")
        return text, memory

    def vertices(path):
        with h5py.File(path) as file:
            return file["deformations/vertices"][:]

    # One rig as captures have it (their first frame is skipped), one without that, which the user maps.
    write_bvh(f"{out}/move.bvh", 41, 40)
    with open(f"{source}/configs/joint-maps/cmu-bvh.json") as file:
        joint_map = json.load(file)
    del joint_map["skip_first_frames"]
    with open(f"{out}/own.json", "w") as file:
        json.dump(joint_map, file)
    own = f"--joint-map={out}/own.json"
    known = f"--joint-maps={source}/configs/joint-maps"

    skinned = ["--method=lbs", "--bone-wrap=lbs"]

    # Directly and in steps.
    for label, rate in (("every frame", ["--frame-rate=0"]), ("37 Hz", ["--frame-rate=37"]), ("100 Hz", ["--frame-rate=100"])):
        done("import-motion", body[0], known, f"--motion={out}/move.bvh", *rate, "--interpolate", f"--output={out}/poses.h5", "--force")
        # Once with rigid bones, otherwise without, which is faster.
        method = ["--method=gradient-skinning"] if label == "37 Hz" else skinned
        done("animate", *body, "--body=1", *method, f"--poses={out}/poses.h5", f"--output={out}/steps.h5", "--force")
        done("animate", *body, "--body=1", *method, f"--motion={out}/move.bvh", *rate, f"--output={out}/direct.h5", "--force")
        check(differing_dataset(f"{out}/steps.h5", f"{out}/direct.h5") == "",
              f"{label}: animate from a BVH gives what import-motion and animate give, {method[0]}")
    frames = len(vertices(f"{out}/direct.h5"))
    check(frames == int(39 / 40 * 100 + 1e-4) + 1, f"a second of motion has 98 frames at 100 Hz ({frames})")
    done("import-motion", body[0], known, f"--motion={out}/move.bvh", "--frame-rate=0", f"--output={out}/plain.h5")
    done("import-motion", body[0], known, f"--motion={out}/move.bvh", "--frame-rate=0", "--interpolate", f"--output={out}/filled.h5")
    with h5py.File(f"{out}/plain.h5") as plain, h5py.File(f"{out}/filled.h5") as filled:
        check((plain["poses/rotations"][:] == filled["poses/rotations"][:]).all(), "poses of a file stay as they are where none is missing")
    # What moves smoothly lies between its neighbours where frames are put in between.
    every = [f"--motion={out}/move.bvh", own, *skinned, *body, "--body=0"]
    done("animate", *every, f"--output={out}/at-40.h5")
    done("animate", *every, "--frame-rate=80", f"--output={out}/at-80.h5")
    slow, fast = vertices(f"{out}/at-40.h5"), vertices(f"{out}/at-80.h5")
    moved = abs(slow[1:] - slow[:-1]).max()
    check(len(slow) == 41 and len(fast) == 81 and (slow == fast[::2]).all(), "twice the rate: frames of the file are every second one, exactly")
    between = abs(fast[1::2] - (slow[1:] + slow[:-1]) / 2).max()
    check(0 < between < 0.1 * moved, f"and the others lie between them (within {1e3 * between:.2f} mm of {1e3 * moved:.1f} mm moved)")

    # What shows a motion is what export-scene makes of its file, byte for byte.
    shown = ["--page", "--mesh", "--picture"]
    names = ["page.html", "skin.pc2", "frames.png"]
    done("animate", *every, "--frame-rate=10", "--surface=skin", "--count=2", "--height=150",
         *[f"{flag}={out}/{name}" for flag, name in zip(shown, names)])
    done("import-motion", body[0], own, f"--motion={out}/move.bvh", "--frame-rate=10", "--interpolate", f"--output={out}/ten.h5")
    done("animate", *body, "--body=0", *skinned, f"--poses={out}/ten.h5", f"--output={out}/ten-lbs.h5")
    done("export-scene", *body, f"--poses={out}/ten.h5", f"--deformations={out}/ten-lbs.h5", "--sample=0", "--frames=0", "--surface=skin",
         "--picture-kind=frames", "--count=2", "--height=150", *[f"{flag}={out}/steps-{name}" for flag, name in zip(shown, names)])
    for name in names:
        with open(f"{out}/{name}", "rb") as one, open(f"{out}/steps-{name}", "rb") as other:
            check(one.read() == other.read(), f"{name}: animate writes what export-scene writes")
    check(not [name for name in os.listdir(out) if ".tmp" in name], "no file of its own is left")

    # Every method.
    files = {"ndg": ["--model", "model.h5"], "vertexnet": ["--model", "vertexnet-model.h5"], "runtime": ["--runtime-model", "model.ndg"],
             "linear-correctives": ["--correctives", "correctives.h5"]}
    text, _ = done("animate", "--list-methods")
    methods = [method for method in text.split() if method != "gradients"]  # of samples that have some, not of motions
    check(len(methods) >= 9, f"methods: {', '.join(methods)}")
    for method in methods:
        flag, name = files.get(method, ("", ""))
        if name and not os.path.exists(f"{folder}/{name}"):
            print(f"skipped {method}: there is no {name}")
            continue
        done("animate", *body, "--body=0", own, f"--motion={out}/move.bvh", "--frame-rate=2", f"--method={method}",
             *([f"{flag}={folder}/{name}"] if name else []), f"--output={out}/{method}.h5", f"--anatomy={out}/{method}-anatomy.h5",
             f"--page={out}/{method}.html", f"--mesh={out}/{method}.glb")
        shape = vertices(f"{out}/{method}.h5").shape
        check(shape[0] == 3 and os.path.getsize(f"{out}/{method}.html") > 500000 and os.path.getsize(f"{out}/{method}.glb") > 100000,
              f"{method}: three frames as vertices, page and GLB")
    difference = abs(vertices(f"{out}/lbs.h5")[0] - vertices(f"{out}/rigid-parts.h5")[0]).max()
    check(difference == 0, "rigid parts have the flesh of linear blend skinning")
    with open(f"{out}/lbs.glb", "rb") as one, open(f"{out}/rigid-parts.glb", "rb") as other:
        check(one.read() != other.read(), "and an anatomy of their own")

    # One frame, none, bad ones: the reason, exit code 2 and nothing left.
    write_bvh(f"{out}/one.bvh", 1, 40)
    done("animate", *body, "--body=0", own, *skinned, f"--motion={out}/one.bvh", "--frame-rate=60", f"--output={out}/one.h5", f"--page={out}/one.html",
         f"--mesh={out}/one.glb", f"--picture={out}/one.png", "--height=100")
    check(len(vertices(f"{out}/one.h5")) == 1, "a motion of one frame is one frame")
    write_bvh(f"{out}/none.bvh", 0, 40)
    write_bvh(f"{out}/short.bvh", 10, 40, rows=7)
    before = sorted(os.listdir(out))
    several = [f"--output={out}/bad.h5", f"--page={out}/bad.html", f"--mesh={out}/bad.glb", f"--picture={out}/bad.png"]
    for name, arguments, told in (
            ("a motion without frames", [own, f"--motion={out}/none.bvh"], "0 frames"),
            ("one whose only frame is skipped", [known, f"--motion={out}/one.bvh"], "one"),
            ("a truncated one", [own, f"--motion={out}/short.bvh"], "short.bvh"),
            ("a good one and a truncated one", [own, f"--motion={out}/move.bvh", f"--motion={out}/short.bvh"], "short.bvh"),
            ("an unknown rig", [f"--joint-map={source}/configs/joint-maps/mixamo.json", f"--motion={out}/move.bvh"], "no joint map fits"),
            ("what is no motion", [own, f"--motion={folder}/template.h5"], "template.h5"),
            ("two kinds of poses", [own, f"--motion={out}/move.bvh", f"--poses={out}/ten.h5"], "--poses"),
            ("neither", [], "--motion")):
        code, text, _ = run("animate", *body, "--body=0", *arguments, *several)
        check(code == 2 and told in text, f"{name}: exit code {code}, {text.strip().splitlines()[-1] if text else ''}")
    code, text, _ = run("animate", *body, own, f"--motion={out}/move.bvh", f"--page={out}/bad.html")
    check(code == 2 and "--body" in text, "a page of all bodies is refused")
    check(sorted(os.listdir(out)) == before, "and nothing is left of any")

    # Memory: poses (60 matrices of 8 bytes and the file's own joints) grow with a motion, vertices do not.
    bound = 10 / 1024  # MiB a frame
    peaks = []
    for frames in (300, 3000):
        write_bvh(f"{out}/long.bvh", frames, 120)
        peaks.append(done("animate", *body, "--body=0", own, f"--motion={out}/long.bvh", *skinned, "--no-inverse-kinematics",
                          f"--output={out}/long.h5", "--surface=skin", f"--mesh={out}/long.pc2", "--force")[1])
    with h5py.File(f"{out}/long.h5") as file:
        of_vertices = 2700 * numpy.prod(file["deformations/vertices"].shape[1:]) * 4 / 1024 ** 2
    check(peaks[1] - peaks[0] < 2700 * bound < 0.5 * of_vertices,
          f"3 000 frames take {peaks[1] - peaks[0]:.0f} MiB more than 300 ({peaks[0]:.0f} MiB); their vertices are {of_vertices:.0f} MiB more")
    scratch.cleanup()


if __name__ == "__main__":
    failures = []
    if not os.path.exists(sys.argv[3] + "/template.h5"):
        print(f"skipped: {sys.argv[3]} is left by the test pipeline_smoke")
        sys.exit(77)

    def report(condition, text):
        print(("ok    " if condition else "FAIL  ") + text, flush=True)
        if not condition:
            failures.append(text)
    check_animate(*sys.argv[1:4], report)
    sys.exit(1 if failures else 0)
