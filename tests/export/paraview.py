#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""XDMF as ParaView reads it, against what h5py finds: paraview.py BUILD [TEMPLATE BODIES POSES SAMPLES REFERENCE]. Exits 77
(skipped) without ParaView's Python (apt-get install paraview python3-paraview)."""
import shutil
import subprocess
import sys
import tempfile

import numpy

from exported import Checks, Motion

READER = """
import sys, numpy
from paraview import servermanager
from paraview.simple import XDMFReader
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet
reader = XDMFReader(FileNames=[sys.argv[1]])
reader.UpdatePipelineInformation()
arrays = {"times": numpy.array(reader.TimestepValues)}
for frame, time in enumerate(reader.TimestepValues):
    reader.UpdatePipeline(time)
    iterator = servermanager.Fetch(reader).NewIterator()
    iterator.InitTraversal()
    while not iterator.IsDoneWithTraversal():
        grid = iterator.GetCurrentDataObject()
        name = iterator.GetCurrentMetaData().Get(vtkCompositeDataSet.NAME()).split("[")[0]
        key = f"{frame}/{name}"
        arrays[key + "/points"] = vtk_to_numpy(grid.GetPoints().GetData())
        arrays[key + "/cells"] = vtk_to_numpy(grid.GetCells().GetConnectivityArray())
        arrays[key + "/types"] = vtk_to_numpy(grid.GetCellTypesArray())
        for kind, data in (("point", grid.GetPointData()), ("cell", grid.GetCellData())):
            for k in range(data.GetNumberOfArrays()):
                arrays[f"{key}/{kind}/{data.GetArrayName(k)}"] = vtk_to_numpy(data.GetArray(k))
        iterator.GoToNextItem()
numpy.savez(sys.argv[2], **arrays)
"""
VTK_TETRA, VTK_WEDGE = 10, 13


def tetrahedron_volumes(points, cells):
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    return numpy.einsum("ij,ij->i", numpy.cross(b - a, c - a), d - a) / 6


def wedge_volumes(points, cells):
    """With bilinear sides: the mean of both ways to cut each of them in two."""
    o, i = points[cells[:, :3]].transpose(1, 0, 2), points[cells[:, 3:]].transpose(1, 0, 2)

    def cone(a, b, c):  # of a triangle with the origin
        return numpy.einsum("ij,ij->i", numpy.cross(a, b), c) / 6
    volume = cone(o[0], o[1], o[2]) - cone(i[0], i[1], i[2])
    for k in range(3):
        a, b, c, d = o[k], o[(k + 1) % 3], i[(k + 1) % 3], i[k]
        volume -= (cone(a, b, c) + cone(a, c, d) + cone(a, b, d) + cone(b, c, d)) / 2
    return volume


def gradient_determinants(rest, deformed, cells):
    """det of the affine map that fits the wedge's deformation best: least squares over the reference wedge (NDG 3.1)."""
    masses = numpy.kron([[1 / 3, 1 / 6], [1 / 6, 1 / 3]], (numpy.ones((3, 3)) + numpy.eye(3)) / 24)
    root = numpy.linalg.cholesky(masses).T
    determinants = numpy.empty(len(cells))
    for k, cell in enumerate(cells):
        affine = numpy.concatenate([rest[cell], numpy.ones((6, 1))], axis=1)
        determinants[k] = numpy.linalg.det(numpy.linalg.lstsq(root @ affine, root @ deformed[cell], rcond=None)[0][:3])
    return determinants


check = Checks()
if not shutil.which("pvpython"):
    print("skipped: ParaView's Python is not there (apt-get install paraview python3-paraview)")
    sys.exit(77)
with tempfile.TemporaryDirectory(prefix="ndg-export-") as folder:
    motion = Motion(sys.argv[1], folder, sys.argv[2:] or None)
    path = motion.export("x.xdmf", "--reference", motion.files["lbs"])
    done = subprocess.run(["pvpython", "-c", READER, path, folder + "/read.npz"], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, text=True)
    check(done.returncode == 0 and "ERR" not in done.stdout, "ParaView reads the file without a complaint " + done.stdout)
    with open(path) as file:
        text = file.read()
        check(all(line in text for line in motion.licences()), "the licences of the data are there")
    read = numpy.load(folder + "/read.npz")
    check(len(read["times"]) == motion.frames and numpy.allclose(numpy.diff(read["times"]), numpy.diff(read["times"])[0]),
          f"{len(read['times'])} times, equally far apart")

    prisms, tetrahedra = motion.read("template", "volume/prisms"), motion.read("template", "bone_interior/tetrahedra")
    body = motion.read("bent", "deformations/pairs")[0, 0]
    rest, inside = (motion.read("bodies", f"bodies/{name}_vertices")[body].astype(float) for name in ("volume", "interior"))
    num_wrap = len(rest) // 3
    rest_interior = numpy.concatenate([rest[:num_wrap], inside])
    deformed, reference = (motion.read(name, "deformations/vertices").astype(float) for name in ("bent", "lbs"))
    moved = 0.0
    for frame in range(motion.frames):
        def field(name):
            return read[f"{frame}/{name}"]
        flesh, bone = f"frame {frame}: flesh", f"frame {frame}: inside the bone wrap"
        check((field("flesh/types") == VTK_WEDGE).all() and (field("flesh/cells").reshape(-1, 6) == prisms).all(),
              f"{flesh}: the wedges are the template's prisms")
        check((field("flesh/points") == deformed[frame]).all(), f"{flesh}: points are those of the samples")
        check(numpy.allclose(field("flesh/point/error"), numpy.linalg.norm(deformed[frame] - reference[frame], axis=1), atol=1e-7),
              f"{flesh}: error is the distance to the reference")
        change = wedge_volumes(deformed[frame], prisms) / wedge_volumes(rest, prisms) - 1
        check(numpy.allclose(field("flesh/cell/volume_change"), change, atol=1e-4), f"{flesh}: change of volume")
        few = slice(None, None, max(1, len(prisms) // 300))
        check(numpy.allclose(field("flesh/cell/determinant")[few], gradient_determinants(rest, deformed[frame], prisms[few]),
                             atol=1e-4), f"{flesh}: determinants")
        muscle = numpy.arange(len(prisms)) < len(prisms) // 2
        check((field("flesh/cell/layer") == numpy.where(muscle, 1, 2)).all() and
              (field("flesh/cell/young_modulus") == numpy.where(muscle, 45e3, 15e3)).all(), f"{flesh}: layer and stiffness")
        check((field("bone_interior/types") == VTK_TETRA).all() and
              (field("bone_interior/cells").reshape(-1, 4) == tetrahedra).all(), f"{bone}: tetrahedra")
        points = field("bone_interior/points").astype(float)
        check((points[:num_wrap] == deformed[frame, :num_wrap]).all(), f"{bone}: begins with the bone wrap")
        volumes = tetrahedron_volumes(rest_interior, tetrahedra)
        some = volumes > 1e-9
        ratio = tetrahedron_volumes(points, tetrahedra)[some] / volumes[some]
        check(numpy.allclose(field("bone_interior/cell/determinant")[some], ratio, atol=1e-2) and
              (field("bone_interior/cell/layer") == 0).all(), f"{bone}: determinants and layer")
        moved = max(moved, abs(change).max(), field("flesh/point/error").max())
    check(moved > 1e-3, "there is something to see")
check.exit()
