# SPDX-License-Identifier: Apache-2.0
"""What the tests that read exported files back share: a body in motion and export-scene."""
import os
import subprocess
import sys

import h5py  # Debian's python3-h5py
import numpy


class Checks:
    def __init__(self):
        self.failures = []

    def __call__(self, condition, text):
        print(("ok    " if condition else "FAIL  ") + text, flush=True)
        if not condition:
            self.failures.append(text)

    def exit(self):
        sys.exit("\n".join(["", *self.failures]) if self.failures else 0)


class Motion:
    """template.h5, bodies.h5, poses.h5 and samples of one body by two methods, lbs.h5 and bent.h5: a tube whose elbow
    bends; or those of `files` (template, bodies, poses, two methods), which are there."""

    def __init__(self, build, folder, files=None, frames=6):
        self.bin = os.path.join(os.path.abspath(build), "bin")
        self.folder, self.frames = folder, frames
        names = ("template", "bodies", "poses", "lbs", "bent")
        self.files = dict(zip(names, files or [f"{folder}/{name}.h5" for name in names]))
        if files is None:
            run([self.bin + "/small-dataset", folder, "9", "12"])
            with h5py.File(self.files["bodies"], "r+") as file:
                file.attrs["licences"] = "A tube, CC0 1.0\nIts bends, CC BY 4.0"
            for name, method in (("lbs", "lbs"), ("bent", "gradient-skinning")):
                run([self.bin + "/animate", *self.options("template", "bodies", "poses"), "--bone-wrap", "lbs", "--body", "1",
                     "--method", method, "--output", self.files[name]])

    def options(self, *names):
        return [part for name in names for part in (f"--{name}", self.files[name])]

    def export(self, name, *arguments, frames=None):
        """Path of what export-scene makes of the samples' first frames."""
        path = f"{self.folder}/{name}"
        run([self.bin + "/export-scene", *self.options("template", "bodies", "poses"), "--deformations", self.files["bent"],
             "--sample", "0", "--frames", str(frames or self.frames), "--force", "--mesh", path, *arguments])
        return path

    def rate(self):
        """Frames a second, as export-scene takes them."""
        poses = self.read("bent", "deformations/pairs")[:self.frames, 1]
        steps = numpy.diff(self.read("poses", "poses/frame_idx")[poses])
        clips = self.read("poses", "poses/clip_idx")[poses]
        whole = len(set(clips)) == 1 and len(set(steps)) == 1 and steps[0] > 0
        return self.read("poses", "clips/frame_rates")[clips[0]] / steps[0] if whole else 1.5

    def licences(self):
        with h5py.File(self.files["bodies"]) as file:
            return file.attrs["licences"].split("\n")

    def read(self, name, dataset):
        with h5py.File(self.files[name]) as file:
            return file[dataset][...]


def run(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"FAIL  {' '.join(command)}\n{done.stdout}")
    return done.stdout


def skinned(motion, frame, influences=8):
    """The whole skin of a sample by linear blend skinning, from what the files say (float64)."""
    body, pose = motion.read("bent", "deformations/pairs")[frame]
    positions = motion.read("bodies", "bodies/joint_positions")[body].astype(float)
    parents = motion.read("template", "skeleton/parents")
    rotations = motion.read("poses", "poses/rotations")[pose].reshape(-1, 3, 3).astype(float)
    turns, places = numpy.zeros_like(rotations), numpy.zeros_like(positions)
    for joint, parent in enumerate(parents):
        if parent < 0:
            turns[joint] = rotations[joint]
            places[joint] = positions[joint] + motion.read("poses", "poses/root_translations")[pose]
        else:
            turns[joint] = turns[parent] @ rotations[joint]
            places[joint] = places[parent] + turns[parent] @ (positions[joint] - positions[parent])
    joints, weights = (motion.read("template", f"skin/{name}") for name in ("weight_joints", "weights"))
    strongest = numpy.argsort(-weights, axis=1, kind="stable")[:, :influences]
    joints, weights = numpy.take_along_axis(joints, strongest, 1), numpy.take_along_axis(weights, strongest, 1)
    weights = weights / weights.sum(axis=1, keepdims=True)
    rest = motion.read("bodies", "bodies/skin_vertices")[body].astype(float)
    local = rest[:, None] - positions[joints]
    return numpy.einsum("vj,vja->va", weights, numpy.einsum("vjab,vjb->vja", turns[joints], local) + places[joints])
