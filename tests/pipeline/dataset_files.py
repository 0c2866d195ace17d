# SPDX-License-Identifier: Apache-2.0
"""What the tests of datasets as processes share: a small dataset, runs of tools, comparison of samples."""
import os
import subprocess

import h5py  # Debian's python3-h5py
import numpy


class Dataset:
    """template.h5, bodies.h5, poses.h5 and splits.h5 in a folder; where they are missing, 43 pairs of tubes that take a few
    hundredths of a second each."""

    def __init__(self, build, folder, rings=20, segments=20):
        self.bin = os.path.join(os.path.abspath(build), "bin")
        self.folder = folder
        self.splits = folder + "/splits.h5"
        if not os.path.exists(self.splits):
            subprocess.run([self.bin + "/small-dataset", folder, str(rings), str(segments)], check=True)
        with h5py.File(self.splits, "r") as file:
            self.samples = sum(len(split["pairs"]) for split in file["splits"].values())

    def simulate_command(self, output, *arguments):
        files = [part for name in ("template", "bodies", "poses", "splits")
                 for part in (f"--{name}", f"{self.folder}/{name}.h5")]
        return [self.bin + "/simulate-fem", *files, "--output", output, *arguments]

    def simulate(self, output, *arguments, **options):
        return run(self.simulate_command(output, *arguments), **options)

    def collect(self, output, *arguments):
        return run([self.bin + "/collect-samples", "--splits", self.splits, "--output", output, *arguments])


def run(command, **options):
    """Exit code and both streams."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    return done.returncode, done.stdout


def difference(one, other):
    """'' where two files hold the same samples bit for bit, timings apart."""
    with h5py.File(one, "r") as a, h5py.File(other, "r") as b:
        for name in ("deformations/vertices", "deformations/pairs", "deformations/splits", "deformations/stop_reasons"):
            if not numpy.array_equal(a[name][...], b[name][...]):
                return name
        if set(a["statistics"]) != set(b["statistics"]):
            return "names of statistics"
        for name in a["statistics"]:
            if name != "seconds" and not numpy.array_equal(a["statistics"][name][...], b["statistics"][name][...]):
                return name
    return ""


def differing_dataset(one, other, is_left_out=lambda name: False):
    """'' where two files hold the same datasets bit for bit, whatever their attributes say; otherwise a name."""
    def datasets(file):
        found = {}
        file.visititems(lambda name, item: found.update({name: item[...]}) if isinstance(item, h5py.Dataset) else None)
        return found
    with h5py.File(one, "r") as a, h5py.File(other, "r") as b:
        left, right = datasets(a), datasets(b)
    if set(left) != set(right):
        return "names of datasets"
    return next((name for name in left if not is_left_out(name) and not numpy.array_equal(left[name], right[name])), "")


def as_motions(poses, lengths):
    """Makes motions of so many of a file's poses, "motion 0" and so on, the last one of all that are left."""
    with h5py.File(poses, "r+") as file:
        count = len(file["poses/clip_idx"])
        clips = [next((c for c, end in enumerate(numpy.cumsum(lengths)) if i < end), len(lengths) - 1) for i in range(count)]
        file["poses/clip_idx"][...] = clips
        file["poses/frame_idx"][...] = [i - clips.index(clip) for i, clip in enumerate(clips)]
        for name, values in (("names", [f"motion {c}" for c in range(len(lengths))]), ("frame_rates", [30.0] * len(lengths))):
            kind = file["clips/" + name].dtype
            del file["clips/" + name]
            file.create_dataset("clips/" + name, data=values, dtype=kind)


def same_dynamics(one, other):
    """Datasets alike bit for bit, timings apart."""
    def datasets(path):
        found = {}
        with h5py.File(path, "r") as file:
            file.visititems(lambda name, item: found.update({name: item[...]}) if isinstance(item, h5py.Dataset) else None)
        found.pop("statistics/seconds")
        return found
    left, right = datasets(one), datasets(other)
    return set(left) == set(right) and all(numpy.array_equal(left[name], right[name]) for name in left)


def parts(output):
    """Finished items of a run under way."""
    folder = output + ".parts"
    return [name for name in os.listdir(folder) if name.endswith(".h5")] if os.path.isdir(folder) else []
