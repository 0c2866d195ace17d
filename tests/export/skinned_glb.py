#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Skins on skeletons in glTF and USD, moved by numpy as the two formats say, against our own skinning and samples:
skinned_glb.py BUILD [TEMPLATE BODIES POSES SAMPLES OTHER_SAMPLES]. The Khronos validator looks at the GLB where npm's
modules are installed in viewer/."""
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile

import numpy

from exported import Checks, Motion, skinned

COMPONENTS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
TYPES = {5121: numpy.uint8, 5123: numpy.uint16, 5125: numpy.uint32, 5126: numpy.float32}


class Glb:
    def __init__(self, path):
        with open(path, "rb") as file:
            data = file.read()
        length = struct.unpack("<I", data[12:16])[0]
        self.json, self.binary = json.loads(data[20:20 + length]), data[28 + length:]

    def array(self, accessor):
        accessor = self.json["accessors"][accessor]
        view = self.json["bufferViews"][accessor["bufferView"]]
        columns = COMPONENTS[accessor["type"]]
        values = numpy.frombuffer(self.binary, TYPES[accessor["componentType"]], accessor["count"] * columns, view.get("byteOffset", 0))
        return values.reshape(-1, columns) if columns > 1 else values

    def skin_node(self):
        return next(k for k, node in enumerate(self.json["nodes"]) if "skin" in node)

    def moved_skin(self, animation, frame):
        """The skinned mesh at a keyframe, by the glTF 2.0 specification, 3.7.3."""
        nodes = self.json["nodes"]
        local = [(numpy.array(n.get("rotation", [0, 0, 0, 1.0])), numpy.array(n.get("translation", [0, 0, 0.0]))) for n in nodes]
        weights = None
        for channel in animation["channels"]:
            keys = self.array(animation["samplers"][channel["sampler"]]["output"])
            node, path = channel["target"]["node"], channel["target"]["path"]
            if path == "rotation":
                local[node] = (keys[frame].astype(float), local[node][1])
            elif path == "translation":
                local[node] = (local[node][0], keys[frame].astype(float))
            elif node == self.skin_node():
                weights = keys.reshape(-1, len(self.json["meshes"][nodes[node]["mesh"]]["weights"]))[frame].astype(float)
        parents = {child: k for k, node in enumerate(nodes) for child in node.get("children", [])}

        def world(k):
            (x, y, z, w), translation = local[k]
            matrix = numpy.eye(4)
            matrix[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                              [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                              [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]
            matrix[:3, 3] = translation
            return world(parents[k]) @ matrix if k in parents else matrix
        skin = self.json["skins"][nodes[self.skin_node()]["skin"]]
        inverse = self.array(skin["inverseBindMatrices"]).reshape(-1, 4, 4).transpose(0, 2, 1)
        joints = numpy.array([world(k) for k in skin["joints"]]) @ inverse
        primitive = self.json["meshes"][nodes[self.skin_node()]["mesh"]]["primitives"][0]
        attributes = primitive["attributes"]
        points = self.array(attributes["POSITION"]).astype(float)
        if weights is not None:
            for weight, target in zip(weights, primitive["targets"]):
                points = points + weight * self.array(target["POSITION"])
        moved = numpy.zeros_like(points)
        for k in range(sum(name.startswith("JOINTS_") for name in attributes)):
            indices, shares = self.array(attributes[f"JOINTS_{k}"]), self.array(attributes[f"WEIGHTS_{k}"])
            moved += numpy.einsum("vj,vjab,vb->va", shares, joints[indices], numpy.c_[points, numpy.ones(len(points))])[:, :3]
        return moved


check = Checks()
with tempfile.TemporaryDirectory(prefix="ndg-export-") as folder:
    motion = Motion(sys.argv[1], folder, sys.argv[2:] or None)
    body = motion.read("bent", "deformations/pairs")[0, 0]
    exact = [skinned(motion, frame) for frame in range(motion.frames)]
    rest = motion.read("bodies", "bodies/skin_vertices")[body]
    files = []
    for influences, bound in ((8, 1e-5), (4, 5e-3)):
        path = motion.export(f"rig{influences}.glb", "--surface=skin", "--rig=skinning", f"--influences={influences}")
        files.append(path)
        glb = Glb(path)
        clips = glb.json["animations"]
        keys = [(clip, f) for clip in clips for f in range(len(glb.array(clip["samplers"][0]["input"])))]
        check(len(keys) == motion.frames, f"{influences} influences: {len(clips)} clips, {len(keys)} keyframes")
        largest = max(numpy.linalg.norm(glb.moved_skin(*key) - exact[f], axis=1).max() for f, key in enumerate(keys))
        truncated = [skinned(motion, f, influences) for f in range(motion.frames)]
        to_truncated = max(abs(glb.moved_skin(*key) - truncated[f]).max() for f, key in enumerate(keys))
        check(to_truncated < 1e-5, f"{influences} influences: the skinning of glTF gives ours with the same influences, to {1e3 * to_truncated:.5f} mm")
        check(largest < bound, f"{influences} influences: all 8 joints of a vertex move it at most {1e3 * largest:.3f} mm elsewhere")
        names = [glb.json["nodes"][k]["name"] for k in glb.json["skins"][0]["joints"]]
        check(names == [name.decode() for name in motion.read("template", "skeleton/joint_names")], "joints by name")
        asset = glb.json["asset"]
        check(asset["extras"]["units"] == "m" and asset["extras"]["licences"] == asset["copyright"] and
              all(line in asset["copyright"] for line in motion.licences()), f"unit, and {len(motion.licences())} lines of licences")
    check(max(abs(points - rest).max() for points in exact) > 0.05, "the skin moves")

    report = folder + "/bake.json"
    path = motion.export("baked.glb", "--surface=skin", "--rig=morphs", "--morphs=3", f"--bake-report={report}")
    files.append(path)
    with open(report) as file:
        told = json.load(file)
    glb, wraps = Glb(path), motion.read("template", "volume/wrap_to_skin")
    keys = [(clip, f) for clip in glb.json["animations"] for f in range(len(glb.array(clip["samplers"][0]["input"])))]
    for f, key in enumerate(keys):
        wanted = exact[f].copy()
        wanted[wraps] = motion.read("bent", "deformations/vertices")[f, -len(wraps):]
        errors = 1e3 * numpy.linalg.norm(glb.moved_skin(*key) - wanted, axis=1)
        said = told["skinning_with_morphs"]["frame_mean_mm"][f], told["skinning_with_morphs"]["frame_max_mm"][f]
        check(numpy.allclose((errors.mean(), errors.max()), said, atol=5e-3),
              f"frame {f}: morphs come within {errors.mean():.3f} mm, at most {errors.max():.3f} mm, as the report says")
    check(told["skinning_with_morphs"]["mean_mm"] < 0.7 * told["skinning"]["mean_mm"],
          f"3 morphs: {told['skinning']['mean_mm']:.3f} mm become {told['skinning_with_morphs']['mean_mm']:.3f} mm")
    files.append(motion.export("parts.glb", "--surface=parts", "--rig=skinning"))
    files.append(motion.export("motion.glb", "--surface=parts"))

    viewer = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../viewer")
    if shutil.which("node") and os.path.isdir(viewer + "/node_modules/gltf-validator"):
        done = subprocess.run(["node", "validate-glb.mjs", *files], cwd=viewer, stdout=subprocess.PIPE, text=True)
        check(done.returncode == 0 and done.stdout.count(" 0 errors, 0 warnings") == len(files), "the Khronos validator agrees\n" + done.stdout)
    else:
        print("skipped: the Khronos validator (make viewer installs it)")
check.exit()
