# SPDX-License-Identifier: Apache-2.0
"""A soft-tissue avatar of the first body of a smoke run."""
import os
import subprocess

import h5py
import numpy


def check_avatar(make, environment, out, build, check):
    """make: the command with its variables; check(condition, text)."""
    path = f"{out}/avatar/body_0000.h5"
    run = subprocess.run(make + [path], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env=environment)
    check(run.returncode == 0, "an avatar of the first body is made")
    if run.returncode != 0:
        print(run.stdout[-3000:])
        return
    made = os.stat(path).st_mtime_ns
    again = subprocess.run(make + [path], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    check(again.returncode == 0 and os.stat(path).st_mtime_ns == made, "it is not made a second time")
    for name in (f"{out}/statistical_body.h5", path):
        info = subprocess.run([os.path.join(build, "bin", "ndg-info"), "--check", name], stdout=subprocess.DEVNULL)
        check(info.returncode == 0, f"ndg-info --check finds nothing wrong with {os.path.basename(name)}")
    with h5py.File(path) as file, h5py.File(f"{out}/bodies.h5") as bodies:
        rest, tetrahedra = file["volume/vertices"][:], file["volume/tetrahedra"][:]
        a, b, c, d = (rest[tetrahedra[:, k]] for k in range(4))
        volumes = numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6
        check(volumes.min() > 0, "no tetrahedron is inverted")
        check(0.005 < volumes.sum() < 0.08, f"the soft tissue has {1e3 * volumes.sum():.1f} litres")
        outer, inner = rest[file["layer/outer_vertices"][:]], rest[: len(file["layer/skin_vertices"])]
        thickness = numpy.linalg.norm(outer - inner, axis=1)
        check(abs(thickness - file["layer/thickness"][:]).max() < 1e-9, "inner vertices lie as deep as the file says")
        check(0.01 < thickness.mean() < 0.03 + 1e-9, "thickness is what was asked for where there is room")
        difference = numpy.linalg.norm(file["skin/vertices"][:] - bodies["bodies/skin_vertices"][0], axis=1)
        check(difference.mean() < 0.004, f"the skin by shape is {1e3 * difference.mean():.1f} mm from the body's")
        check(abs(file["volume/weights"][:].sum(axis=1) - 1).max() < 1e-6, "weights sum to one")
