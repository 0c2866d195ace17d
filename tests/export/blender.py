#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""GLB files, and OBJ with a point cache, as Blender imports them: blender.py BUILD [TEMPLATE BODIES POSES SAMPLES OTHER_SAMPLES]. Vertices of its evaluated
meshes at the frames of the clip, against samples and our own skinning. Exits 77 (skipped) without Blender (apt-get install
blender)."""
import shutil
import subprocess
import sys
import tempfile

import numpy

from exported import Checks, Motion, skinned

READER = """
import bpy, numpy, sys
numpy.bool = bool  # Debian's importer is older than Debian's numpy
path, target, frames = sys.argv[-3:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
scene = bpy.context.scene
for item in list(bpy.data.objects):  # the importer leaves each clip in a track of the object
    for data in (item, item.data.shape_keys if item.type == "MESH" else None):
        if data is not None and data.animation_data is not None:
            for track in data.animation_data.nla_tracks:
                track.mute = False
rate, arrays = scene.render.fps / scene.render.fps_base, {}
for frame, time in enumerate(float(t) for t in frames.split(",")):
    place = time * rate
    scene.frame_set(int(place), subframe=place - int(place))
    graph = bpy.context.evaluated_depsgraph_get()
    for item in bpy.data.objects:
        if item.type != "MESH" or item.data.name.startswith("Icosphere"):
            continue
        evaluated = item.evaluated_get(graph)
        mesh = evaluated.to_mesh()
        points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
        mesh.vertices.foreach_get("co", points)
        points = points.reshape(-1, 3) @ numpy.array(evaluated.matrix_world.to_3x3()).T + numpy.array(evaluated.matrix_world.translation)
        arrays[f"{frame}/{item.data.name}"] = numpy.stack([points[:, 0], points[:, 2], -points[:, 1]], 1)  # z up to y up
        evaluated.to_mesh_clear()
numpy.savez(target, **arrays)
"""


CACHE_READER = """
import bpy, numpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
obj, cache, target = sys.argv[-3:]
bpy.ops.wm.obj_import(filepath=obj)
skin = bpy.context.selected_objects[0]
modifier = skin.modifiers.new("cache", "MESH_CACHE")
modifier.cache_format, modifier.filepath, modifier.frame_start = "PC2", cache, 0
arrays = []
for frame in range(6):
    bpy.context.scene.frame_set(frame)
    mesh = skin.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    points = numpy.empty(3 * len(mesh.vertices), numpy.float32)
    mesh.vertices.foreach_get("co", points)
    arrays.append(points.reshape(-1, 3))
numpy.savez(target, points=arrays)
"""


def run_blender(script, *arguments):
    done = subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "1", "--python-expr", script, "--", *arguments],
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
        sys.exit("FAIL  " + done.stdout)


def read(path, rate, frames):
    """Points of every mesh by frame and name, y up."""
    target = path + ".npz"
    run_blender(READER, path, target, ",".join(str(frame / rate) for frame in frames))
    return numpy.load(target)


check = Checks()
if not shutil.which("blender"):
    print("skipped: Blender is not there (apt-get install blender)")
    sys.exit(77)
with tempfile.TemporaryDirectory(prefix="ndg-export-") as folder:
    motion = Motion(sys.argv[1], folder, sys.argv[2:] or None)
    deformed = motion.read("bent", "deformations/vertices").astype(float)
    wraps = motion.read("template", "volume/wrap_to_skin")
    num_wrap, frames, rate = len(wraps), range(0, motion.frames, 2), motion.rate()
    anatomy = read(motion.export("anatomy.glb", "--surface=parts"), rate, frames)
    alone = read(motion.export("skinned.glb", "--surface=skin", "--rig=skinning"), rate, frames)
    baked = read(motion.export("baked.glb", "--surface=skin", "--rig=morphs", "--morphs=3"), rate, frames)
    obj = motion.export("skin.obj", "--surface=skin", frames=1)
    run_blender(CACHE_READER, obj, motion.export("skin.pc2", "--surface=skin"), folder + "/cache.npz")
    cached = numpy.load(folder + "/cache.npz")["points"]
    parts = {name: range_ for name, range_ in zip((n.decode() for n in motion.read("template", "anatomy/part_names")),
                                                  motion.read("template", "anatomy/part_ranges"))}
    for k, frame in enumerate(frames):
        body = skinned(motion, frame)
        body[wraps] = deformed[frame, 2 * num_wrap:]
        check(abs(anatomy[f"{k}/skin"] - body).max() < 1e-4 and
              abs(anatomy[f"{k}/muscle_wrap"] - deformed[frame, num_wrap:2 * num_wrap]).max() < 1e-4,
              f"frame {frame}: skin and muscle wrap are those of the samples, to {1e3 * abs(anatomy[f'{k}/skin'] - body).max():.4f} mm")
        check(abs(cached[frame] - body).max() < 2e-6, f"frame {frame}: a mesh cache of the .pc2 moves the .obj there")
        found = [name for name in parts if f"{k}/{name[:63]}" in anatomy and len(anatomy[f"{k}/{name[:63]}"]) == parts[name][1] - parts[name][0]]
        check(len(found) == len(parts), f"frame {frame}: {len(found)} of {len(parts)} bones and muscles are meshes of their names")
        error = abs(alone[f"{k}/skin"] - skinned(motion, frame, 4)).max()
        check(error < 1e-4, f"frame {frame}: the skinned skin is where our skinning with 4 influences puts it, to {1e3 * error:.4f} mm")
        with_morphs, without = (numpy.linalg.norm(points[f"{k}/skin"] - body, axis=1).mean() for points in (baked, alone))
        check(with_morphs <= 0.7 * without + 1e-6, f"frame {frame}: morphs bring it from {1e3 * without:.3f} to {1e3 * with_morphs:.3f} mm")
check.exit()
