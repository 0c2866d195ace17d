# SPDX-License-Identifier: Apache-2.0
"""What the tests that read exported files back share: a body in motion and export-scene."""
import os
import subprocess
import sys

import h5py  # Debian's python3-h5py


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
            for name, method in (("lbs", "lbs"), ("bent", "gradient-skinning")):
                run([self.bin + "/animate", *self.options("template", "bodies", "poses"), "--bone-wrap", "lbs", "--body", "1",
                     "--method", method, "--output", self.files[name]])

    def options(self, *names):
        return [part for name in names for part in (f"--{name}", self.files[name])]

    def export(self, name, *arguments, samples="bent"):
        """Path of what export-scene makes of the samples' first frames."""
        path = f"{self.folder}/{name}"
        run([self.bin + "/export-scene", *self.options("template", "bodies", "poses"), "--deformations", self.files[samples],
             "--sample", "0", "--frames", str(self.frames), "--force", "--mesh", path, *arguments])
        return path

    def read(self, name, dataset):
        with h5py.File(self.files[name]) as file:
            return file[dataset][...]


def run(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit(f"FAIL  {' '.join(command)}\n{done.stdout}")
    return done.stdout
