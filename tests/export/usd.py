#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""USD as text, read by a parser of its own and, where npm's modules are installed in viewer/, by TinyUSDZ: usd.py BUILD [TEMPLATE BODIES POSES SAMPLES
OTHER_SAMPLES]. Skins on skeletons are moved as UsdSkel says and held against our own skinning, points over time against the
samples."""
import os
import re
import shutil
import subprocess
import sys
import tempfile

import numpy

from exported import Checks, Motion, skinned

TOKENS = re.compile(r"""\s*(?:"((?:[^"\\]|\\.)*)"|<([^>]*)>|([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?![\w:])|([A-Za-z_][\w:.]*(?:\[\])?)|(\S))""")


class Prim(dict):
    """Attributes by name; children by name."""
    def __init__(self, kind, name):
        super().__init__()
        self.kind, self.name, self.children, self.metadata = kind, name, {}, {}

    def __getattr__(self, name):
        return self.children[name]


class Parser:
    """What usda.cpp writes of the language; anything else is an error."""
    def __init__(self, text):
        header, body = text.split("\n", 1)
        assert header == "#usda 1.0", header
        self.tokens = [match.groups() for match in TOKENS.finditer(body) if match.group().strip()]
        self.at = 0

    def peek(self):
        return next(part for part in self.tokens[self.at] if part is not None) if self.at < len(self.tokens) else None

    def next(self, expected=None):
        token = self.peek()
        self.at += 1
        assert expected is None or token == expected, f"{token} instead of {expected}"
        return token

    def value(self):
        string, path, number, _, mark = self.tokens[self.at]
        if mark in ("[", "("):
            self.next()
            values, end = [], {"[": "]", "(": ")"}[mark]
            while self.peek() != end:
                values.append(self.value())
                if self.peek() == ",":
                    self.next()
            self.next()
            return values
        if mark == "{":
            return self.dictionary("}")
        token = self.next()
        return float(number) if number is not None else token

    def dictionary(self, end):
        """Time samples, or metadata with types or without."""
        self.next()
        entries = {}
        while self.peek() != end:
            words = []
            while self.peek() not in ("=", ":"):
                words.append(self.next())
            self.next()
            entries[words[-1]] = self.value()
            if self.peek() == ",":
                self.next()
        self.next()
        return entries

    def prim(self):
        self.next("def")
        prim = Prim(self.next(), self.next())
        if self.peek() == "(":
            prim.metadata = self.dictionary(")")
        self.next("{")
        while self.peek() != "}":
            if self.peek() == "def":
                child = self.prim()
                prim.children[child.name] = child
                continue
            words = []
            while self.peek() != "=":
                words.append(self.next())
            self.next()
            value = self.value()
            if self.peek() == "(":
                self.dictionary(")")
            if words[-1].endswith(".timeSamples"):
                value = [numpy.array(value[str(k)]) for k in range(len(value))]
            prim[words[-1]] = numpy.array(value) if isinstance(value, list) and not words[-1].endswith("timeSamples") else value
        self.next("}")
        return prim

    def stage(self):
        metadata = self.dictionary(")") if self.peek() == "(" else {}
        root = self.prim()
        assert self.peek() is None
        root.metadata = metadata
        return root


def rotation_rows(quaternions):
    """As USD multiplies: points are rows. w, x, y, z."""
    w, x, y, z = quaternions.T
    return numpy.stack([1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w), 2 * (x * y - z * w), 1 - 2 * (x * x + z * z),
                        2 * (y * z + x * w), 2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)], 1).reshape(-1, 3, 3)


def moved_skin(stage, frame):
    """By the schema of UsdSkel: skel-space transforms from the local ones of the animation, row vectors."""
    mesh, skeleton, animation = stage.skin, stage.skeleton, stage.skeleton.motion
    joints = list(animation["joints"])
    local = numpy.tile(numpy.eye(4), (len(joints), 1, 1))
    local[:, :3, :3] = rotation_rows(animation["rotations.timeSamples"][frame])
    local[:, 3, :3] = animation["translations.timeSamples"][frame]
    world = []
    for k, path in enumerate(joints):
        parent = path.rpartition("/")[0]
        world.append(local[k] @ world[joints.index(parent)] if parent else local[k])
    moves = numpy.linalg.inv(skeleton["bindTransforms"]) @ numpy.array(world)
    points = mesh["points"]
    if "skel:blendShapes" in mesh:
        for name, weight in zip(animation["blendShapes"], animation["blendShapeWeights.timeSamples"][frame]):
            points = points + weight * mesh.children[name]["offsets"]
    points = numpy.c_[points, numpy.ones(len(points))] @ mesh["primvars:skel:geomBindTransform"]
    indices = mesh["primvars:skel:jointIndices"].astype(int).reshape(len(points), -1)
    weights = mesh["primvars:skel:jointWeights"].reshape(len(points), -1)
    return numpy.einsum("vj,va,vjab->vb", weights, points, moves[indices])[:, :3]


