# SPDX-License-Identifier: Apache-2.0
"""What Unreal's ML Deformer trains from (docs/export.md): a skinned skin as FBX, the deformed one as Alembic.

blender -b --python-exit-code 1 --python blender_alembic.py -- SKINNED.glb SKIN.obj SKIN.pc2 RATE OUT.fbx OUT.abc"""
import os
import struct
import sys

import bpy
import numpy

numpy.bool = bool  # Debian's importer of glTF is older than Debian's numpy
glb, obj, cache, rate, fbx, abc = sys.argv[sys.argv.index("--") + 1:]


def start():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = round(float(rate))
    scene.render.fps_base = round(float(rate)) / float(rate)
    scene.frame_start, scene.frame_end = 0, num_frames - 1
    return scene


with open(cache, "rb") as file:
    num_frames = struct.unpack("<12siiffi", file.read(32))[5]
start()
bpy.ops.import_scene.gltf(filepath=glb, merge_vertices=False)
bpy.ops.export_scene.fbx(filepath=fbx, add_leaf_bones=False, bake_anim_use_nla_strips=False)
print(f"{fbx}: {len(bpy.data.armatures[0].bones)} bones")

scene = start()
bpy.ops.wm.obj_import(filepath=obj)
skin = bpy.context.selected_objects[0]
modifier = skin.modifiers.new("cache", "MESH_CACHE")
modifier.cache_format, modifier.filepath, modifier.frame_start = "PC2", os.path.abspath(cache), 0
if not bpy.app.build_options.alembic:
    sys.exit(f"{abc}: this Blender is built without Alembic (Debian's is; that of blender.org has it)")
bpy.ops.wm.alembic_export(filepath=abc, start=0, end=num_frames - 1, global_scale=100, flatten=True)
print(f"{abc}: {num_frames} frames")