def shown_points(mesh, frame):
    """Of a mesh with points over time, or moved as a whole."""
    if "points.timeSamples" in mesh:
        return mesh["points.timeSamples"][frame]
    if "xformOp:transform.timeSamples" not in mesh:
        return mesh["points"]
    assert list(mesh["xformOpOrder"]) == ["xformOp:transform"]
    return (numpy.c_[mesh["points"], numpy.ones(len(mesh["points"]))] @ mesh["xformOp:transform.timeSamples"][frame])[:, :3]


check = Checks()
with tempfile.TemporaryDirectory(prefix="ndg-export-") as folder:
    motion = Motion(sys.argv[1], folder, sys.argv[2:] or None)
    paths = {name: motion.export(name + ".usda", *options) for name, options in
             {"points": ["--surface=all"], "skinned": ["--surface=all", "--rig=skinning", "--influences=8"],
              "baked": ["--surface=skin", "--rig=morphs", "--morphs=3"], "parts": ["--surface=parts"]}.items()}
    stages = {}
    for name, path in paths.items():
        with open(path) as file:
            stages[name] = Parser(file.read()).stage()
        told = stages[name].metadata
        check(told["metersPerUnit"] == 1 and told["upAxis"] == "Y" and told["endTimeCode"] == motion.frames - 1 and
              all(line in told["customLayerData"]["licences"] for line in motion.licences()) and told["defaultPrim"] == "body", f"{name}: metre, y up, times, licences")
    deformed = motion.read("bent", "deformations/vertices").astype(float)
    wrap_to_skin = motion.read("template", "volume/wrap_to_skin")
    num_wrap = len(wrap_to_skin)
    for frame in range(motion.frames):
        exact = skinned(motion, frame)
        body = exact.copy()
        body[wrap_to_skin] = deformed[frame, 2 * num_wrap:]
        check(abs(shown_points(stages["points"].skin, frame) - body).max() < 2e-6 and
              abs(shown_points(stages["points"].muscle_wrap, frame) - deformed[frame, num_wrap:2 * num_wrap]).max() < 2e-6,
              f"frame {frame}: points over time are those of the samples")
        check(abs(moved_skin(stages["skinned"], frame) - exact).max() < 1e-5, f"frame {frame}: the skinning of UsdSkel gives ours")
        check(abs(shown_points(stages["skinned"].bone_wrap, frame) - deformed[frame, :num_wrap]).max() < 2e-6,
              f"frame {frame}: the wraps beside the skeleton are those of the samples")
        errors = numpy.linalg.norm(moved_skin(stages["baked"], frame) - body, axis=1)
        alone = numpy.linalg.norm(skinned(motion, frame, 4) - body, axis=1)
        check(errors.mean() <= 0.7 * alone.mean() + 1e-6, f"frame {frame}: 3 blend shapes, {1e3 * alone.mean():.3f} mm become {1e3 * errors.mean():.3f} mm")
    mesh = stages["points"].skin
    check((mesh["faceVertexIndices"].reshape(-1, 3) == motion.read("template", "skin/triangles")).all() and
          (mesh["faceVertexCounts"] == 3).all(), "the skin's triangles")
    joints = list(stages["skinned"].skeleton["joints"])
    parents = motion.read("template", "skeleton/parents")
    check([path.rpartition("/")[2] for path in joints] == [name.decode() for name in motion.read("template", "skeleton/joint_names")]
          and all(path.rpartition("/")[0] == (joints[parent] if parent >= 0 else "") for path, parent in zip(joints, parents)),
          "joints by their paths")
    rest_world = numpy.array([stages["skinned"].skeleton["restTransforms"][k] for k in range(len(joints))])
    for k, parent in enumerate(parents):
        if parent >= 0:
            rest_world[k] = rest_world[k] @ rest_world[parent]
    check(abs(rest_world - stages["skinned"].skeleton["bindTransforms"]).max() < 1e-6, "rest and bind transforms agree")
    bones = [mesh for mesh in stages["parts"].bones.children.values()]
    check(bones and all("xformOp:transform.timeSamples" in mesh or "points.timeSamples" in mesh for mesh in bones),
          f"{len(bones)} bones, each a mesh that moves")
    viewer = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../viewer")
    if shutil.which("node") and os.path.isdir(viewer + "/node_modules/tinyusdz"):
        done = subprocess.run(["node", "read-usd.mjs", *paths.values()], cwd=viewer, stdout=subprocess.PIPE, text=True)
        counts = [int(count) for count in re.findall(r": (\d+) meshes", done.stdout)]
        parts = len(motion.read("template", "anatomy/part_names")) + 3
        check(done.returncode == 0 and counts[2:] == [1, parts], "TinyUSDZ reads them\n" + done.stdout)
    else:
        print("skipped: TinyUSDZ (make viewer installs it)")
check.exit()
